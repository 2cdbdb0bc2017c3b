"""The edges of a graph that grows, and the poses that its odometry leads to.

Rows are appended to arrays with room to spare, so that an edge costs the same however large the
graph is.

Source: derived here.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_slam._arrays import Array, Indices
from robust_slam.graphs.pose_graph import (
    ROWS,
    PoseGraph,
    checked_rows,
    from_checked,
    unreached,
)
from robust_slam.groups.group import Group, group_of
from robust_slam.solver.noise import rescaled_information


class Growing:
    """An array ``(k, …)`` that rows are appended to; ``rows`` is a view of those so far."""

    def __init__(self, rows: NDArray[Any]) -> None:
        self._room = rows.copy()
        self._used = len(rows)

    @property
    def rows(self) -> NDArray[Any]:
        """The rows so far; a later append does not change them."""
        return self._room[: self._used]

    def append(self, rows: NDArray[Any]) -> None:
        """Append ``rows`` ``(l, …)``."""
        needed = self._used + len(rows)
        if needed > len(self._room):
            room = np.empty((2 * needed, *self._room.shape[1:]), self._room.dtype)
            room[: self._used] = self.rows
            self._room = room
        self._room[self._used : needed] = rows
        self._used = needed


class GrowingEdges:
    """The edges of a graph of ``n`` poses, in the order of arrival.

    ``number`` ``(m,)`` is the number of each edge, which it keeps when others are removed.
    ``factors`` ``(4,)`` are those of ``rescaled``, for ``precise``.
    """

    def __init__(self, graph: PoseGraph) -> None:
        self.n = graph.n
        self._next = len(graph.edges)
        rows = {name: getattr(graph, name) for name in ROWS}
        rows |= {"number": np.arange(self._next), "precise": graph.information}
        self._arrays = {name: Growing(array) for name, array in rows.items()}
        self._graph: PoseGraph | None = graph
        self._factors: Array = np.ones(4)

    @property
    def group(self) -> Group:
        """The module ``se2`` or ``se3`` of the poses."""
        return group_of(self._arrays["measurement"].rows)

    @property
    def number(self) -> Indices:
        """The number of each edge, ``(m,)``, ascending."""
        return self._arrays["number"].rows

    @property
    def graph(self) -> PoseGraph:
        """The graph of all edges; it does not change when further ones are added."""
        if self._graph is None:
            self._graph = from_checked(self.n, {name: self._arrays[name].rows for name in ROWS})
        return self._graph

    @property
    def precise(self) -> PoseGraph:
        """The graph with the noise that ``rescale`` was told."""
        rows = {name: self._arrays[name].rows for name in ROWS}
        return from_checked(self.n, rows | {"information": self._arrays["precise"].rows})

    def rescale(self, factors: Array) -> None:
        """Let ``precise`` have deviations that are ``factors`` ``(4,)`` times the claimed ones."""
        self._factors = factors
        self._arrays["precise"] = Growing(rescaled_information(self.graph, factors))

    def append(self, n: int, rows: dict[str, NDArray[Any]]) -> Indices:
        """Append checked ``rows``, after which there are ``n`` poses; return their numbers."""
        numbers = np.arange(self._next, self._next + len(rows["edges"]))
        precise = rescaled_information(from_checked(n, rows), self._factors)
        for name, added in (rows | {"number": numbers, "precise": precise}).items():
            self._arrays[name].append(added)
        self._next += numbers.size
        self.n, self._graph = n, None
        return numbers

    def row_of(self, number: int) -> int:
        """Return the row of the edge with this ``number``.

        Raises:
            ValueError: there never was one, or it was removed.
        """
        row = int(np.searchsorted(self.number, number))
        if row < self.number.size and self.number[row] == number:
            return row
        was = 0 <= number < self._next
        raise ValueError(
            f"edge {number} was removed before; each edge can be removed once"
            if was
            else f"there is no edge {number}; edges are 0 to {self._next - 1}, as add returned"
        )

    def remove(self, row: int) -> None:
        """Remove the edge of a ``row``.

        Raises:
            ValueError: some pose would not be reached by odometry.
        """
        others = np.arange(self.number.size) != row
        loose = unreached(self.graph, self.graph.is_odometry & others)
        if loose.size:
            i, j = self.graph.edges[row].tolist()
            raise ValueError(
                f"edge {self.number[row]} ({i}-{j}) is the odometry that leads to pose "
                f"{loose[0]}; add odometry in its place before it is removed"
            )
        for name, array in self._arrays.items():
            self._arrays[name] = Growing(np.delete(array.rows, row, axis=0))
        self._graph = None

    def checked(
        self,
        edges: ArrayLike,
        measurement: ArrayLike,
        information: ArrayLike,
        is_odometry: ArrayLike | None,
    ) -> tuple[int, dict[str, NDArray[Any]]]:
        """Return how many poses there are with further edges, and their checked rows.

        Raises:
            ValueError: as ``PoseGraph``.
        """
        ends, n = np.asarray(edges), self.n
        k = len(ends) if ends.ndim else 0
        if ends.ndim == 2 and ends.size and np.issubdtype(ends.dtype, np.integer):
            # Each further pose needs an edge of its own; others are refused by their names.
            n = min(max(n, int(ends.max()) + 1), n + k)
        rows = {
            "edges": edges,
            "measurement": measurement,
            "information": information,
            "is_odometry": np.zeros(k, dtype=np.bool_) if is_odometry is None else is_odometry,
        }
        checked = checked_rows(n, self.group, rows)
        if is_odometry is None:
            low, high = np.sort(checked["edges"], axis=1).T
            checked["is_odometry"] = (high == low + 1) & (high >= self.n)
        return n, checked


def placed(group: Group, poses: Array, n: int, rows: dict[str, NDArray[Any]]) -> Array:
    """Return the poses ``(n − k, …)`` that odometry leads to from the ``poses`` ``(k, …)``.

    Raises:
        ValueError: no odometry among ``rows`` leads to one of them.
    """
    found: dict[int, Array] = {}
    steps = np.flatnonzero(rows["is_odometry"] & np.any(rows["edges"] >= len(poses), axis=1))
    ends, z = rows["edges"][steps].tolist(), rows["measurement"][steps]

    def at(pose: int) -> Array | None:
        return poses[pose] if pose < len(poses) else found.get(pose)

    count = -1
    while count < len(found) < n - len(poses):
        count = len(found)
        for (i, j), measured in zip(ends, z, strict=True):
            tail, head = at(i), at(j)
            if tail is not None and head is None:
                found[j] = group.compose(tail, measured)
            if tail is None and head is not None:
                found[i] = group.compose(head, group.inverse(measured))
    missing = [pose for pose in range(len(poses), n) if pose not in found]
    if missing:
        raise ValueError(_unreached(missing[0], rows["edges"].tolist()))
    new = [found[pose] for pose in range(len(poses), n)]
    return np.array(new, dtype=np.float64).reshape(-1, *group.POSE_SHAPE)


def _unreached(pose: int, edges: list[list[int]]) -> str:
    """Return the message that nothing leads to ``pose``."""
    named = next((f"edge {k} is {ends}, and " for k, ends in enumerate(edges) if pose in ends), "")
    return (
        f"edges: {named}no odometry leads to pose {pose}; add odometry from the map to it first, "
        "or in the same call"
    )
