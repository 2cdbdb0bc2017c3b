"""The map since its last factorisation: a small problem that stands for the whole one.

Most closures join a few poses only. At a factorisation the map is a Gaussian over all its poses;
its marginal over the poses that are touched afterwards is the prior of a small problem, to which
the edges that came or went since are added, and new poses. Its solution tells where all other
poses move, so to first order nothing is lost, and a step costs the same in a large map but for
the columns of the inverse at poses that are touched for the first time.

Source: Kaess and Dellaert 2009 for the columns; Dellaert and Kaess 2017, "Factor graphs for robot
perception", for the marginal as a prior. That edges are taken out of it again is derived here.
"""

import numpy as np

from robust_slam._arrays import Array, Indices, Mask, times
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.step import retract
from robust_slam.graphs.pose_graph import (
    PoseGraph,
    linearise,
    relative_poses,
    residuals_of,
    rows_of,
    select,
)


class Window:
    """The ``kept`` edges ``(m,)`` of ``graph``, factorised at ``poses`` ``(n, …)``.

    ``mean`` ``(n, D)`` is the Gauss–Newton step from there. The methods are about the graph as it
    is now, whose later edges and poses follow those of ``graph``, and its ``kept`` edges.

    Raises:
        Underdetermined: the edges do not determine the map to working precision.
    """

    def __init__(self, graph: PoseGraph, poses: Array, kept: Mask) -> None:
        equations = NormalEquations(select(graph, kept))
        here = equations.at(poses, np.ones(len(equations.graph.edges)))
        self._factors, gradient = equations.factorise(here)
        self._start, self._kept = poses.copy(), kept.copy()
        self.mean: Array = self._factors.solve(-gradient[..., None])[..., 0]
        self._touched = np.empty(0, dtype=np.intp)
        self._is_touched = np.arange(len(poses)) == 0  # pose 0 does not move
        self._columns = np.empty((0, gradient.size))
        self._information: Array = np.empty((0, 0))

    def size(self, graph: PoseGraph, kept: Mask) -> int:
        """Return how many poses the small problem has."""
        edges = graph.edges[np.logical_or(*self._changes(kept))]
        return self._touched.size + self._new(edges).size + graph.n - len(self._start)

    def stepped(self, graph: PoseGraph, poses: Array, kept: Mask) -> tuple[Array, float, float]:
        """Return the ``poses`` ``(n, …)`` after a Gauss–Newton step, and the largest angles (rad).

        These are of one axis: that of the step, and that since the factorisation.
        """
        group, n = graph.group, len(self._start)
        hessian, gradient, unknown, _ = self._system(graph, poses, kept)
        solved = -np.linalg.solve(hessian, gradient).reshape(-1, group.DOF)
        step = np.asarray(solved, dtype=np.float64)
        after = poses.copy()
        after[unknown] = group.compose(poses[unknown], group.exp(step))
        pull = self._information @ (self._moved(graph, after) - self.mean[self._touched]).ravel()
        moved = self.mean + (pull @ self._columns).reshape(self.mean.shape)
        after[:n] = retract(graph, self._start, moved)
        return after, largest_angle(graph, step), largest_angle(graph, moved)

    def predicted(self, graph: PoseGraph, poses: Array, kept: Mask, asked: PoseGraph) -> Array:
        """Return the joint covariance ``(k, D, k, D)`` of what the map predicts for ``asked``."""
        self._touch(asked.edges)
        hessian, _, unknown, place = self._system(graph, poses, kept)
        k, size = asked.information.shape[:2]
        rows = np.zeros((k, size, unknown.size + 1, size))
        for ends, by in zip(asked.edges.T, linearised(asked, poses)[1:], strict=True):
            rows[np.arange(k), :, place[ends]] += by
        flat = rows[:, :, :-1].reshape(k * size, -1)
        return (flat @ np.linalg.solve(hessian, flat.T)).reshape(k, size, k, size)

    def _changes(self, kept: Mask) -> tuple[Mask, Mask]:
        """Return which edges ``(m,)`` came and which went since the factorisation."""
        before = np.zeros(kept.size, dtype=np.bool_)
        before[: self._kept.size] = self._kept
        return kept & ~before, before & ~kept

    def _new(self, poses: Indices) -> Indices:
        """Return those of ``poses`` that the factorisation has and were not touched, ascending."""
        old = poses[poses < len(self._start)]
        return np.unique(old[~self._is_touched[old]])

    def _touch(self, poses: Indices) -> None:
        """Solve for the columns of the covariance at those of ``poses`` that are new to it."""
        new = self._new(poses)
        if not new.size:
            return
        n, size = self.mean.shape
        right = np.zeros((n, size, new.size, size))
        right[new, :, np.arange(new.size)] = np.eye(size)
        solved = self._factors.solve(right).reshape(n * size, -1).T
        self._columns = np.concatenate([self._columns, solved])
        self._touched = np.concatenate([self._touched, new])
        self._is_touched[new] = True
        at = (self._touched[:, None] * size + np.arange(size)).ravel()
        self._information = np.asarray(np.linalg.inv(self._columns[:, at]), dtype=np.float64)

    def _moved(self, graph: PoseGraph, poses: Array) -> Array:
        """Return how far the touched poses are from the factorisation, ``(t, D)``."""
        start, now = self._start[self._touched], poses[self._touched]
        return np.asarray(graph.group.log(graph.group.between(start, now)))

    def _system(
        self, graph: PoseGraph, poses: Array, kept: Mask
    ) -> tuple[Array, Array, Indices, Indices]:
        """Return the Hessian and the gradient of the small problem, and its poses ``(u,)``.

        The last array ``(n,)`` is the place of each pose among these, −1 for the others.
        """
        group, size = graph.group, graph.group.DOF
        added, removed = self._changes(kept)
        self._touch(graph.edges[added | removed])
        count = self._touched.size
        unknown = np.concatenate([self._touched, np.arange(len(self._start), graph.n)])
        place, free = np.full(graph.n, -1), unknown.size
        place[unknown] = np.arange(free)
        # The last row and column belong to pose 0, which does not move.
        hessian = np.zeros((free + 1, size, free + 1, size))
        gradient, moved = np.zeros((2, free + 1, size))
        moved[:count] = self._moved(graph, poses)
        off = (moved[:count] - self.mean[self._touched]).ravel()
        hessian[:count, :, :count] = self._information.reshape(count, size, count, size)
        gradient[:count] = (self._information @ off).reshape(count, size)
        gone, fresh = rows_of(graph, removed), rows_of(graph, added)
        if len(gone.edges):
            # The prior holds edges as they were linearised, so they go as they came.
            r, by_i, by_j = linearised(gone, self._start)
            i, j = place[gone.edges.T]
            r = r + times(by_i, moved[i]) + times(by_j, moved[j])
            _add(hessian, gradient, place, gone, (r, by_i, by_j), -1.0)
        turn = np.swapaxes(group.inverse_right_jacobian(moved), 1, 2)
        gradient = times(turn, gradient)
        for _ in (0, 1):  # the rows, and then the columns
            turned = (turn @ hessian.reshape(free + 1, size, -1)).reshape(len(turn) * size, -1)
            hessian = turned.T.reshape(hessian.shape)
        _add(hessian, gradient, place, fresh, linearised(fresh, poses), 1.0)
        n = free * size
        return hessian[:-1, :, :-1].reshape(n, n), gradient[:-1].ravel(), unknown, place


