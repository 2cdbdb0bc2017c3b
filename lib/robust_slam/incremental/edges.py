"""Edges and poses that arrive: a table for their rows, the checks, and where odometry leads.

Source: derived here.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robust_slam._arrays import Array
from robust_slam.graphs.pose_graph import checked_rows
from robust_slam.groups.group import Group


class Table:
    """Arrays ``(k, …)`` by name, to which rows are appended.

    There is room to spare, so that a row costs the same however many there are. An array that
    was read is read-only and stays as it was.
    """

    def __init__(self, **arrays: NDArray[Any]) -> None:
        self._used = len(next(iter(arrays.values())))
        self._room: dict[str, NDArray[Any]] = {}
        self.put(**arrays)

    def __getitem__(self, name: str) -> NDArray[Any]:
        rows = self._room[name][: self._used]
        rows.flags.writeable = False
        return rows

    def put(self, **arrays: NDArray[Any]) -> None:
        """Put ``arrays`` ``(k, …)`` in the place of those of the same names."""
        self._room |= {name: array.copy() for name, array in arrays.items()}

    def append(self, **rows: NDArray[Any]) -> None:
        """Append ``rows`` ``(l, …)`` to all arrays."""
        needed = self._used + len(next(iter(rows.values())))
        for name, added in rows.items():
            if needed > len(self._room[name]):
                room = np.empty((2 * needed, *added.shape[1:]), self._room[name].dtype)
                room[: self._used] = self[name]
                self._room[name] = room
            self._room[name][self._used : needed] = added
        self._used = needed

    def remove(self, row: int) -> None:
        """Remove a ``row`` of all arrays."""
        self.put(**{name: np.delete(self[name], row, axis=0) for name in self._room})
        self._used -= 1


def checked(
    n: int,
    group: Group,
    edges: ArrayLike,
    measurement: ArrayLike,
    information: ArrayLike,
    is_odometry: ArrayLike | None,
) -> tuple[int, dict[str, NDArray[Any]]]:
    """Return the number of poses when edges join a graph of ``n``, and checked rows ``(k, …)``.

    Raises:
        ValueError: as ``PoseGraph``.
    """
    ends, before = np.asarray(edges), n
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
    found = checked_rows(n, group, rows)
    if is_odometry is None:
        low, high = np.sort(found["edges"], axis=1).T
        found["is_odometry"] = (high == low + 1) & (high >= before)
    return n, found


def placed(group: Group, poses: Array, n: int, rows: dict[str, NDArray[Any]]) -> Array:
    """Return the poses ``(n − k, …)`` that odometry leads to from the ``poses`` ``(k, …)``.

    Raises:
        ValueError: no odometry among ``rows`` leads to one of them.
    """
    first, found = len(poses), dict[int, Array]()
    steps = np.flatnonzero(rows["is_odometry"] & np.any(rows["edges"] >= first, axis=1))
    ends, z, count = rows["edges"][steps].tolist(), rows["measurement"][steps], -1
    while count < len(found) < n - first:
        count = len(found)
        for (i, j), measured in zip(ends, z, strict=True):
            tail, head = (poses[k] if k < first else found.get(k) for k in (i, j))
            if tail is not None and head is None:
                found[j] = group.compose(tail, measured)
            if tail is None and head is not None:
                found[i] = group.compose(head, group.inverse(measured))
    for pose in range(first, n):
        if pose not in found:
            of = enumerate(rows["edges"].tolist())
            named = next((f"edge {k} is {edge}, and " for k, edge in of if pose in edge), "")
            raise ValueError(
                f"edges: {named}no odometry leads to pose {pose}; add odometry from the map to it "
                "first, or in the same call"
            )
    new = [found[pose] for pose in range(first, n)]
    return np.array(new, dtype=np.float64).reshape(-1, *group.POSE_SHAPE)
