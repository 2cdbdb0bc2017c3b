"""Break the map: how few outliers, and how small ones, make a solver bend a small town?

An attack claims that the town around one pose stands elsewhere than it does. Its closures join
poses i and j, i + 1 and j + 1, …, and all measure what they would if pose j and those after it
were moved by the same whole numbers of metres, so that they agree with each other: perceptual
aliasing. A solver is fooled if its map then is more than ``BOUND`` from the least-squares map
without outliers. The fewer closures do it the better, and among equally many the shortest offset.

A score is written ``A:gnc:1-9:1,-1:2``: the town, the solver, the poses of the first closure, the
offset (m), and how many closures there are. The picture writes it, and the command ``replay`` of
this folder replays it.
"""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from math import hypot

import numpy as np
from robust_slam._arrays import Array
from robust_slam.consistency import pcm
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels
from robust_slam.graphs import Noise, PoseGraph, ate, manhattan
from robust_slam.graphs.pose_graph import select, with_closures
from robust_slam.groups import se2
from robust_slam.problems import PoseGraphProblem

BOUND = 0.5
"""The error (m) beyond which a map is broken."""
REACH = 2
"""The largest offset along either axis (m)."""
MOST = 5
"""The largest number of closures of an attack."""
TOWNS = {"A": (0, 12, 3, 3, 0.1), "B": (0, 12, 4, 3, 0.1), "C": (0, 20, 4, 4, 0.05)}
"""Of each town seed, poses, inliers, streets and the noise of a turn (rad)."""
_C = chi_square_threshold(0.99, 3)
_SCORE = re.compile(r"(\w+):([\w+]+):(\d+)-(\d+):(-?\d),(-?\d):(\d)", re.ASCII)


def _consistent(graph: PoseGraph) -> PoseGraph:
    """Return what PCM keeps; of largest sets the one that comes first, so that it is unique."""
    found = pcm(graph, _C)
    joined, places = found.adjacency, range(found.closures.size)
    first = next(
        each
        for each in combinations(places, found.clique.members.size)
        if all(joined[p, q] for p, q in combinations(each, 2))
    )
    kept = graph.is_odometry.copy()
    kept[found.closures[list(first)]] = True
    return select(graph, kept)


SOLVERS: dict[str, Callable[[PoseGraph], Array]] = {
    "squares": lambda graph: PoseGraphProblem(graph, tol=1e-6).initial(),
    "gm": lambda graph: irls(graph, kernels.geman_mcclure(_C)).poses,
    "gnc": lambda graph: gnc(graph, _C).poses,
    "pcm": lambda graph: gnc(_consistent(graph), _C).poses,
}
"""Least squares, Geman–McClure and GNC from odometry, and PCM before GNC."""


@dataclass(frozen=True)
class Attack:
    """Closures (i, j), (i + 1, j + 1), … ``count`` of them, with one offset (m) in a town."""

    town: str
    solver: str
    i: int
    j: int
    dx: int
    dy: int
    count: int

    def __post_init__(self) -> None:
        for name, value, known in (("town", self.town, TOWNS), ("solver", self.solver, SOLVERS)):
            if value not in known:
                raise ValueError(f"{name} {value}: there is none; give {' or '.join(known)}")
        last = TOWNS[self.town][1] - self.count
        if not (1 <= self.count <= MOST):
            raise ValueError(f"{self.count} closures: give 1 to {MOST}")
        if not (self.i + 2 <= self.j <= last):
            raise ValueError(
                f"poses {self.i}-{self.j}: {self.count} closures of town {self.town} begin at "
                f"poses that are at least 2 apart, the earlier first, the later at most {last}"
            )
        if max(abs(self.dx), abs(self.dy)) > REACH or not (self.dx or self.dy):
            raise ValueError(
                f"offset {self.dx},{self.dy}: give two whole numbers of metres from -{REACH} to "
                f"{REACH}, not both 0"
            )

    def __str__(self) -> str:
        return f"{self.town}:{self.solver}:{self.i}-{self.j}:{self.dx},{self.dy}:{self.count}"

    @property
    def rank(self) -> tuple[int, float]:
        """The number of closures and the length of their offset (m): less is better."""
        return self.count, hypot(self.dx, self.dy)


def attack(score: str) -> Attack:
    """Return the attack that a score tells.

    Raises:
        ValueError: it is no score, or its numbers are out of range.
    """
    found = _SCORE.fullmatch(score.strip())
    if found is None:
        raise ValueError(f"{score!r} is no score; copy it again, such as A:gnc:1-9:1,-1:2")
    town, solver, *numbers = found.groups()
    return Attack(town, solver, *map(int, numbers))


@cache
def town(name: str) -> tuple[PoseGraph, Array, Array]:
    """Return a town of ``TOWNS`` without outliers, its true poses ``(n, 3)`` and its map."""
    seed, poses, closures, side, turn = TOWNS[name]
    noise = Noise(odometry=(0.1, turn))
    graph, truth = manhattan(poses, seed, side=side, turn=0.4, closures=closures, noise=noise)
    return graph, truth, SOLVERS["squares"](graph)


def attacked(what: Attack) -> PoseGraph:
    """Return the town with the closures of an attack as its last edges, without noise.

    They are as precise as the first inlier.
    """
    graph, truth, _ = town(what.town)
    edges = np.array([what.i, what.j]) + np.arange(what.count)[:, None]
    moved = se2.compose(np.array([what.dx, what.dy, 0.0]), truth[edges[:, 1]])
    precise = graph.information[~graph.is_odometry][:1].repeat(what.count, axis=0)
    return with_closures(graph, edges, se2.between(truth[edges[:, 0]], moved), precise)


def bent(what: Attack) -> float:
    """Return how far (m) the solver's map is from the least-squares map without outliers."""
    return float(ate(SOLVERS[what.solver](attacked(what)), town(what.town)[2]))


def attacks(name: str, solver: str) -> Iterator[Attack]:
    """Yield all attacks on a solver in a town, the best scores first."""
    offsets = [(x, y) for x in range(-REACH, REACH + 1) for y in range(-REACH, REACH + 1)]
    poses = TOWNS[name][1]
    for count in range(1, MOST + 1):
        for dx, dy in sorted(offsets, key=lambda each: hypot(*each))[1:]:
            for i in range(poses - count - 1):
                for j in range(i + 2, poses - count + 1):
                    yield Attack(name, solver, i, j, dx, dy, count)
