"""Signs that a pose graph was written in other units or another order than it is read in.

No line of such a file is wrong by itself: a covariance in the place of the information is as
good a matrix, and a closure between two drives whose ids are neighbours looks like odometry. What
gives them away are magnitudes that no sensor and no drive has.

Source: derived here.
"""

from __future__ import annotations

import numpy as np

from robust_slam._arrays import Indices
from robust_slam._words import counted
from robust_slam.graphs.graph_file import Names
from robust_slam.graphs.pose_graph import PoseGraph, deviations

_BLIND = np.pi / np.sqrt(3.0)
"""The deviation (rad) of a direction about which nothing is known: uniform from -π to π."""
_COARSE = 10.0
"""Claimed deviations of a step, in steps, from which on they cannot be meant."""
_LEAP = 10.0
"""Steps so many times longer than 95 % of all are hardly odometry."""
_UNLIKE = 1.5
"""A deviation differs by this factor where a sensor differs, and not by rounding."""
_FEW = 8
"""The smallest number of steps that tell what is usual."""


def symptoms(graph: PoseGraph, names: Names) -> tuple[str, ...]:
    """Return a sentence for each sign that the ``graph`` is not what its file was meant to hold.

    ``names`` ``(n,)`` are the ids of the poses. The signs are matrices that look like covariances,
    single steps of the odometry that are as long, or as precise, as closures between drives, and
    single steps that lead back.

    >>> graph = PoseGraph(2, [[0, 1]], [[1, 0, 0]], [np.diag([1e-2, 1e-2, 1e-4])],
    ...                   is_odometry=[True])
    >>> symptoms(graph, np.arange(2))[0][:40]
    'the matrices claim a deviation of 100 ra'
    """
    return (*_covariances(graph), *_strange_steps(graph, names), *_steps_back(graph, names))


def _covariances(graph: PoseGraph) -> tuple[str, ...]:
    position, rotation = (float(np.median(sigma)) for sigma in deviations(graph))
    steps = np.linalg.norm(graph.translation[graph.is_odometry], axis=1)
    step = float(np.median(steps)) if steps.size else np.inf
    if rotation > _BLIND:
        claimed = f"a deviation of {rotation:.3g} rad, with which a direction is unknown"
    elif 0.0 < _COARSE * step < position:
        claimed = f"a deviation of {position:.3g} m for steps of {step:.3g} m"
    else:
        return ()
    return (
        f"the matrices claim {claimed}; if they are covariances, write their inverses, "
        "the information",
    )


def _strange_steps(graph: PoseGraph, names: Names) -> tuple[str, ...]:
    odometry = np.flatnonzero(graph.is_odometry)
    if odometry.size < _FEW:
        return ()
    length = np.linalg.norm(graph.translation[odometry], axis=1)
    usual = float(np.quantile(length, 0.95))
    far = odometry[length > _LEAP * max(usual, np.finfo(float).tiny)]
    unlike = _unlike(graph, odometry)
    if far.size:
        why = f"is {np.max(length) / usual:.0f} times as long as others"
        return (_closure_words(graph, names, far, why),)
    if unlike.size:
        return (_closure_words(graph, names, unlike, "claims what closures claim"),)
    return ()


def _steps_back(graph: PoseGraph, names: Names) -> tuple[str, ...]:
    """Return a sentence where a few steps alone lead from the later to the earlier pose."""
    odometry = np.flatnonzero(graph.is_odometry)
    back = odometry[graph.edges[odometry, 0] > graph.edges[odometry, 1]]
    if not 0 < back.size <= 0.05 * odometry.size:
        return ()
    i, j = names[graph.edges[back[0]]]
    more = f", as {counted(back.size - 1, 'other')}," if back.size > 1 else ""
    return (
        f"edge {i}-{j}{more} leads back where the other steps lead ahead; if it measures the way "
        "ahead, swap its ids",
    )


def _unlike(graph: PoseGraph, odometry: Indices) -> Indices:
    """Return single steps that claim the closures' deviations, where others share their own."""
    closures = np.flatnonzero(~graph.is_odometry)
    if not closures.size:
        return closures
    claims = np.log(np.stack(deviations(graph), axis=1))
    ours, theirs = np.median(claims[odometry], axis=0), np.median(claims[closures], axis=0)
    if np.max(np.abs(ours - theirs)) < np.log(_UNLIKE):
        return np.empty(0, dtype=np.intp)
    near = np.log(_UNLIKE) / 4.0
    alike = np.all(np.abs(claims[odometry] - ours) < near, axis=1)
    foreign = np.all(np.abs(claims[odometry] - theirs) < near, axis=1)
    found: Indices = odometry[foreign]
    return found if np.sum(alike) > 0.95 * odometry.size else found[:0]


def _closure_words(graph: PoseGraph, names: Names, edges: Indices, why: str) -> str:
    i, j = names[graph.edges[edges[0]]]
    more = f", and {counted(edges.size - 1, 'other')} like it," if edges.size > 1 else ""
    return (
        f"edge {i}-{j}{more} counts as odometry, because its ids are neighbours, but {why}; "
        f"if it joins two drives, name it as a closure: --closure {i}-{j}, or False in is_odometry"
    )
