"""Distributed graduated non-convexity for a few robots, each with its own poses.

In a round one robot after another improves its own poses while the boundary is fixed, and
sends its side of the boundary to its neighbours, so no round increases the weighted cost.
Every few rounds the weights are computed from the residuals as in ``gnc``; the robot of its
first end weighs a shared edge and sends the weight to the other. Common decisions take one
number of each robot: which robot joins next, the first μ, and when to stop.

No pose is fixed: the robots agree on one frame up to a common rigid motion, and pose 0, sent
to all, defines the final frame. Fixing pose 0 from the beginning would make the convergence
many times slower.

Source: Tian et al. 2022, Kimera-Multi; Yang et al. 2020, (14) for the weights and Remark 5
for the first μ.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from math import inf

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, Indices
from robust_slam.estimators.graduation import GncTls
from robust_slam.estimators.result import StopReason
from robust_slam.fleet.robot import Message, Robot
from robust_slam.graphs.pose_graph import PoseGraph, check_graph


@dataclass(frozen=True, eq=False)
class Round:
    """The global state of the fleet after a round, which no robot knows.

    ``poses`` ``(n, …)`` are in the frame of pose 0, ``weights`` are ``(m,)``; ``messages``
    and ``numbers`` count what was sent so far. ``mu`` is None before the first weights.
    """

    poses: Array
    weights: Array
    mu: float | None
    messages: int
    numbers: int


@dataclass(frozen=True, eq=False)
class Outcome:
    """All rounds since the robots met, and the reason for stopping."""

    rounds: tuple[Round, ...]
    stop: StopReason


class Fleet:
    """Robots in radio contact: it carries their messages, counts them and records rounds.

    ``labels`` ``(n,)`` name the robot of each pose, from 0.

    Raises:
        ValueError: the labels do not fit, or a robot's own edges do not join its poses.

    Source: derived here.
    """

    def __init__(self, graph: PoseGraph, labels: ArrayLike) -> None:
        names = _names(labels, check_graph(graph).n)
        self.graph = graph
        self.robots = [Robot(name, graph, names) for name in range(int(names.max()) + 1)]
        self.first = self.robots[int(names[0])]
        self.messages = self.numbers = 0
        self.rounds: list[Round] = []

    def carry(self, messages: Sequence[Message]) -> bool:
        """Deliver each message; return whether there were any."""
        for message in messages:
            self.robots[message.receiver].hear(message)
        self.messages += len(messages)
        self.numbers += sum(message.numbers for message in messages)
        return len(messages) > 0

    def largest(self, words: Sequence[float]) -> float:
        """Return the largest of one number of each robot, after all robots exchanged theirs."""
        pairs = permutations(range(len(words)), 2)
        self.carry([Message(a, b, word=words[a]) for a, b in pairs])
        return max(words)

    def meet(self) -> None:
        """Bring the maps into one frame, one by one, always the robot with the best vote next."""
        self.carry(self.first.tell())
        waiting = [robot for robot in self.robots if robot is not self.first]
        while waiting:
            disagreement = {robot.name: robot.vote()[0] for robot in waiting if robot.seen}
            self.largest([-disagreement.get(robot.name, inf) for robot in self.robots])
            best = self.robots[min(disagreement, key=lambda name: disagreement[name])]
            best.join()
            self.carry(best.tell())
            waiting.remove(best)

    def weigh(self, rule: GncTls, mu: float) -> bool:
        """Let each robot weigh its edges; return whether every weight is 0 or 1."""
        for robot in self.robots:
            self.carry(robot.weigh(rule, mu))
        # Clipping makes 0 and 1 exact.
        open_weights = [r.weights[(r.weights > 0.0) & (r.weights < 1.0)] for r in self.robots]
        return not self.largest([float(some.size > 0) for some in open_weights])

    def descend(self, mu: float | None, tol: float, count: int) -> bool:
        """Run up to ``count`` rounds; return whether no pose moved by ``tol`` in the last."""
        for _ in range(count):
            moved = [self.carry(robot.improve(tol)) for robot in self.robots]
            converged = not self.largest([float(robot) for robot in moved])
            self.record(mu)
            if converged:
                return True
        return False

    def finish(self, stop: StopReason, mu: float | None, tol: float, count: int) -> Outcome:
        """Return all rounds after convergence, or ITERATION_LIMIT after ``count`` rounds."""
        converged = self.descend(mu, tol, count)
        return Outcome(tuple(self.rounds), stop if converged else StopReason.ITERATION_LIMIT)

    def record(self, mu: float | None) -> None:
        """Record the poses and weights of all robots, for analysis outside the fleet."""
        poses = np.empty((self.graph.n, *self.graph.group.POSE_SHAPE))
        weights = np.ones(len(self.graph.edges))
        for robot in self.robots:
            poses[robot.own], weights[robot.number] = robot.poses, robot.weights
        poses = self.graph.group.between(poses[0], poses)
        self.rounds.append(Round(poses, weights, mu, self.messages, self.numbers))


def solve(
    graph: PoseGraph,
    labels: ArrayLike,
    c: float,
    *,
    factor: float = 1.4,
    every: int = 2,
    tol: float = 1e-6,
    max_rounds: int = 2000,
) -> Outcome:
    """Run GNC-TLS on a fleet; all edges except odometry are untrusted, as in ``gnc``.

    ``labels`` ``(n,)`` name the robot of each pose, from 0; its own edges must join its poses.
    ``c`` and ``factor`` are those of ``estimators.gnc``. Each μ lasts ``every`` rounds. When each
    weight is 0 or 1, more rounds follow until no pose moves by ``tol`` (m, rad). It stops with
    BINARY_WEIGHTS or NOTHING_TO_REJECT, or with ITERATION_LIMIT if ``max_rounds`` are not enough
    for the weights or for the convergence after them.

    Round 0 is the start, after the robots have met. If all edges between two parts of the
    fleet are rejected, the relative pose of these parts is undetermined.

    Raises:
        ValueError: as ``Fleet`` and ``estimators.gnc``, or a limit is out of range.

    Source: Tian et al. 2022, with the schedule of Yang et al. 2020, Remark 5.

    >>> from robust_slam.graphs import manhattan, Noise
    >>> graph, _ = manhattan(40, np.random.default_rng(0), side=3, closures=20)
    >>> outcome = solve(graph, labels=np.arange(40) // 20, c=3.368)
    >>> outcome.stop.value, len(outcome.rounds) > 1
    ('binary weights', True)
    """
    if every < 1 or max_rounds < 1 or not tol > 0.0:
        raise ValueError(f"every {every}, max_rounds {max_rounds}, tol {tol}: give more than 0")
    rule, fleet = GncTls(c, factor), Fleet(graph, labels)
    fleet.meet()
    fleet.record(None)
    worst = fleet.largest([float(r.norms().max(initial=0.0)) for r in fleet.robots])
    state = rule.start(np.array([worst]))
    if isinstance(state, StopReason):
        return fleet.finish(state, None, tol, max_rounds)
    while not fleet.weigh(rule, state):
        if len(fleet.rounds) > max_rounds:
            return Outcome(tuple(fleet.rounds), StopReason.ITERATION_LIMIT)
        fleet.descend(state, tol, every)
        state *= factor
    return fleet.finish(StopReason.BINARY_WEIGHTS, state, tol, max_rounds)


def _names(labels: ArrayLike, n: int) -> Indices:
    names = np.array(labels)
    if names.shape != (n,) or not np.issubdtype(names.dtype, np.integer):
        raise ValueError(f"labels: give {n} whole numbers, the robot of each pose")
    found = np.unique(names)
    if len(found) < 2 or not np.array_equal(found, np.arange(len(found))):
        raise ValueError("labels: number the robots, two at least, 0, 1, 2, … without a gap")
    return np.asarray(names, dtype=np.intp)
