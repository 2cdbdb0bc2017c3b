"""What a file of a pose graph holds: the graph, its ids, and what was not used of the file."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from robust_slam._arrays import Array, Ids, Indices, Mask
from robust_slam._words import counted, so_do
from robust_slam.graphs.pose_graph import PoseGraph

_UNTESTED = "no edge is a loop closure, so the map is the odometry alone, and nothing tests it"
Names: TypeAlias = NDArray[Any]
"""Ids as a file writes them: whole numbers, or words such as A7."""


class GraphFileError(ValueError):
    """A file is invalid; the message is ``file:line: problem; remedy``."""


@dataclass(frozen=True, eq=False, repr=False)
class GraphFile:
    """The content of a file.

    ``poses`` are its vertices, ``(n, 3)`` or ``(n, 3, 4)``, in the order of the graph, or None.
    ``ids`` ``(n,)`` are whole numbers for poses 0 to n − 1, and ``names`` ``(n,)`` the same as the
    file writes them. ``repaired`` ``(k,)`` are the edges whose information was replaced,
    ``skipped`` maps each skipped tag to its number of lines, ``notes`` are sentences about how the
    file was understood, and ``doubts`` about what it hardly meant to hold, such as degrees.
    ``times`` ``(n,)`` (s) are those of a trajectory, and ``w_first`` tells that its quaternions
    begin with w. Of a graph, ``lines`` ``(m,)`` are those of its edges, and ``turns`` ``(m, a)``
    the sizes of the angles (rad) in them, if there are such.
    """

    graph: PoseGraph
    poses: Array | None
    ids: Ids
    names: Names
    repaired: Indices = field(default_factory=lambda: np.empty(0, dtype=np.intp))
    skipped: dict[str, int] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    times: Array | None = None
    doubts: tuple[str, ...] = ()
    w_first: bool = False
    lines: Ids = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    turns: Array = field(default_factory=lambda: np.empty((0, 0)))

    def __repr__(self) -> str:
        return f"<GraphFile: {repr(self.graph)[1:-1]}, {counted(len(self.remarks()), 'remark')}>"

    def named(self, edge: int) -> str:
        """Return the ids of an edge, such as 7-8."""
        i, j = self.names[self.graph.edges[edge]]
        return f"{i}-{j}"

    def as_closure(self, edge: int) -> str:
        """Return how an edge is said to be a closure, at the command and in Python."""
        return f"--closure {self.named(edge)}, or False in is_odometry (entry {edge})"

    def nearest(self, t: ArrayLike) -> Indices:
        """Return the numbers ``(…)`` of the poses nearest in time to ``t`` ``(…)`` (s).

        Raises:
            ValueError: the file has no times, or no pose is within a usual step of a t.
        """
        if self.times is None:
            raise ValueError("the file has no times; give the numbers of poses")
        step = float(np.median(np.diff(np.sort(self.times))))
        asked = np.asarray(t, dtype=np.float64)
        off, found = KDTree(self.times[:, None]).query(asked[..., None])
        for far in asked[off > step][:1]:
            raise ValueError(f"t: {far} s is over {step:.3g} s, a usual step, from every pose")
        return np.asarray(found, dtype=np.intp)

    @property
    def odometry(self) -> Indices:
        """The odometry, ascending."""
        return np.flatnonzero(self.graph.is_odometry)

    def steps_between(self, i: str, j: str) -> Mask:
        """Return the odometry ``(m,)`` between two ids of the file, in either order."""
        ends = np.sort(self.names[self.graph.edges].astype(np.str_), axis=1)
        found: Mask = self.graph.is_odometry & np.all(ends == sorted((i, j)), axis=1)
        return found

    def remarks(self) -> list[str]:
        """Return a sentence for each thing that was replaced, skipped, assumed, or looks wrong."""
        matrices = counted(len(self.graph.edges), "information matrix", "information matrices")
        replaced = f"{self.repaired.size:,} of {matrices} not positive definite and replaced"
        return [
            *([replaced] if self.repaired.size else []),
            *skipped_told(self.skipped),
            *self.notes,
            *self.doubts,
            *self._leap_told(),
            *([_UNTESTED] if np.all(self.graph.is_odometry) else []),
        ]

    def _leap_told(self) -> list[str]:
        """Return a sentence about odometry between ids further apart than neighbours usually."""
        usual = np.median(np.diff(np.sort(self.ids)))
        apart = np.abs(np.diff(self.ids[self.graph.edges], axis=1)[:, 0])
        leaps = np.flatnonzero(self.graph.is_odometry & (apart > usual))
        return [
            f"edge {self.named(k)} crosses a gap in the ids{so_do(leaps.size - 1)} and counts as "
            f"odometry, which is trusted; if it is a loop closure, name it: {self.as_closure(k)}"
            for k in leaps[:1]
        ]

    def summary(self) -> str:
        """Return the table of the graph's ``summary``, and a line for each of the ``remarks``."""
        notes = (f"{'note':<10} {words}" for words in self.remarks())
        return "\n".join([self.graph.summary(), *notes])

    __str__ = summary


def skipped_told(skipped: Mapping[str, int]) -> list[str]:
    """Return a sentence for each tag that was skipped, with its number of lines."""
    return [f"skipped {counted(n, 'line')} with the tag {tag}" for tag, n in skipped.items()]
