"""What a map leaves that neither the noise it shows nor outliers explain.

Two signs of it are looked for. A step of the odometry may be off by more than noise leaves of a
step in its place, although the closures that are kept could bend it: it slipped. And closures
that were rejected may be close to the map. Outliers are of all sizes, so that few of them come
close by chance; many that do are inliers of more noise, and the map may be wrong without them.

Source: Baarda 1968, "A testing procedure for use in geodetic networks", for the test of each
measurement by what the others leave of it; the sign of closures is derived here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import bdtrc, chdtrc

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.pose_graph import PoseGraph, residual_norms
from robust_slam.solver.fitted import Fitted, relative_squares

_WORST = 8
"""What noise leaves is computed of so many steps, which are off by most beside a rough guess."""
_CLOSE = 10.0
"""Closures within so many thresholds are close, and counted beside those within its square."""


@dataclass(frozen=True, eq=False)
class Misfit:
    """What does not fit: a ``step`` of the odometry, or None, and rejected ``closures``.

    By what the others measure, the step is ``off`` by so many m and rad, or NaN.
    """

    step: int | None
    closures: Indices
    off: tuple[float, float] = (np.nan, np.nan)

    def __bool__(self) -> bool:
        return self.step is not None or self.closures.size > 0


NOTHING = Misfit(None, np.zeros(0, dtype=np.intp))


def find_misfit(
    graph: PoseGraph, poses: Array, kept: Mask, trusted: Mask, threshold: float, level: float
) -> Misfit:
    """Return what chance explains with less than the probability ``level``.

    The map are the ``poses`` of the ``kept`` edges ``(m,)``, a minimum with the deviations of
    ``graph``, which are those that it shows. Closures that are not ``trusted`` ``(m,)`` were kept
    up to the ``threshold``.
    """
    norms = residual_norms(graph, poses) / threshold
    step, off = _slipped(graph, poses, kept, level)
    return Misfit(step, _close(norms, ~kept & ~trusted, level), off)


def _slipped(
    graph: PoseGraph, poses: Array, kept: Mask, level: float
) -> tuple[int | None, tuple[float, float]]:
    """Return the step that is off by most beside what noise leaves of it, and by how much."""
    fit, count = Fitted.of(graph, poses, kept), int(np.sum(kept & graph.is_odometry))
    taken = fit.taken_up(fit.residuals[None])
    if taken is None or not count:
        return None, NOTHING.off
    left, rough = fit.residuals - taken[0], fit.roughly_left(np.arange(len(fit.residuals)))
    squares = np.where(fit.graph.is_odometry, relative_squares(left, rough), 0.0)
    worst = np.argsort(-squares, kind="stable")[:_WORST]
    spread = fit.left(worst)
    chance = chdtrc(graph.group.DOF, relative_squares(left[worst], spread))
    first = int(np.argmin(chance))
    if chance[first] * count >= level:
        return None, NOTHING.off
    step, d = worst[first], graph.group.DIMENSION
    error = np.linalg.solve(spread[first] @ fit.root[step], left[step])
    off = float(np.linalg.norm(error[:d])), float(np.linalg.norm(error[d:]))
    return int(np.flatnonzero(kept)[step]), off


def _close(norms: Array, rejected: Mask, level: float) -> Indices:
    """Return the ``rejected`` closures that are close, where they are too many for chance.

    ``norms`` ``(m,)`` are in units of the threshold. The number of outliers up to a norm grows
    with it, or faster: by chance at most one is close where ten are within its square.
    """
    close = np.flatnonzero(rejected & (norms <= _CLOSE))
    within = int(np.sum(rejected & (norms <= _CLOSE**2)))
    chance = bdtrc(close.size - 1, within, 1.0 / _CLOSE) if close.size else 1.0
    return close if chance < level else close[:0]
