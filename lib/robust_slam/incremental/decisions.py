"""Which closures a map keeps: the decisions between two searches.

All minimise one cost, truncated least squares over the closures, and all begin at the present map.
``compatible`` tells which new closures the map can be bent to at a price below the threshold,
``settled`` decides about all closures and lets the map follow, and ``agreeing`` finds rejected
closures that agree with each other, so that the map may be wrong in place of them.

Source: Neira and Tardós 2001 for compatibility, one closure after the other; the rest is derived
here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Mask
from robust_slam.consistency.pairwise import pairwise_distances
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    jacobians,
    residual_norms,
    residuals,
    rows_of,
)
from robust_slam.incremental.window import Window

_SMALL = 0.02
"""A step that turns no pose by more (rad) is the last: the next would be about its square."""
_LINEAR = 0.05
"""A window holds while no pose has turned by more (rad) since its factorisation."""
_FACTORISED = 2
"""A call factorises the map at most so many times, takes so many steps …"""
_ROUNDS = 5
"""… and leaves the rest to the next one."""
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

    def cost(self, threshold: float) -> float:
        """Return the cost of truncated least squares, at which a rejected edge costs c²."""
        return float(np.sum(np.where(self.kept, self.norms, threshold) ** 2))


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
    ``threshold``, in turns until no decision changes, or a call has done enough. The steps are
    those of the ``window`` as long as it holds. The one at the end is returned too, or None where
    the map is not at rest.
    """
    left = _FACTORISED
    for _ in range(_ROUNDS):
        fresh = window is None or window.size(graph, state.kept) > 2 * SIZE
        if fresh and not left:
            return None, state
        if window is None or fresh:
            window, left = Window(graph, state.poses, state.kept), left - 1
        move = window.stepped(graph, state.poses, state.kept)
        if move.since > _LINEAR and not fresh:
            window = None
            continue
        norms, before = residual_norms(graph, move.poses), state.kept
        state = State(move.poses, graph.is_odometry | (norms <= threshold), norms)
        if move.turned <= _SMALL and np.array_equal(before, state.kept):
            return window, state
    return None, state


def beside(graph: PoseGraph, some: Mask) -> Mask:
    """Return which edges ``(m,)`` have both ends near those of one of ``some`` edges ``(m,)``."""
    ends = np.sort(graph.edges, axis=1)
    near = np.zeros(some.size, dtype=np.bool_)
    for one in ends[some]:
        near |= np.all(np.abs(ends - one) <= _NEAR, axis=1)
    return near


def agreeing(graph: PoseGraph, among: Mask, new: Mask, threshold: float) -> Mask:
    """Return which edges ``(m,)`` ``among`` some agree with ``new`` ones, which are among them.

    Those are compared whose ends are near, by the odometry between them: two outliers hardly
    agree. A ``new`` edge is marked if another one agrees with it.

    Source: Mangelson et al. 2018 for the agreement of pairs.
    """
    near = among & beside(graph, new)
    agreed = np.zeros(among.size, dtype=np.bool_)
    if near.sum() > 1:
        pairs = (pairwise_distances(graph, near) <= threshold) & new[near][:, None]
        np.fill_diagonal(pairs, False)
        agreed[near] = np.any(pairs, axis=0) | np.any(pairs, axis=1)
    return agreed
