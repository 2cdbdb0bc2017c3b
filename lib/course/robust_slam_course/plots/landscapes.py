"""Draw the minima of a cost: from which starts a descent ends there, and how they come about."""

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike
from robust_slam._arrays import Array, Indices, finite, positive
from robust_slam.estimators.kernels import Kernel
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.groups import se2
from robust_slam.palette import PALETTE
from robust_slam.problems import LocationProblem


def minima(values: ArrayLike) -> Indices:
    """Return the places (k,) of the local minima of values (n,), ends left out.

    A flat floor counts once, at its middle, and only if it rises again on both sides.
    """
    heights = np.asarray(values, dtype=np.float64)
    turn = np.flatnonzero(np.abs(np.diff(heights)) > 1e-12)
    falls = np.diff(heights)[turn] < 0.0
    low = np.flatnonzero(falls[:-1] & ~falls[1:])
    middles: Indices = (turn[low] + 1 + turn[low + 1]) // 2
    return middles


def draw_ends(ax: Axes, z: ArrayLike, kernel: Kernel, starts: ArrayLike) -> Axes:
    """Draw the end of IRLS against its start (n,), for readings z (m,) with σ = 1.

    Starts from which no reading is kept, so that IRLS does not move, are dashed. A line is broken
    where the end jumps.
    """
    x0, problem = finite("starts", starts, (-1,)), LocationProblem(z)
    results = [irls(problem, kernel, float(x), max_iterations=1000) for x in x0]
    ends = np.array([result.x for result in results])
    stays = np.array([result.stop is StopReason.ALL_REJECTED for result in results])
    for mask, dash, name, label in (
        (~stays, "-", "estimate", "descends"),
        (stays, "--", "outlier", "stays"),
    ):
        line = _broken_at_jumps(np.where(mask, ends, np.nan), x0)
        ax.plot(x0, line, dash, color=PALETTE[name], label=label)
    ax.set(xlabel="start", ylabel="end")
    return ax


def draw_fork(ax: Axes, distance: float, c_max: float) -> Axes:
    """Draw the stationary points of Cauchy's cost of readings at 0 and `distance` against c.

    Minima are solid and maxima dashed. Up to c = distance/2 there are two minima.

    Raises:
        ValueError: an argument is not positive.

    Source: derived here; with v = x − d/2 the slope is 0 where v (v² + c² − d²/4) = 0.
    """
    half = positive("distance", distance) / 2.0
    narrow = half * np.sin(np.linspace(0.0, np.pi / 2.0, 91))
    reach = np.sqrt(np.maximum(half**2 - narrow**2, 0.0))
    blue, label = PALETTE["estimate"], "minimum"
    for sign in (-1.0, 1.0):
        ax.plot(narrow, half + sign * reach, "-", color=blue, label=label)
        label = "_"
    ax.plot([half, positive("c_max", c_max)], [half, half], "-", color=blue)
    ax.plot([0.0, half], [half, half], "--", color=PALETTE["outlier"], label="maximum")
    ax.set(xlabel="c", ylabel="x", xlim=(0.0, c_max))
    return ax


def draw_twist(ax: Axes, n: int, turns: ArrayLike) -> Axes:
    """Draw ½ Σ of the squared residuals of a ring of n headings against how often it is twisted.

    At t turns each heading is ahead of the one before it by 2π t/n; it was measured to be
    equal. A diamond marks each whole turn of less than half a turn an edge: a minimum.

    Raises:
        ValueError: n is below 3, or turns (k,) is not a list of finite numbers.
    """
    if n < 3:
        raise ValueError(f"n is {n}; give at least 3 headings")
    t = finite("turns", turns, (-1,))
    ax.plot(t, _ring_cost(n, t), "-", color=PALETTE["odometry"], label="squared cost")
    whole = np.arange(np.ceil(t.min()), np.floor(t.max()) + 1.0)
    low = whole[np.abs(whole) < n / 2.0]
    ax.plot(low, _ring_cost(n, low), "D", color=PALETTE["estimate"], label="minimum")
    ax.set(xlabel="turns", ylabel="cost, σ = 1 rad")
    return ax


def _ring_cost(n: int, turns: Array) -> Array:
    """Return ½ Σ r² of the ring's n − 1 steps and its closure, at each number of turns."""
    step = 2.0 * np.pi * turns / n
    return np.asarray(0.5 * ((n - 1) * se2.wrap(step) ** 2 + se2.wrap((n - 1) * step) ** 2))


def _broken_at_jumps(ends: Array, starts: Array) -> Array:
    """Return the ends with a gap wherever they move by more than twice what the starts do."""
    jumps = np.abs(np.diff(ends)) > 2.0 * np.abs(np.diff(starts)) + 1e-9
    broken = ends.copy()
    broken[1:][jumps] = np.nan
    return broken