def linearised(part: PoseGraph, poses: Array) -> tuple[Array, Array, Array]:
    """Return the residuals ``(m, D)``, and their Jacobians by pose i and by j, ``(m, D, D)``."""
    relative = relative_poses(part, poses)
    r = residuals_of(part, relative)
    by_j, transfer = linearise(part, relative, r)
    return r, by_j @ transfer, by_j


def _add(
    hessian: Array,
    gradient: Array,
    place: Indices,
    part: PoseGraph,
    terms: tuple[Array, Array, Array],
    sign: float,
) -> None:
    """Add to both what the ``linearised`` edges of ``part`` contribute, times ``sign``."""
    ends, (r, *by) = place[part.edges.T], terms
    for a in (0, 1):
        weighted = sign * np.swapaxes(by[a], 1, 2) @ part.information
        np.add.at(gradient, ends[a], times(weighted, r))
        for b in (0, 1):
            np.add.at(np.swapaxes(hessian, 1, 2), (ends[a], ends[b]), weighted @ by[b])


def largest_angle(graph: PoseGraph, twists: Array) -> float:
    """Return the largest angle (rad) of one axis in ``twists`` ``(k, D)``, 0 where k is 0."""
    return float(np.abs(twists[:, graph.group.DIMENSION :]).max(initial=0.0))
