"""A robot with a planar laser scanner in one building: a long and badly conditioned graph.

What makes such graphs hard is reproduced. The information of an edge is that of a scan match:
in a corridor it is high across the walls and low along them, it is much higher for the
rotation than for the position, and it varies by orders of magnitude from one edge to the
next. The odometry has gaps: a pose after a gap is connected by closures alone.

Measurements are z = x_i⁻¹ ∘ x_j ∘ Exp(η) with η from the covariance of the edge, so at the
true poses the whitened residuals are standard normal. The first true pose is the identity.

Source: derived here, modelled on the laser graphs of Kümmerle et al. 2009, "On measuring the
accuracy of SLAM algorithms".
"""

from __future__ import annotations

import numpy as np

from robust_slam._arrays import Array, Indices, Mask, positive
from robust_slam.graphs import se2
from robust_slam.graphs.generate import near_pairs
from robust_slam.graphs.pose_graph import PoseGraph, connected_parts

_CORRIDOR = 6.0
"""The length of a corridor between two crossings, in m."""
_REACH = 1.0
"""The largest distance in m at which two scans are matched."""
_STEP = 0.5
"""The distance from pose to pose, in m."""
_SPREAD = 30.0
"""How much larger a deviation can be along a corridor than across, and from edge to edge."""
_AHEAD = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""The four headings."""
_CLOSURE = 3.0
"""How much larger the deviations of a closure are than those of an odometry edge."""


def building(
    n: int,
    rng: int | np.random.Generator,
    *,
    gaps: int | None = None,
    closures: int | None = None,
    deviation: tuple[float, float] = (0.001, 0.003),
    scale: float = 1.0,
) -> tuple[PoseGraph, Array]:
    """Return a drive of ``n`` poses through the corridors of a building, and the true poses.

    The true poses are ``(n, 3)``. The building is a square of rooms of 6 m with corridors
    around them, about a room for every 150 poses, and the robot drives 0.5 m from pose to pose
    and turns at random crossings. ``gaps`` of the odometry edges
    are missing, by default n/500. The ``closures``, by default n/15, are drawn from all pairs of
    poses that are at most 1 m apart and not consecutive; those that join the sequences on
    both sides of a gap come first.

    ``deviation`` holds the least standard deviations of an odometry edge, in m and rad. Across
    a corridor the position has up to 30 times the first, along it up to 30 times that, and
    the rotation up to 30 times the second, each log-uniform. A closure has three times more.
    ``scale`` multiplies the noise but not the information matrix; 0 gives exact measurements.

    Raises:
        ValueError: an argument is out of range, there are fewer pairs than ``closures``, or
            the closures cannot join the sequences.

    >>> graph, truth = building(300, np.random.default_rng(0), gaps=2, closures=40)
    >>> len(graph.edges), int(graph.is_odometry.sum()), graph.odometry_joins_all
    (337, 297, False)
    """
    rng = np.random.default_rng(rng)
    gaps = n // 500 if gaps is None else gaps
    if n < 3 or not 0 <= gaps <= n - 2:
        raise ValueError(f"n is {n} and gaps {gaps}; give at least 3 poses and at most n - 2 gaps")
    truth = _drive(n, max(1, round(np.sqrt(n / 150.0))), rng)
    odometry = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    odometry = np.delete(odometry, rng.choice(n - 1, size=gaps, replace=False), axis=0)
    found = _closures(truth, odometry, n // 15 if closures is None else closures, rng)
    edges = np.concatenate([odometry, found])
    is_odometry = np.arange(len(edges)) < len(odometry)
    root = _deviations(is_odometry, deviation, rng)
    drawn = scale * (root @ rng.normal(size=(len(edges), 3, 1)))[..., 0]
    true = se2.between(truth[edges[:, 0]], truth[edges[:, 1]])
    whitening = np.linalg.inv(root)
    information = np.swapaxes(whitening, 1, 2) @ whitening
    information = 0.5 * (information + np.swapaxes(information, 1, 2))
    return PoseGraph(n, edges, se2.compose(true, se2.exp(drawn)), information, is_odometry), truth


def _drive(n: int, side: int, rng: np.random.Generator) -> Array:
    """Return ``n`` poses ``(n, 3)`` along the corridors of ``side`` by ``side`` rooms."""
    length = _CORRIDOR * side
    poses, at, facing, left = np.zeros((n, 3)), np.zeros(2), 0, _CORRIDOR
    for k in range(1, n):
        moving = _STEP
        while moving >= left:
            at = np.round((at + left * _AHEAD[facing]) / _CORRIDOR) * _CORRIDOR
            moving -= left
            facing, left = _turned(at, facing, length, rng), _CORRIDOR
        at, left = at + moving * _AHEAD[facing], left - moving
        poses[k] = [*at, facing * np.pi / 2.0]
    return np.column_stack([poses[:, :2], se2.wrap(poses[:, 2])])


def _turned(at: Array, facing: int, length: float, rng: np.random.Generator) -> int:
    """Return the heading after a crossing, in quarter turns; the robot stays inside."""
    headings = [int(facing + turn) % 4 for turn in [*rng.permutation([0, 1, 3]), 2]]
    return next(each for each in headings if _is_inside(at + _CORRIDOR * _AHEAD[each], length))


def _is_inside(spot: Array, length: float) -> bool:
    return bool(np.all((spot >= -1e-6) & (spot <= length + 1e-6)))


def _closures(truth: Array, odometry: Indices, count: int, rng: np.random.Generator) -> Indices:
    """Return ``count`` pairs ``(count, 2)`` of near poses that join all sequences."""
    n = len(truth)
    pairs = rng.permutation(near_pairs(truth[:, :2], _REACH))
    sequence = connected_parts(n, odometry)
    joins = _joining(sequence, pairs)
    if joins.sum() > count:
        raise ValueError(
            f"gaps: the closures do not join the {sequence.max() + 1} sequences; ask for fewer "
            "gaps, more closures or a smaller building"
        )
    if count > len(pairs):
        raise ValueError(f"closures is {count}, and {len(pairs)} pairs of poses are near enough")
    others = np.flatnonzero(~joins)[: count - int(joins.sum())]
    chosen = pairs[np.sort(np.concatenate([np.flatnonzero(joins), others]))]
    return np.asarray(chosen[np.lexsort(chosen.T[::-1])], dtype=np.intp)


def _joining(sequence: Indices, pairs: Indices) -> Mask:
    """Mark the pairs that join two sequences not yet joined by the pairs before."""
    group = np.arange(sequence.max() + 1)
    marked = np.zeros(len(pairs), dtype=bool)
    for k, (i, j) in enumerate(sequence[pairs]):
        if group[i] != group[j]:
            group[group == group[j]] = group[i]
            marked[k] = True
    return marked


def _deviations(
    is_odometry: Mask, deviation: tuple[float, float], rng: np.random.Generator
) -> Array:
    """Return a root ``(m, 3, 3)`` of each edge's covariance, in the frame of pose j."""
    m = len(is_odometry)
    position, rotation = (positive("deviation", number) for number in deviation)
    across, longer, turned = _SPREAD ** rng.random((3, m))
    sigma = np.where(is_odometry, 1.0, _CLOSURE)[:, None] * np.column_stack(
        [position * across * longer, position * across, rotation * turned]
    )
    # The corridor is measured not quite along the heading, so the information is not diagonal.
    tilt = 0.2 * rng.normal(size=m)
    root = np.zeros((m, 3, 3))
    root[:, :2, :2] = se2.rotation(np.column_stack([np.zeros((m, 2)), tilt]))
    root[:, 2, 2] = 1.0
    return np.asarray(root * sigma[:, None, :])
