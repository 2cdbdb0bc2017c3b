"""A first map of a factor graph: odometry in the frame of the priors or fixes, then landmarks.

Source: Umeyama 1991, the alignment of two sets of points; Holland and Welsch 1977, reweighting.
"""

import numpy as np

from robust_slam._arrays import Array, Indices
from robust_slam.factors.factor_graph import Block, FactorGraph
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.groups.group import Group
from robust_slam.groups.rotations import nearest_rotations

_ROUNDS = 30
_DIRECTIONS = 64


def first_map(graph: FactorGraph) -> Array:
    """Return a map ``(n + l, …)`` from odometry, the frame, and what is measured of landmarks.

    Poses are those of ``spanning_tree``, moved as one: by the first prior, or else onto the
    positions, of which a few may be wrong. A landmark is where its sightings place it in the
    median, or where its ranges from poses agree best. What neither reaches is at pose 0.
    """
    group, blocks = graph.group, {block.name: block for block in graph.blocks}
    poses = _in_frame(group, spanning_tree(graph.relative), blocks)
    places = np.tile(group.translation(poses[0]), (graph.landmarks, 1))
    seen, where = _sightings(graph, poses, blocks)
    for landmark in np.unique(seen):
        places[landmark - graph.n] = np.median(where[seen == landmark], axis=0)
    if "ranges" in blocks:
        _place_by_ranges(graph, poses, blocks["ranges"], np.unique(seen), places)
    return np.concatenate([poses, group.from_parts(np.eye(group.DIMENSION), places)])


def _in_frame(group: Group, poses: Array, blocks: dict[str, Block]) -> Array:
    """Return the ``poses`` ``(n, …)``, moved as one into the frame of the map."""
    if "priors" in blocks:
        prior = blocks["priors"]
        pose = poses[prior.ends[0, 1]]
        return group.compose(group.compose(prior.measurement[0], group.inverse(pose)), poses)
    if "positions" not in blocks:
        return poses
    fixes = blocks["positions"]
    of_poses = fixes.ends[:, 1] < len(poses)
    place = group.translation(poses)[fixes.ends[of_poses, 1]]
    return group.compose(_motion(group, place, fixes.measurement[of_poses]), poses)


def _motion(group: Group, a: Array, b: Array) -> Array:
    """Return the motion that takes the points a ``(k, d)`` near most of b ``(k, d)``.

    The weights are those of the Cauchy kernel, with the median distance as its scale.
    """
    motion, weights = group.identity(), np.ones(len(a))
    for _ in range(_ROUNDS if len(a) else 0):
        share = weights[:, None] / weights.sum()
        from_centre, to_centre = (share * a).sum(axis=0), (share * b).sum(axis=0)
        rotation = nearest_rotations((share * (b - to_centre)).T @ (a - from_centre))
        motion = group.from_parts(rotation, to_centre - rotation @ from_centre)
        squares = np.sum((b - to_centre - (a - from_centre) @ rotation.T) ** 2, axis=1)
        weights = 1.0 / (1.0 + squares / max(float(np.median(squares)), np.finfo(float).tiny))
    return motion


def _sightings(
    graph: FactorGraph, poses: Array, blocks: dict[str, Block]
) -> tuple[Indices, Array]:
    """Return the landmarks ``(k,)`` that are seen or surveyed, and where each time ``(k, d)``."""
    group, d = graph.group, graph.group.DIMENSION
    nodes, places = [np.zeros(0, dtype=np.intp)], [np.zeros((0, d))]
    for name in {"positions", "points"} & set(blocks):
        block = blocks[name]
        landmark = block.ends[:, 1] >= graph.n
        from_pose, z = block.ends[landmark, 0], block.measurement[landmark]
        if name == "points":
            z = group.translation(group.compose(poses[from_pose], group.from_parts(np.eye(d), z)))
        nodes.append(block.ends[landmark, 1])
        places.append(z)
    return np.concatenate(nodes), np.concatenate(places)


def _place_by_ranges(
    graph: FactorGraph, poses: Array, ranges: Block, placed: Indices, places: Array
) -> None:
    """Write into ``places`` ``(l, d)`` where the ranges of each landmark agree best.

    Of points around each pose, at the measured distance, it is the one from which the distances
    differ least from those measured, in the sum of absolute values: a few wrong ones do no harm.
    """
    near, far = np.sort(ranges.ends, axis=1).T
    position = graph.group.translation(poses)
    around = np.random.default_rng(0).normal(size=(_DIRECTIONS, position.shape[1]))
    around /= np.linalg.norm(around, axis=1, keepdims=True)
    usable = (near < graph.n) & (far >= graph.n) & ~np.isin(far, placed)
    for landmark in np.unique(far[usable]):
        of = usable & (far == landmark)
        centre, distance = position[near[of]], ranges.measurement[of, 0]
        points = (centre[:, None] + distance[:, None, None] * around).reshape(-1, centre.shape[1])
        apart = np.linalg.norm(points[:, None] - centre, axis=2)
        best = np.argmin(np.abs(apart - distance).sum(axis=1))
        places[landmark - graph.n] = points[best]
