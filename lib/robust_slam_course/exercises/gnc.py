"""Pictures of 05-gnc: weights that harden, schedules, and two runs of the loop.

Every function takes a student's own, of the same name, and draws it dashed or as markers
over the library's, which is broad and grey. u is a whitened residual, without unit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from robust_slam.estimators import graduation as library
from robust_slam.palette import MARKERS, PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import draw_beside, once_it_works, panel
from robust_slam_course.style import LOOKS

Weight = Callable[[ArrayLike, float, float], ArrayLike]
History = Mapping[str, ArrayLike]
Loop = Callable[..., tuple[float, ArrayLike, History]]

Z = np.array([0.1, -0.2, 0.15, -0.1, 5.0])  # the lesson's readings, the last one an outlier
_KINDS: tuple[library.Kind, ...] = ("tls", "gm")


@once_it_works
def gnc_tls_weight(weight: Weight) -> Figure:
    """Draw the TLS weight for a soft, a middle and a hard μ."""
    title = "As μ grows, the bend closes in on c = 1"
    return _weights(weight, library.tls_weight, (0.1, 1.0, 10.0), title)


@once_it_works
def gnc_gm_weight(weight: Weight) -> Figure:
    """Draw the Geman–McClure weight for a soft, a middle and the last μ."""
    title = "As μ falls to 1, far residuals lose their say"
    return _weights(weight, library.gm_weight, (30.0, 5.0, 1.0), title)


@once_it_works
def start_mu(start: Callable[[float, float, str], float]) -> Figure:
    """Draw the first μ of both kinds against the largest residual."""
    figure, ax = panel("The larger the worst residual, the softer the start")
    size = np.geomspace(0.3, 30.0, 61)
    for kind, look in zip(_KINDS, LOOKS[1:], strict=False):
        truth = [library.start_mu(u, 1.0, kind) for u in size]
        yours = [float(start(float(u), 1.0, kind)) for u in size]
        draw_beside(ax, size, truth, yours)
        ax.lines[-1].set(color=look.color, label=f'yours, "{kind}"')
    ax.axvspan(size[0], np.sqrt(0.5), color=PALETTE["muted"], alpha=0.12, linewidth=0.0)
    ax.text(0.32, 2e-3, "TLS: nothing\nto reject", fontsize=9.0)
    ax.set(xscale="log", yscale="log", xlabel="largest |u|, with c = 1", ylabel="first μ")
    ax.legend()
    return figure


@once_it_works
def mu_schedule(schedule: Callable[[float, float, int, str], ArrayLike]) -> Figure:
    """Draw both schedules of data A, from its own first μ."""
    figure, ax = panel("TLS climbs without end, GM comes down to 1 and stops")
    for kind, look in zip(_KINDS, LOOKS[1:], strict=False):
        rule, first = library.RULES[kind](2.0), library.start_mu(7.5, 2.0, kind)
        truth = [first]
        while len(truth) < 21 and (kind == "tls" or truth[-1] > 1.0):
            truth.append(rule.next(truth[-1], np.empty(0), np.empty(0)))
        yours = np.asarray(schedule(first, 1.4, 21, kind), dtype=float)
        draw_beside(ax, np.arange(len(truth)), truth, yours)
        ax.lines[-1].set(
            color=look.color, linestyle="", marker=look.marker, label=f'yours, "{kind}"'
        )
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(yscale="log", xlabel="solve", ylabel="μ")
    ax.legend()
    return figure


@once_it_works
def gnc(loop: Loop) -> Figure:
    """Draw the weights and x of both kinds on the lesson's readings, solve by solve."""
    figure = Figure(figsize=(5.6, 4.8))
    panels = figure.subplots(2, 2, sharex="col", sharey="row")
    for kind, (top, bottom) in zip(_KINDS, panels.T, strict=True):
        run = library.gnc(LocationProblem(Z, 0.3), 2.0, kind).history[1:]
        _, _, history = loop(Z.copy(), 0.3, 2.0, 1.4, kind)
        solves = np.arange(1, len(run) + 1)
        yours = np.asarray(history["weights"], dtype=float)
        for k in range(Z.size):
            name = "outlier" if k == Z.size - 1 else "inlier"
            draw_beside(top, solves, [step.weights[k] for step in run], yours[:, k])
            top.lines[-1].set(color=PALETTE[name], marker=MARKERS[name], markersize=4.0)
        draw_beside(bottom, solves, [step.x for step in run], history["x"])
        bottom.lines[-1].set(marker=MARKERS["estimate"], markersize=4.0)
        top.set(title=f'"{kind}"')
        bottom.xaxis.set_major_locator(MaxNLocator(integer=True))
        bottom.set(xlabel="solve")
    panels[0, 0].set(ylabel="weights; the outlier: ✕")
    panels[1, 0].set(ylabel="x")
    figure.suptitle("The outlier loses its weight first, and x follows the four", fontsize=11.0)
    return figure


@once_it_works
def repaired_gnc(repaired: Callable[[ArrayLike, float], tuple[float, ArrayLike]]) -> Figure:
    """Draw the steps of the listing on the lesson's readings, and the end of the fixed one."""
    figure, ax = panel("The listing walks to the mean; does yours?")
    steps = np.arange(1, 41)
    truth = library.gnc(LocationProblem(Z), 1.0).x
    yours = float(repaired(Z.copy(), 1.0)[0])
    ax.plot(steps, _listing(steps.size), "-", color=PALETTE["outlier"], label="the listing")
    draw_beside(ax, steps, np.full(steps.size, truth), np.full(steps.size, yours))
    for level, name in ((float(np.mean(Z)), "mean of all five"), (0.0, "")):
        ax.axhline(level, color=PALETTE["muted"], linestyle=":", linewidth=1.0)
        ax.text(1.0, level + 0.03, name, fontsize=9.0)
    ax.set(xlabel="step", ylabel="x", ylim=(-0.15, 1.15))
    ax.legend(loc="center right")
    return figure


def _listing(steps: int) -> list[float]:
    """Return x after each step of the listing: its weight is one of GM with μ + 1, shrunk."""
    x, mu, path = 0.0, 1.0, []
    for _ in range(steps):
        weights = library.gm_weight(Z - x, 1.0, mu + 1.0) * mu / (mu + 1.0)
        x = float(weights @ Z / weights.sum())
        mu *= 1.4
        path.append(x)
    return path


def _weights(yours: Weight, truth: Weight, mus: Sequence[float], title: str) -> Figure:
    figure, ax = panel(title)
    u = np.linspace(-4.0, 4.0, 401)
    for mu, look in zip(mus, LOOKS[1:], strict=False):
        draw_beside(ax, u, truth(u, 1.0, mu), yours(u, 1.0, mu))
        ax.lines[-1].set(color=look.color, linestyle=look.linestyle, label=f"yours, μ = {mu:g}")
    ax.set(xlabel="whitened residual u, with c = 1", ylabel="weight", ylim=(-0.05, 1.4))
    ax.legend(loc="upper center", ncols=2)
    return figure
