"""Pictures for assignment 05: weights that harden, schedules, and two runs of the loop."""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike
from robust_slam._arrays import Array
from robust_slam.estimators import graduation as library
from robust_slam.palette import MARKERS, PALETTE
from robust_slam.problems import LocationProblem

from robust_slam_course.exercises import READINGS as Z
from robust_slam_course.exercises import Panels, draw_beside, picture
from robust_slam_course.style import LOOKS

Weight = Callable[[ArrayLike, float, float], ArrayLike]
History = Mapping[str, ArrayLike]
Loop = Callable[..., tuple[float, ArrayLike, History]]

_KINDS: tuple[library.Kind, ...] = ("tls", "gm")
_WEIGHT = ("whitened residual u, with c = 1", "weight")


@picture("As μ grows, the bend closes in on c = 1", *_WEIGHT)
def gnc_tls_weight(ax: Axes, weight: Weight) -> None:
    """Draw the TLS weight for a soft, a middle and a hard μ."""
    _draw_family(ax, weight, library.tls_weight, (0.1, 1.0, 10.0))


@picture("As μ falls to 1, far residuals lose their say", *_WEIGHT)
def gnc_gm_weight(ax: Axes, weight: Weight) -> None:
    """Draw the Geman–McClure weight for a soft, a middle and the last μ."""
    _draw_family(ax, weight, library.gm_weight, (30.0, 5.0, 1.0))


@picture(
    "The larger the worst residual, the softer the start", "largest |u|, with c = 1", "first μ"
)
def start_mu(ax: Axes, start: Callable[[float, float, str], float]) -> None:
    """Draw the first μ of both kinds against the largest residual."""
    size = np.geomspace(0.3, 30.0, 61)
    for kind, look in zip(_KINDS, LOOKS[1:], strict=False):
        truth = [library.start_mu(u, 1.0, kind) for u in size]
        yours = [float(start(float(u), 1.0, kind)) for u in size]
        draw_beside(ax, size, truth, yours, color=look.color, label=f'yours, "{kind}"')
    ax.axvspan(size[0], np.sqrt(0.5), color=PALETTE["muted"], alpha=0.12, linewidth=0.0)
    ax.text(0.32, 2e-3, "TLS: nothing\nto reject", fontsize=9.0)
    ax.set(xscale="log", yscale="log")
    ax.legend()


@picture("TLS climbs without end, GM comes down to 1 and stops", "solve", "μ")
def mu_schedule(ax: Axes, schedule: Callable[[float, float, int, str], ArrayLike]) -> None:
    """Draw both schedules of data A, from its own first μ."""
    for kind, look in zip(_KINDS, LOOKS[1:], strict=False):
        rule, first = library.RULES[kind](2.0), library.start_mu(7.5, 2.0, kind)
        truth = [first]
        while len(truth) < 21 and (kind == "tls" or truth[-1] > 1.0):
            truth.append(rule.next(truth[-1], np.empty(0), np.empty(0)))
        style = {"color": look.color, "linestyle": "", "marker": look.marker}
        yours = schedule(first, 1.4, 21, kind)
        draw_beside(ax, np.arange(len(truth)), truth, yours, **style, label=f'yours, "{kind}"')
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set(yscale="log")
    ax.legend()


@picture(
    "The outlier loses its weight first, and x follows the others",
    height=4.8, nrows=2, ncols=2, sharex="col", sharey="row",
)  # fmt: skip
def gnc(panels: Panels, loop: Loop, z: Array = Z) -> None:
    """Draw the weights and x of both kinds on readings whose last is wrong, solve by solve."""
    for kind, (top, bottom) in zip(_KINDS, panels.T, strict=True):
        run = library.gnc(LocationProblem(z, 0.3), 2.0, kind).history[1:]
        _, _, history = loop(z.copy(), 0.3, 2.0, 1.4, kind)
        solves = np.arange(1, len(run) + 1)
        yours = np.asarray(history["weights"], dtype=float)
        for k, name in enumerate(["inlier"] * (len(z) - 1) + ["outlier"]):
            truth = [step.weights[k] for step in run]
            look = {"color": PALETTE[name], "marker": MARKERS[name], "markersize": 4.0}
            draw_beside(top, solves, truth, yours[:, k], **look)
        x, mark = [step.x for step in run], MARKERS["estimate"]
        draw_beside(bottom, solves, x, history["x"], marker=mark, markersize=4.0)
        top.set(title=f'"{kind}"')
        bottom.xaxis.set_major_locator(MaxNLocator(integer=True))
        bottom.set(xlabel="solve")
    panels[0, 0].set(ylabel="weights; the outlier: ✕")
    panels[1, 0].set(ylabel="x")


@picture("The listing walks to the mean; does yours?", "step", "x")
def repaired_gnc(
    ax: Axes, repaired: Callable[[ArrayLike, float], tuple[float, ArrayLike]]
) -> None:
    """Draw the steps of the listing on the lesson's readings, and the end of the fixed one."""
    steps = np.arange(1, 41)
    truth, yours = library.gnc(LocationProblem(Z), 1.0).x, float(repaired(Z.copy(), 1.0)[0])
    ax.plot(steps, _listing(steps.size), "-", color=PALETTE["outlier"], label="the listing")
    draw_beside(ax, steps, np.full(steps.size, truth), np.full(steps.size, yours))
    for level, name in ((float(np.mean(Z)), "mean of all five"), (0.0, "")):
        ax.axhline(level, color=PALETTE["muted"], linestyle=":", linewidth=1.0)
        ax.text(1.0, level + 0.03, name, fontsize=9.0)
    ax.set(ylim=(-0.15, 1.15))
    ax.legend(loc="center right")


def _listing(steps: int) -> list[float]:
    """Return x after each step of the listing: its weight is one of GM with μ + 1, shrunk."""
    x, mu, path = 0.0, 1.0, []
    for _ in range(steps):
        weights = library.gm_weight(Z - x, 1.0, mu + 1.0) * mu / (mu + 1.0)
        x = float(weights @ Z / weights.sum())
        mu *= 1.4
        path.append(x)
    return path


def _draw_family(ax: Axes, yours: Weight, truth: Weight, mus: Sequence[float]) -> None:
    u = np.linspace(-4.0, 4.0, 401)
    for mu, look in zip(mus, LOOKS[1:], strict=False):
        label = f"yours, μ = {mu:g}"
        draw_beside(ax, u, truth(u, 1.0, mu), yours(u, 1.0, mu), **look.line, label=label)
    ax.set(ylim=(-0.05, 1.4))
    ax.legend(loc="upper center", ncols=2)
