"""Which closures a map keeps: the decisions between two searches.

All minimise one cost, truncated least squares over the closures, and all begin at the present map.
``compatible`` tells which new closures the map can be bent to at a price below the threshold,
``settled`` decides about all closures and lets the map follow, and ``agreeing`` finds rejected
closures that agree with each other, so that the map may be wrong in place of them.

Source: Neira and Tardós 2001 for compatibility, one closure after the other; the rest is derived
here.
"""

from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.consistency.pairwise import pairwise_distances
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.undamped import descend_undamped
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    jacobians,
    residual_norms,
    residuals,
    rows_of,
    select,
)
from robust_slam.incremental.window import Move, Window

_ROUNDS = 20
_SMALL = 0.02
"""A step that turns no pose by more (rad) is the last: the next would be about its square."""
_LINEAR = 0.05
"""A window holds while no pose has turned by more (rad) since its factorisation."""
SIZE = 60
"""The largest number of poses in a window."""
_NEAR = 30
"""Rejected closures are compared with those whose ends are at most so many poses away."""


@dataclass(frozen=True, eq=False)
class State:
    """A map: ``poses`` ``(n, …)``, the edges ``(m,)`` that are ``kept``, and all their ``norms``.

    These are the residual norms ``(m,)`` at the poses.
    """

    poses: Array
    kept: Mask
    norms: Array


def compatible(
    window: Window, graph: PoseGraph, state: State, new: Mask, threshold: float
) -> Mask:
    """Return which of the ``new`` edges ``(m,)`` agree with the map and with each other.

    A closure agrees if its innovation, whitened with the covariance of the map's prediction and
    its own, is at most the ``threshold``: the cost of a map with it is then higher by at most as
    much as rejecting it would cost. The one that agrees most is taken first, and changes what the
    map predicts for the others.

    Source: Neira and Tardós 2001, sequential compatibility.
    """
    fresh = rows_of(graph, new)
    r, size, each = residuals(fresh, state.poses), graph.group.DOF, np.arange(int(new.sum()))
    spread = _prediction(window, graph, state, fresh)
    spread[each, :, each] += np.linalg.inv(fresh.information)
    taken = np.zeros(len(r), dtype=np.bool_)
    while not np.all(taken):
        own = spread[each, :, each]
        square = np.einsum("ka,ka->k", r, np.linalg.solve(own, r[..., None])[..., 0])
        best = int(np.argmin(np.where(taken, np.inf, square)))
        if square[best] > threshold**2:
            break
        taken[best] = True
        gain = np.linalg.solve(own[best], spread[best].reshape(size, -1)).reshape(size, -1, size)
        r = r - np.einsum("alb,a->lb", gain, r[best])
        spread = spread - np.einsum("kac,clb->kalb", spread[:, :, best], gain)
        r[best], spread[best, :, best] = 0.0, np.eye(size)
    agrees = new.copy()
    agrees[new] = taken
    return agrees


def _prediction(window: Window, graph: PoseGraph, state: State, fresh: PoseGraph) -> Array:
    """Return the covariance of what the map predicts for ``fresh`` edges, ``(k, D, k, D)``."""
    ends = np.unique(fresh.edges)
    covariance = window.covariance(graph, state.poses, state.kept, ends)
    by = np.zeros((len(fresh.edges), graph.group.DOF, ends.size, graph.group.DOF))
    k, at = np.arange(len(by)), np.searchsorted(ends, fresh.edges.T)
    for one, jacobian in zip(at, jacobians(fresh, state.poses), strict=True):
        by[k, :, one] += jacobian
    flat = by.reshape(by.shape[0] * by.shape[1], -1)
    spread = flat @ covariance.reshape(flat.shape[1], -1) @ flat.T
    return np.asarray(spread.reshape(*by.shape[:2], *by.shape[:2]))


def settled(
    window: Window | None, graph: PoseGraph, state: State, threshold: float
) -> tuple[Window | None, State]:
    """Return the state of truncated least squares that is reached from ``state``.

    The kept edges move the map, then each closure is kept if its residual norm is at most the
    ``threshold``, in turns until no decision changes. The steps are those of the ``window`` as
    long as it holds, and the one that holds at the end is returned too.
    """
    turned = 0.0
    for _ in range(_ROUNDS):
        if turned <= _LINEAR and (window is None or window.size(graph, state.kept) > 2 * SIZE):
            window = Window(graph, state.poses, state.kept)
        move = None if window is None else window.stepped(graph, state.poses, state.kept)
        if move is None or move.since > _LINEAR:
            window, move = None, _whole_step(graph, state)
        norms = residual_norms(graph, move.poses)
        before, turned = state.kept, move.turned
        state = State(move.poses, graph.is_odometry | (norms <= threshold), norms)
        if turned <= _SMALL and np.array_equal(before, state.kept):
            break
    return window, state


def _whole_step(graph: PoseGraph, state: State) -> Move:
    """Return the move of a step that lowers the cost, over all poses at once."""
    equations = NormalEquations(select(graph, state.kept))
    ones = np.ones(len(equations.graph.edges))
    poses = descend_undamped(equations, state.poses, ones, 0.0, 1).poses
    moved = graph.group.log(graph.group.between(state.poses, poses))
    turned = float(np.abs(moved[:, graph.group.DIMENSION :]).max())
    return Move(poses, turned, turned)


def agreeing(graph: PoseGraph, among: Mask, new: Mask, threshold: float) -> Mask:
    """Return which edges ``(m,)`` ``among`` some agree with ``new`` ones, which are among them.

    Those are compared whose ends are near, by the odometry between them: two outliers hardly
    agree. A ``new`` edge is marked if another one agrees with it.

    Source: Mangelson et al. 2018 for the agreement of pairs.
    """
    ends = np.sort(graph.edges, axis=1)
    near = np.zeros(among.size, dtype=np.bool_)
    for one in ends[new]:
        near |= among & np.all(np.abs(ends - one) <= _NEAR, axis=1)
    agreed = np.zeros(among.size, dtype=np.bool_)
    if near.sum() > 1:
        pairs = (pairwise_distances(graph, near, most=threshold) <= threshold) & new[near][:, None]
        np.fill_diagonal(pairs, False)
        agreed[near] = np.any(pairs, axis=0) | np.any(pairs, axis=1)
    return agreed
