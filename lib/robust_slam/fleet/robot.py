"""One robot of a fleet: its data, its messages, and the optimisation of its own poses.

A robot stores its own poses, their edges, and of the other robots only the *boundary*: the
poses at the other end of shared edges. It communicates by ``Message`` alone.

Boundary poses are fixed while the robot optimises its own. An edge to a boundary pose then
measures an own pose in the common frame, and the subproblem is an ordinary pose graph whose
pose 0 is that frame.

Source: Tian et al. 2022, Kimera-Multi, with a Gauss–Newton step on the block of a robot in
place of a Riemannian one, and a vote of three edges in place of its average of frames.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.estimators.graduation import GncTls
from robust_slam.graphs import pose_graph
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem


@dataclass(frozen=True, eq=False)
class Message:
    """A message between robots: boundary poses, weights of shared edges, or one number.

    ``poses`` and ``weights`` are indexed by poses and edges of the whole graph; ``word`` is
    a residual, a distance in m, or a flag.
    """

    sender: int
    receiver: int
    poses: Mapping[int, Array] = field(default_factory=dict)
    weights: Mapping[int, float] = field(default_factory=dict)
    word: float | None = None

    @property
    def numbers(self) -> int:
        """The number of floats sent, without the indices of poses and edges."""
        coordinates = sum(pose.size for pose in self.poses.values())
        return coordinates + len(self.weights) + (self.word is not None)


class Robot:
    """One robot and its data.

    ``own`` ``(k,)`` are the indices of its poses and ``poses`` ``(k, …)`` their estimates;
    ``number`` ``(e,)`` are the indices of its edges and ``weights`` ``(e,)`` their weights.
    The last edges, ``shared``, lead from ``outside`` to ``inside`` and belong to a
    ``neighbour`` too. ``seen`` are the boundary poses received from neighbours.

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
        """Copy the edges, shared ones directed inwards; return their ends ``(e, 2)``."""
        ends: Indices = graph.edges[self.number]
        z = graph.measurement[self.number]
        information = graph.information[self.number]
        back = np.flatnonzero(begins)
        back = back[back >= self.shared.start]
        # Log(z⁻¹ x_i⁻¹ x_j) is −Ad(z⁻¹) Log(z x_j⁻¹ x_i), so the whitened norm is unchanged.
        adjoint = self.group.adjoint(self.group.inverse(z[back]))
        information[back] = np.swapaxes(adjoint, 1, 2) @ information[back] @ adjoint
        ends[back], z[back] = ends[back, ::-1], self.group.inverse(z[back])
        self._z, self._information = z, information
        return ends

    def tell(self) -> list[Message]:
        """Return a message to each neighbour with the poses on this side of the boundary."""
        messages = []
        for other in np.unique(self.neighbour):
            border = np.unique(self.inside[self.neighbour == other])
            own = self.poses[np.searchsorted(self.own, border)]
            poses = dict(zip(border.tolist(), own, strict=True))
            messages.append(Message(self.name, int(other), poses=poses))
        return messages

    def hear(self, message: Message) -> None:
        """Store the boundary poses and the weights that a neighbour sent."""
        self.seen.update(message.poses)
        for edge, weight in message.weights.items():
            self.weights[self.number == edge] = weight

    def frames(self) -> Array:
        """Return the own frame ``(f, …)`` from each shared edge to a known pose."""
        known = [k for k, pose in enumerate(self.outside.tolist()) if pose in self.seen]
        there = np.array([self.seen[pose] for pose in self.outside[known].tolist()])
        here = self.poses[np.searchsorted(self.own, self.inside[known])]
        measured = self.group.compose(there, self._z[self.shared][known])
        return self.group.compose(measured, self.group.inverse(here))

    def vote(self) -> tuple[float, int]:
        """Return how well the shared edges agree on the frame (m), and the best edge.

        The disagreement of an edge is the mean distance between the own poses in its frame
        and in that of the second closest other edge, so three edges have to agree. It is inf
        if there are fewer than three.
        """
        frames = self.frames()
        positions = self.group.translation(self.group.compose(frames[:, None], self.poses))
        apart = np.linalg.norm(positions[:, None] - positions, axis=-1).mean(axis=-1)
        if len(frames) < 3:
            return np.inf, 0
        third = np.sort(apart, axis=1)[:, 2]
        return float(third.min()), int(third.argmin())

    def join(self) -> None:
        """Move the whole map into the frame of the edge with the best vote."""
        self.poses = self.group.compose(self.frames()[self.vote()[1]], self.poses)

    def block(self) -> tuple[PoseGraph, Array]:
        """Return the robot's own problem and its poses: 0 is the frame, k + 1 the own pose k.

        The boundary is fixed, so a shared edge measures an own pose in the frame. One further
        edge fixes the first pose; it is used when no shared edge has positive weight.
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
        """Return the whitened residual norms ``(j,)`` of the edges that this robot weighs."""
        graph, poses = self.block()
        norms: Array = pose_graph.residual_norms(graph, poses)[:-1][self.judged]
        return norms

    def improve(self, tol: float) -> list[Message]:
        """Take one step on the own poses; send the boundary after a move of ``tol`` (m, rad)."""
        graph, poses = self.block()
        lone = not np.any(self.weights[self.shared] > 0.0)
        problem = PoseGraphProblem(graph, poses, steps=1)
        better = problem.solve(np.append(self.weights, float(lone)), poses)[1:]
        # Steps below tol are dropped, so neighbours keep exact boundary poses.
        if np.abs(self.group.log(self.group.between(self.poses, better))).max() <= tol:
            return []
        self.poses = better
        return self.tell()

    def weigh(self, rule: GncTls, mu: float) -> list[Message]:
        """Compute the weights of this robot's edges; send the shared weights that changed."""
        before = self.weights.copy()
        self.weights[self.judged] = rule.weights(self.norms(), mu)
        changed = np.flatnonzero((self.weights != before)[self.shared])
        told: dict[int, dict[int, float]] = {}
        for k in changed.tolist():
            edge = self.shared.start + k
            weights = told.setdefault(int(self.neighbour[k]), {})
            weights[int(self.number[edge])] = float(self.weights[edge])
        return [Message(self.name, other, weights=weights) for other, weights in told.items()]
