"""One robot of a fleet: what it knows, what it tells, and how it improves its own poses.

It holds its own poses, the edges that touch them, and of the other robots only the
*boundary*: the poses at the other end of an edge that two robots share. All that leaves it
is a ``Message``.

A boundary pose stands still while the robot improves its own. So an edge to it measures an
own pose in the common frame, and what is left is a pose graph like any other, whose pose 0
is that frame.

Source: Tian et al. 2022, Kimera-Multi, with a Gauss–Newton step on the block of a robot in
place of a Riemannian one, and a vote of three edges in place of its average of frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.estimators.graduation import GncTls
from robust_slam.graphs import pose_graph
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem


@dataclass(frozen=True)
class Message:
    """What one robot tells another: boundary poses, weights of shared edges, or a word.

    ``poses`` and ``weights`` are by the numbers of poses and edges in the whole graph;
    ``word`` is a residual, a distance in m, or a flag.
    """

    sender: int
    receiver: int
    poses: Mapping[int, Array] = field(default_factory=dict)
    weights: Mapping[int, float] = field(default_factory=dict)
    word: float | None = None

    @property
    def numbers(self) -> int:
        """How many floats cross; the numbers of poses and edges are not counted."""
        told = sum(pose.size for pose in self.poses.values())
        return told + len(self.weights) + (self.word is not None)


class Robot:
    """One robot, and all that it knows.

    ``own`` ``(k,)`` are the numbers of its poses, ``poses`` ``(k, …)`` where it believes
    they are; ``number`` ``(e,)`` are those of the edges that touch them, ``weights``
    ``(e,)`` what the edges weigh. The last edges, ``shared``, lead from ``outside`` to
    ``inside`` and belong to a ``neighbour`` too. ``seen`` are the boundary poses that
    neighbours have told.

    Raises:
        ValueError: the robot's own edges do not join its poses.
    """

    def __init__(self, name: int, graph: PoseGraph, labels: Indices) -> None:
        owner = labels[graph.edges]
        touches = np.sum(owner == name, axis=1)
        self.name, self.group = name, graph.group
        self.own = np.flatnonzero(labels == name)
        self.number = np.concatenate([np.flatnonzero(touches == 2), np.flatnonzero(touches == 1)])
        self.shared = slice(int(np.sum(touches == 2)), None)
        self.judged = (owner[:, 0] == name)[self.number] & ~graph.is_odometry[self.number]
        self.weights = np.ones(len(self.number))
        self.seen: dict[int, Array] = {}
        ends = self._take(graph, owner[self.number, 0] == name)
        self.outside, self.inside = ends[self.shared].T
        self.neighbour = labels[self.outside]
        self._ends = np.searchsorted(self.own, ends) + 1
        self._ends[self.shared, 0] = 0
        inner = slice(self.shared.start)
        is_odometry = graph.is_odometry[self.number[inner]]
        alone = self._ends[inner] - 1, self._z[inner], self._information[inner], is_odometry
        try:
            self.poses = spanning_tree(PoseGraph(len(self.own), *alone))
        except ValueError as error:
            raise ValueError(f"robot {name}, its poses counted from 0: {error}") from None

    def _take(self, graph: PoseGraph, begins: Mask) -> Indices:
        """Copy the edges, shared ones as seen from outside; return their ends ``(e, 2)``."""
        ends: Indices = graph.edges[self.number]
        z = graph.measurement[self.number]
        information = graph.information[self.number]
        back = np.flatnonzero(begins)
        back = back[back >= self.shared.start]
        # Log(z⁻¹ x_i⁻¹ x_j) is −Ad(z⁻¹) Log(z x_j⁻¹ x_i), so the norm stays what it was.
        turn = self.group.adjoint(self.group.inverse(z[back]))
        information[back] = np.swapaxes(turn, 1, 2) @ information[back] @ turn
        ends[back], z[back] = ends[back, ::-1], self.group.inverse(z[back])
        self._z, self._information = z, information
        return ends

    def tell(self) -> list[Message]:
        """Return a message to each neighbour: where this side of the boundary is."""
        messages = []
        for other in np.unique(self.neighbour):
            border = np.unique(self.inside[self.neighbour == other])
            places = self.poses[np.searchsorted(self.own, border)]
            poses = dict(zip(border.tolist(), places, strict=True))
            messages.append(Message(self.name, int(other), poses=poses))
        return messages

    def hear(self, message: Message) -> None:
        """Keep the boundary poses and the weights that a neighbour tells."""
        self.seen.update(message.poses)
        for edge, weight in message.weights.items():
            self.weights[self.number == edge] = weight

    def frames(self) -> Array:
        """Return where each shared edge to a known pose puts the own frame, ``(f, …)``."""
        known = [k for k, pose in enumerate(self.outside.tolist()) if pose in self.seen]
        there = np.array([self.seen[pose] for pose in self.outside[known].tolist()])
        here = self.poses[np.searchsorted(self.own, self.inside[known])]
        measured = self.group.compose(there, self._z[self.shared][known])
        return self.group.compose(measured, self.group.inverse(here))

    def vote(self) -> tuple[float, int]:
        """Return how well the shared edges agree about the frame (m), and on which of them.

        For each edge that is the mean distance between the own poses as it puts them and as
        the second nearest other edge does: three have to agree. It is inf if there are fewer.

        Source: derived here.
        """
        frames = self.frames()
        place = self.group.translation(self.group.compose(frames[:, None], self.poses))
        apart = np.linalg.norm(place[:, None] - place, axis=-1).mean(axis=-1)
        if len(frames) < 3:
            return np.inf, 0
        third = np.sort(apart, axis=1)[:, 2]
        return float(third.min()), int(third.argmin())

    def join(self) -> None:
        """Move the whole map to where the best voted edge puts it."""
        self.poses = self.group.compose(self.frames()[self.vote()[1]], self.poses)

    def block(self) -> tuple[PoseGraph, Array]:
        """Return the robot's own problem and its poses: 0 is the frame, k + 1 the own pose k.

        The boundary stands still, so a shared edge measures an own pose in the frame. One
        further edge holds the first pose; it counts when no shared edge is trusted.
        """
        z = self._z.copy()
        for k, pose in enumerate(self.outside.tolist(), self.shared.start):
            z[k] = self.group.compose(self.seen[pose], z[k])
        graph = PoseGraph(
            n=len(self.own) + 1,
            edges=np.concatenate([self._ends, [[0, 1]]]),
            measurement=np.concatenate([z, self.poses[:1]]),
            information=np.concatenate([self._information, [np.eye(self.group.DOF)]]),
            is_odometry=np.ones(len(z) + 1, dtype=np.bool_),
        )
        return graph, np.concatenate([[self.group.identity()], self.poses])

    def norms(self) -> Array:
        """Return the whitened residual norms ``(j,)`` of the edges that this robot judges."""
        graph, poses = self.block()
        norms: Array = pose_graph.residual_norms(poses, graph)[:-1][self.judged]
        return norms

    def improve(self, tol: float) -> list[Message]:
        """Take one step on the own poses; tell the boundary if one moved by ``tol`` (m, rad)."""
        graph, poses = self.block()
        lone = not np.any(self.weights[self.shared] > 0.0)
        problem = PoseGraphProblem(graph, poses, steps=1)
        better = problem.solve(np.append(self.weights, float(lone)), poses)[1:]
        # Who hardly moves stays, so that others know exactly where the boundary is.
        if np.abs(self.group.log(self.group.between(self.poses, better))).max() <= tol:
            return []
        self.poses = better
        return self.tell()

    def weigh(self, rule: GncTls, mu: float) -> list[Message]:
        """Weigh the edges that this robot judges; tell the shared weights that changed."""
        before = self.weights.copy()
        self.weights[self.judged] = rule.weights(self.norms(), mu)
        changed = np.flatnonzero((self.weights != before)[self.shared])
        told: dict[int, dict[int, float]] = {}
        for k in changed.tolist():
            edge = self.shared.start + k
            weights = told.setdefault(int(self.neighbour[k]), {})
            weights[int(self.number[edge])] = float(self.weights[edge])
        return [Message(self.name, other, weights=weights) for other, weights in told.items()]
