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
from robust_slam.descent.step import increases, retract
from robust_slam.graphs.pose_graph import PoseGraph, cost, residual_norms, residuals, rows_of
from robust_slam.incremental.window import Window, largest_angle

_ROUNDS = 4
"""A robot waits for so many factorisations of the whole map at most."""
_SHORTEST = 1 / 16
_LINEAR = 0.05
"""A window holds while no pose has turned by more (rad) since its factorisation, and a step that
turns none by more is the last: the next would be about its square."""
SIZE = 60
"""The largest number of poses in a window."""
_GROUP = 3
"""So many rejected closures that agree, and came since the last search, enter the map by force."""
_NEAR = 30
"""Rejected closures are compared with those whose ends are at most so many poses away."""


@dataclass(frozen=True, eq=False)
class State:
    """A map: ``poses`` ``(n, …)``, ``kept`` edges ``(m,)``, residual ``norms``, 0 of odometry."""

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
    spread = window.predicted(graph, state.poses, state.kept, fresh)
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


def settled(
    window: Window | None, graph: PoseGraph, state: State, threshold: float
) -> tuple[Window | None, State]:
    """Return the state of truncated least squares that is reached from ``state``.

    The kept edges move the map, then each closure is kept if its residual norm is at most the
    ``threshold``, in turns until no decision changes. The steps are those of the ``window`` as
    long as it holds, and it is returned too if it holds at the end. A step that would raise the
    cost is shortened.
    """
    since, asked = 0.0, ~graph.is_odometry
    closures = rows_of(graph, asked)
    for _ in range(_ROUNDS):
        if window is None or since > _LINEAR or window.size(graph, state.kept) > 2 * SIZE:
            window, share = Window(graph, state.poses, state.kept), 1.0
            poses = retract(graph, state.poses, window.mean)
            turned = since = largest_angle(graph, window.mean)
            while since > _LINEAR and share > _SHORTEST and _raises(graph, state, poses):
                share *= 0.5
                poses = retract(graph, state.poses, share * window.mean)
        else:
            poses, turned, since = window.stepped(graph, state.poses, state.kept)
            if since > _LINEAR and _raises(graph, state, poses):
                continue  # with the window of this state
        last, norms = state, np.zeros(len(graph.edges))
        norms[asked] = residual_norms(closures, poses)
        state = State(poses, norms <= threshold, norms)
        if turned <= _LINEAR and np.array_equal(last.kept, state.kept):
            break
    return None if since > _LINEAR else window, state


def _raises(graph: PoseGraph, state: State, poses: Array) -> bool:
    return increases(*(cost(graph, at, state.kept) for at in (poses, state.poses)))


def agreeing(graph: PoseGraph, among: Mask, new: Mask, recent: Mask, threshold: float) -> Mask:
    """Return which edges ``(m,)`` ``among`` some agree with ``new`` ones, which are among them.

    Those are compared whose ends are near, by the odometry between them: two outliers hardly
    agree. A ``new`` edge is marked if another one agrees with it, and none if few are ``recent``.

    Source: Mangelson et al. 2018 for the agreement of pairs.
    """
    ends = np.sort(graph.edges, axis=1)
    near = among & np.any(np.abs(ends[:, None] - ends[new]).max(axis=2) <= _NEAR, axis=1)
    agreed = np.zeros(among.size, dtype=np.bool_)
    if np.sum(near & recent) >= _GROUP:
        pairs = (pairwise_distances(graph, near, most=threshold) <= threshold) & new[near][:, None]
        np.fill_diagonal(pairs, False)
        agreed[near] = np.any(pairs, axis=0) | np.any(pairs, axis=1)
    return agreed & (np.sum(agreed & recent) >= _GROUP)
