"""The map since its last factorisation: a small problem that stands for the whole one.

Most closures join a few poses only. At a factorisation the map is a Gaussian over all its poses;
its marginal over the poses that are touched afterwards is the prior of a small problem, to which
the edges that came or went since are added, and new poses. Its solution tells where all other
poses move, so to first order nothing is lost, and a step costs the same in a large map but for
the columns of the inverse at poses that are touched for the first time.

Source: Kaess and Dellaert 2009 for the columns; Dellaert and Kaess 2017, "Factor graphs for robot
perception", for the marginal as a prior. That edges are taken out of it again is derived here.
"""

from dataclasses import dataclass

import numpy as np

from robust_slam._arrays import Array, Indices, Mask, times
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.graphs.pose_graph import PoseGraph, jacobians, residuals, rows_of, select


@dataclass(frozen=True, eq=False)
class Move:
    """The ``poses`` ``(n, …)`` after a step, and the largest angles (rad, of one axis).

    ``turned`` is that of the step, and ``since`` that since the factorisation.
    """

    poses: Array
    turned: float
    since: float


class Window:
    """The ``kept`` edges ``(m,)`` of ``graph``, factorised at ``poses`` ``(n, …)``.

    Its methods are about the graph as it is now, whose later edges and poses follow those of
    ``graph``.

    Raises:
        Underdetermined: the edges do not determine the map to working precision.
    """

    def __init__(self, graph: PoseGraph, poses: Array, kept: Mask) -> None:
        equations = NormalEquations(select(graph, kept))
        here = equations.at(poses, np.ones(len(equations.graph.edges)))
        factors, gradient = equations.factorise(here)
        self._factors, self._start, self._kept = factors, poses.copy(), kept.copy()
        self._mean = factors.solve(-gradient[..., None])[..., 0]
        self._place: dict[int, int] = {}
        self._columns = np.empty((0, gradient.size))
        self._information: Array = np.empty((0, 0))

    def size(self, graph: PoseGraph, kept: Mask) -> int:
        """Return how many poses the small problem has, if ``kept`` edges ``(m,)`` are kept."""
        added, removed = self._changes(kept)
        touched = set(self._old(graph, added | removed).tolist())
        return len(touched | self._place.keys()) + graph.n - len(self._start)

    def stepped(self, graph: PoseGraph, poses: Array, kept: Mask) -> Move:
        """Return the move of a Gauss–Newton step from ``poses``, with the ``kept`` edges."""
        group, n = graph.group, len(self._start)
        unknown = self._unknown(graph, kept)
        step = -np.linalg.solve(*self._system(graph, poses, kept, unknown))
        twists = np.asarray(step.reshape(-1, group.DOF), dtype=np.float64)
        after = poses.copy()
        after[unknown] = group.compose(poses[unknown], group.exp(twists))
        old = unknown[: len(self._place)]
        pull = self._information @ self._deviation(graph, after, old).ravel()
        moved = self._mean + (pull @ self._columns).reshape(self._mean.shape)
        after[:n] = group.compose(self._start, group.exp(moved))
        d = group.DIMENSION
        return Move(after, _largest(twists[:, d:]), _largest(moved[:, d:]))

    def covariance(self, graph: PoseGraph, poses: Array, kept: Mask, at: Indices) -> Array:
        """Return the joint covariance ``(p, D, p, D)`` of the poses ``at`` ``(p,)``."""
        self._touch(at[at < len(self._start)])
        unknown = self._unknown(graph, kept)
        whole = np.linalg.inv(self._system(graph, poses, kept, unknown)[0])
        size = graph.group.DOF
        place = np.full(graph.n, -1)
        place[unknown] = np.arange(unknown.size)
        blocks = np.zeros((unknown.size + 1, size, unknown.size + 1, size))
        blocks[:-1, :, :-1] = whole.reshape(unknown.size, size, unknown.size, size)
        return np.asarray(blocks[place[at]][:, :, place[at]])

    def _changes(self, kept: Mask) -> tuple[Mask, Mask]:
        """Return which edges ``(m,)`` came and which went since the factorisation."""
        before = np.zeros(kept.size, dtype=np.bool_)
        before[: self._kept.size] = self._kept
        return kept & ~before, before & ~kept

    def _old(self, graph: PoseGraph, edges: Mask) -> Indices:
        """Return the poses of the factorisation that ``edges`` ``(m,)`` touch, without pose 0."""
        ends = np.unique(graph.edges[edges])
        return ends[(ends > 0) & (ends < len(self._start))]

    def _unknown(self, graph: PoseGraph, kept: Mask) -> Indices:
        """Return the poses of the small problem: those that were touched, and new ones."""
        added, removed = self._changes(kept)
        self._touch(self._old(graph, added | removed))
        return np.concatenate(
            [np.array([*self._place], dtype=np.intp), np.arange(len(self._start), graph.n)]
        )

    def _touch(self, poses: Indices) -> None:
        """Solve for the columns of the covariance at further ``poses``."""
        new = [pose for pose in poses.tolist() if pose > 0 and pose not in self._place]
        if not new:
            return
        n, size = self._mean.shape
        right = np.zeros((n, size, len(new), size))
        right[new, :, np.arange(len(new))] = np.eye(size)
        solved = self._factors.solve(right).reshape(n * size, -1).T
        self._columns = np.concatenate([self._columns, solved])
        self._place.update((pose, len(self._place) + k) for k, pose in enumerate(new))
        at = (np.array([*self._place])[:, None] * size + np.arange(size)).ravel()
        self._information = np.asarray(np.linalg.inv(self._columns[:, at]), dtype=np.float64)

    def _deviation(self, graph: PoseGraph, poses: Array, old: Indices) -> Array:
        """Return how far ``old`` poses are from the mean of the prior, ``(t, D)``."""
        moved = graph.group.log(graph.group.between(self._start[old], poses[old]))
        return np.asarray(moved - self._mean[old])

    def _system(
        self, graph: PoseGraph, poses: Array, kept: Mask, unknown: Indices
    ) -> tuple[Array, Array]:
        """Return the Hessian and the gradient over ``unknown`` poses, of all their entries."""
        group, size = graph.group, graph.group.DOF
        old, count = unknown[: len(self._place)], len(self._place)
        place = np.full(graph.n, -1)
        place[unknown] = np.arange(unknown.size)
        # The last row and column belong to pose 0, which does not move.
        hessian = np.zeros((unknown.size + 1, size, unknown.size + 1, size))
        gradient = np.zeros((unknown.size + 1, size))
        added, removed = self._changes(kept)
        fresh = rows_of(graph, added)
        r, by = residuals(fresh, poses), jacobians(fresh, poses)
        _add(hessian, gradient, place, fresh, r, by, 1.0)
        # The prior holds edges as they were linearised, so they go as they came.
        information = self._information.reshape(count, size, count, size).copy()
        deviation = self._deviation(graph, poses, old)
        pull = (self._information @ deviation.ravel()).reshape(count, size)
        gone = rows_of(graph, removed)
        if len(gone.edges):
            taken = np.zeros_like(hessian), np.zeros_like(gradient)
            lost, start = jacobians(gone, self._start), residuals(gone, self._start)
            moved = np.zeros((unknown.size + 1, size))
            moved[:count] = deviation + self._mean[old]
            i, j = place[gone.edges.T]
            r = start + times(lost[0], moved[i]) + times(lost[1], moved[j])
            _add(*taken, place, gone, r, lost, -1.0)
            information += taken[0][:count, :, :count]
            pull += taken[1][:count]
        turn = group.inverse_right_jacobian(deviation + self._mean[old])
        hessian[:count, :, :count] += np.einsum(
            "kab,kalc,lcd->kbld", turn, information, turn, optimize=True
        )
        gradient[:count] += np.einsum("kab,ka->kb", turn, pull)
        free = unknown.size * size
        return hessian[:-1, :, :-1].reshape(free, free), gradient[:-1].ravel()


def _add(
    hessian: Array,
    gradient: Array,
    place: Indices,
    part: PoseGraph,
    r: Array,
    by: tuple[Array, Array],
    sign: float,
) -> None:
    """Add to both what the edges of ``part`` contribute, times ``sign``."""
    ends = place[part.edges.T]
    for a in (0, 1):
        weighted = sign * np.swapaxes(by[a], 1, 2) @ part.information
        np.add.at(gradient, ends[a], times(weighted, r))
        for b in (0, 1):
            np.add.at(np.swapaxes(hessian, 1, 2), (ends[a], ends[b]), weighted @ by[b])


def _largest(angles: Array) -> float:
    return float(np.abs(angles).max(initial=0.0))
