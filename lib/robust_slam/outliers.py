"""Wrong loop closures, put into a graph on purpose, with a record of which they are."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam import se2
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.generate import dead_reckoning
from robust_slam.pose_graph import PoseGraph, check_poses, with_closures

_ROUNDS = 50
"""Batches of random pairs to draw before giving up."""


def add_random_closures(
    graph: PoseGraph,
    count: int,
    rng: np.random.Generator,
    *,
    poses: ArrayLike | None = None,
    apart: float | None = None,
) -> tuple[PoseGraph, Mask]:
    """Return ``graph`` with ``count`` closures that are lies, and a mask ``(m,)`` of the lies.

    Each says that two poses which are at least ``apart`` (m) from each other are the same
    place, up to the noise of an honest closure, and claims the information of an honest
    closure drawn from the graph (of an odometry edge if it has none): nothing in its
    numbers gives it away. ``poses`` ``(n, 3)`` tell how far apart poses are, by default
    dead reckoning; give the truth where it is known. ``apart`` is by default half of the
    longer side of their map. No pair is drawn twice.

    Raises:
        ValueError: ``count`` is negative, or fewer pairs are that far apart.

    Source: the random policy of Sünderhauf and Protzel 2012.
    """
    known = dead_reckoning(graph) if poses is None else check_poses("poses", poses, graph)
    place = known[:, :2]
    least = 0.5 * float(np.ptp(place, axis=0).max()) if apart is None else float(apart)
    edges = _distant_pairs(place, least, count, rng)
    model = np.flatnonzero(~graph.is_odometry)
    model = np.arange(len(graph.edges)) if model.size == 0 else model
    information = graph.information[rng.choice(model, size=count)]
    measurement = se2.exp(_noise(information, rng))
    spoiled = with_closures(graph, edges, measurement, information)
    return spoiled, np.arange(len(spoiled.edges)) >= len(graph.edges)


def _distant_pairs(place: Array, least: float, count: int, rng: np.random.Generator) -> Indices:
    """Draw ``count`` different pairs (i, j), i + 1 < j, at least ``least`` apart."""
    if count < 0:
        raise ValueError(f"count is {count}; give at least 0")
    found: dict[tuple[int, int], None] = {}
    for _ in range(_ROUNDS):
        drawn = np.sort(rng.integers(len(place), size=(4 * count + 100, 2)), axis=1)
        gap = np.linalg.norm(place[drawn[:, 0]] - place[drawn[:, 1]], axis=1)
        good = (gap >= least) & (drawn[:, 1] > drawn[:, 0] + 1)
        found.update(dict.fromkeys((int(i), int(j)) for i, j in drawn[good]))
        if len(found) >= count:
            return np.array(list(found)[:count], dtype=np.intp).reshape(-1, 2)
    raise ValueError(
        f"count is {count}, and only {len(found)} pairs at least {least:.3g} m apart were "
        "found; ask for fewer or lower apart"
    )


def _noise(information: Array, rng: np.random.Generator) -> Array:
    """Draw one η ``(k, 3)`` for each information matrix, with its inverse as covariance."""
    white = rng.normal(size=information.shape[:2])
    root = np.linalg.cholesky(information)
    return np.asarray(np.linalg.solve(np.swapaxes(root, 1, 2), white[..., None])[..., 0], float)
