"""What a file of a pose graph holds: the graph, its ids, and what was not used of the file."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from robust_slam._arrays import Array, Ids, Indices, Mask
from robust_slam._words import counted, so_do
from robust_slam.graphs.pose_graph import PoseGraph

_UNTESTED = "no edge is a loop closure, so the map is the odometry alone, and nothing tests it"
Names: TypeAlias = NDArray[Any]
"""Ids as a file writes them: whole numbers, or words such as A7."""


class GraphFileError(ValueError):
    """A file is invalid; the message is ``file:line: problem; remedy``."""


def as_closure(named: str, edge: int) -> str:
    """Return how an edge is said to be a closure, at the command and in Python."""
    return f"--closure {named}, or False in is_odometry (entry {edge})"


@dataclass(frozen=True, eq=False, repr=False)
class GraphFile:
    """The content of a file.

    ``poses`` are its vertices, ``(n, 3)`` or ``(n, 3, 4)``, in the order of the graph, or None.
    ``ids`` ``(n,)`` are whole numbers for poses 0 to n − 1, and ``names`` ``(n,)`` the same as the
    file writes them. ``repaired`` ``(k,)`` are the edges whose information was replaced,
    ``skipped`` maps each skipped tag to its number of lines, ``notes`` are sentences about how the
    file was understood, and ``doubts`` about what it hardly meant to hold, such as degrees.
    ``times`` ``(n,)`` (s) are those of a trajectory, and ``w_first`` tells that its quaternions
    begin with w.
    """

    graph: PoseGraph
    poses: Array | None
    ids: Ids
    names: Names
    repaired: Indices = dataclasses.field(default_factory=lambda: np.empty(0, dtype=np.intp))
    skipped: dict[str, int] = dataclasses.field(default_factory=dict)
    notes: tuple[str, ...] = ()
    times: Array | None = None
    doubts: tuple[str, ...] = ()
    w_first: bool = False

    def __repr__(self) -> str:
        return f"<GraphFile: {repr(self.graph)[1:-1]}, {counted(len(self.remarks()), 'remark')}>"

    @property
    def leaps(self) -> Indices:
        """The odometry, ascending, between ids further apart than neighbouring ids mostly are."""
        usual = np.median(np.diff(np.sort(self.ids)))
        apart = np.abs(np.diff(self.ids[self.graph.edges], axis=1)[:, 0])
        leaps: Indices = np.flatnonzero(self.graph.is_odometry & (apart > usual))
        return leaps

    def steps_between(self, i: str, j: str) -> Mask:
        """Return the odometry ``(m,)`` between two ids of the file, in either order."""
        ends = np.sort(self.names[self.graph.edges].astype(np.str_), axis=1)
        found: Mask = self.graph.is_odometry & np.all(ends == sorted((i, j)), axis=1)
        return found

    def remarks(self) -> list[str]:
        """Return a sentence for each thing that was replaced, skipped, assumed, or looks wrong."""
        replaced = (
            f"{self.repaired.size:,} of "
            f"{counted(len(self.graph.edges), 'information matrix', 'information matrices')} "
            "not positive definite and replaced"
        )
        return [
            *([replaced] if self.repaired.size else []),
            *(
                f"skipped {counted(count, 'line')} with the tag {tag}"
                for tag, count in self.skipped.items()
            ),
            *self.notes,
            *self.doubts,
            *self._leap_told(),
            *([_UNTESTED] if np.all(self.graph.is_odometry) else []),
        ]

    def _leap_told(self) -> list[str]:
        """Return a sentence about odometry across a gap in the ids, if there is some."""
        if not self.leaps.size:
            return []
        i, j = self.names[self.graph.edges[self.leaps[0]]]
        return [
            f"edge {i}-{j} crosses a gap in the ids{so_do(self.leaps.size - 1)} and counts as "
            "odometry, which is trusted; if it is a loop closure, name it: "
            f"{as_closure(f'{i}-{j}', self.leaps[0])}"
        ]

    def summary(self) -> str:
        """Return the table of the graph's ``summary``, and a line for each of the ``remarks``."""
        return "\n".join(
            [self.graph.summary(), *(f"{'note':<10} {words}" for words in self.remarks())]
        )

    __str__ = summary
