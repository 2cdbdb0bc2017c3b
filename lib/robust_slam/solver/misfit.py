"""What a map leaves that neither the noise it shows nor outliers explain.

Two signs of it are looked for. A step of the odometry may be off by more than noise leaves of a
step in its place, although the closures that are kept could bend it: it slipped. And closures
that were rejected may be close to the map. Outliers are of all sizes, so that few of them come
close by chance; many that do are inliers of more noise, and the map may be wrong without them.

Source: Baarda 1968, "A testing procedure for use in geodetic networks", for the test of each
measurement by what the others leave of it; the sign of closures is derived here.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import bdtrc, chdtrc

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.metrics import align
from robust_slam.graphs.pose_graph import PoseGraph, residual_norms
from robust_slam.groups.group import group_of
from robust_slam.solver.fitted import Fitted, relative_squares

_WORST = 8
"""What noise leaves is computed of so many steps, which are off by most beside a rough guess."""
_BENT = 2.0
"""A step bends the map where a pose moves by so many times what closures tolerate."""
_CLOSE = 10.0
"""Closures within so many thresholds are close, and counted beside those within its square."""


@dataclass(frozen=True, eq=False, repr=False)
class Misfit:
    """What does not fit: a ``step`` of the odometry, or None, and rejected ``closures``.

    By what the others measure, the step is ``off`` by so many m and rad, or NaN. The map is
    ``bent`` if a pose would be elsewhere without it by more than what closures tolerate.
    """

    step: int | None
    closures: Indices
    off: tuple[float, float] = (np.nan, np.nan)
    bent: bool = True

    def __bool__(self) -> bool:
        return self.step is not None or self.closures.size > 0

    def __repr__(self) -> str:
        return f"<Misfit: step {self.step}, {self.closures.size:,} closures>"


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
    close = _close(norms, ~kept & ~trusted, level)
    return replace(_slipped(graph, poses, kept, threshold, level), closures=close)


def _slipped(graph: PoseGraph, poses: Array, kept: Mask, threshold: float, level: float) -> Misfit:
    """Return the step that noise leaves least of, or which bends the map most, and by how much."""
    fit, count = Fitted.of(graph, poses, kept), int(np.sum(kept & graph.is_odometry))
    taken = fit.taken_up(fit.residuals[None])
    if taken is None or not count:
        return NOTHING
    left, rough = fit.residuals - taken[0], fit.roughly_left(np.arange(len(fit.residuals)))
    squares = np.where(fit.graph.is_odometry, relative_squares(left, rough), 0.0)
    worst = np.argsort(-squares, kind="stable")[:_WORST]
    spread = fit.left(worst)
    chance = chdtrc(graph.group.DOF, relative_squares(left[worst], spread))
    rare = chance * count < level
    if not np.any(rare):
        return NOTHING
    worst, spread, chance = worst[rare], spread[rare], chance[rare]
    noise = np.linalg.solve(spread, left[worst][..., None])[..., 0]
    bends = [_bend(poses, graph.group.exp(each)) for each in fit.moved(worst, noise)]
    bent = max(bends) > _BENT * _tolerated(graph, threshold)
    most, d = int(np.argmax(bends if bent else -chance)), graph.group.DIMENSION
    error = np.linalg.solve(fit.root[worst[most]], noise[most])
    off = float(np.linalg.norm(error[:d])), float(np.linalg.norm(error[d:]))
    return replace(NOTHING, step=int(np.flatnonzero(kept)[worst[most]]), off=off, bent=bent)


def _bend(poses: Array, moved: Array) -> float:
    """Return how far (m) a pose is elsewhere in the map of ``moved`` poses ``(n, …)``."""
    group = group_of(poses)
    other = align(group.compose(poses, moved), poses)
    return float(np.linalg.norm(group.translation(other) - group.translation(poses), axis=1).max())


def _tolerated(graph: PoseGraph, threshold: float) -> float:
    """Return how far (m) closures may be off that are kept up to the ``threshold``."""
    if np.all(graph.is_odometry):
        return 0.0
    d = graph.group.DIMENSION
    spread = np.linalg.inv(graph.information[~graph.is_odometry])[:, :d, :d]
    return threshold * float(np.sqrt(np.median(np.trace(spread, axis1=1, axis2=2)) / d))


def _close(norms: Array, rejected: Mask, level: float) -> Indices:
    """Return the ``rejected`` closures that are close, where they are too many for chance.

    ``norms`` ``(m,)`` are in units of the threshold. The number of outliers up to a norm grows
    with it, or faster: by chance at most one is close where ten are within its square.
    """
    close = np.flatnonzero(rejected & (norms <= _CLOSE))
    within = int(np.sum(rejected & (norms <= _CLOSE**2)))
    chance = bdtrc(close.size - 1, within, 1.0 / _CLOSE) if close.size else 1.0
    return close if chance < level else close[:0]
