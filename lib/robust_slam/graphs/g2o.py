"""Pose graphs in g2o's text format, read and written.

Tags: ``VERTEX_SE2 id x y θ``, ``EDGE_SE2 i j x y θ`` and 6 numbers of information;
``VERTEX_SE3:QUAT id x y z qx qy qz qw``, ``EDGE_SE3:QUAT i j x y z qx qy qz qw`` and 21
numbers; ``FIX id``. Metres and radians. Blank lines and comments, which start with ``#``,
are ignored. A file has vertices for all of its poses or for none of them. A FIX line may
name several ids. Lines ``PARAMS_…`` are skipped: they are calibrations of sensors, to which no
edge between poses refers. Lines with other tags, such as landmarks and TORO's ``VERTEX2`` and
``EDGE2``, are refused or, on demand, skipped.

An edge ``i j`` measures pose j in the frame of pose i, whichever id is larger; it is never
inverted. The information is the upper triangle, row by row, in the order (x, y, θ) or
(translation, rotation). The program g2o itself applies the last three rows in SE(3) to the
vector part of a quaternion, half the rotation vector of a small rotation; like GTSAM, this
library applies the matrix to (translation, rotation vector) unchanged.

A quaternion of any length but 0 represents a rotation. The reader rounds it to a grid of
2⁻⁵⁰ that can be recovered from the rotation matrix, so a graph that was read and written is
read again with the same numbers. Other rotation matrices, for instance products, are
recovered within 3e-15 the first time and exactly from then on.

Source: Kümmerle et al. 2011, "g2o: a general framework for graph optimization", for the
format; the grid of quaternions is derived here.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, Indices, Mask
from robust_slam._files import write_lines
from robust_slam.graphs import se3
from robust_slam.graphs.definite import Repair, definite
from robust_slam.graphs.pose_graph import PoseGraph, check_graph, check_poses, connected_parts

Indefinite: TypeAlias = Literal["raise"] | Repair
Unknown: TypeAlias = Literal["raise", "skip"]

_STEP = 2.0**-50
"""The grid of quaternions: rounding in a rotation matrix stays below half a step."""
_COARSE = 2.0**20
_LARGEST_ID = np.iinfo(np.int64).max
_NAMED = 5
"""The largest number of vertex ids in a message."""


class G2oError(ValueError):
    """A g2o file is invalid; the message is ``file:line: problem; remedy``."""


@dataclass(frozen=True, eq=False)
class G2o:
    """The content of a g2o file.

    ``poses`` are its vertices, ``(n, 3)`` or ``(n, 3, 4)``, in the order of the graph, or
    None if it has none. ``names`` ``(n,)`` are the file's ids of poses 0 to n − 1.
    ``repaired`` ``(k,)`` are the edges whose information matrix was replaced, and
    ``skipped`` maps each skipped tag to its number of lines.
    """

    graph: PoseGraph
    poses: Array | None
    names: Indices
    repaired: Indices = dataclasses.field(default_factory=lambda: np.empty(0, dtype=np.intp))
    skipped: dict[str, int] = dataclasses.field(default_factory=dict)

    @property
    def leaps(self) -> Indices:
        """The odometry, ascending, between ids further apart than neighbouring ids mostly are."""
        usual = np.median(np.diff(np.sort(self.names)))
        apart = np.abs(np.diff(self.names[self.graph.edges], axis=1)[:, 0])
        leaps: Indices = np.flatnonzero(self.graph.is_odometry & (apart > usual))
        return leaps


@dataclass(frozen=True)
class _Layout:
    """The tags of a group, the numbers of a pose, and the size of an information matrix."""

    vertex: str
    edge: str
    pose: int
    dof: int


_PLANE = _Layout("VERTEX_SE2", "EDGE_SE2", 3, 3)
_SPACE = _Layout("VERTEX_SE3:QUAT", "EDGE_SE3:QUAT", 7, 6)
_FIX = "FIX"
_IDS = {_PLANE.vertex: 1, _PLANE.edge: 2, _SPACE.vertex: 1, _SPACE.edge: 2, _FIX: 1}
_PARAMETERS = "PARAMS_"
_TORO = dict.fromkeys(
    ("VERTEX2", "EDGE2"),
    "VERTEX2 becomes VERTEX_SE2, EDGE2 becomes EDGE_SE2, and its information "
    "I11 I12 I22 I33 I13 I23 becomes I11 I12 I13 I22 I23 I33",
) | dict.fromkeys(
    ("VERTEX3", "EDGE3"),
    "VERTEX3 and EDGE3 become VERTEX_SE3:QUAT and EDGE_SE3:QUAT, with quaternions in "
    "place of roll, pitch and yaw",
)
_FIELDS = {_PLANE.vertex: 5, _PLANE.edge: 12, _SPACE.vertex: 9, _SPACE.edge: 31, _FIX: 2}


class _Fault(Exception):
    """Something wrong in a line, before the file's name is known; line 0 is the whole file."""

    def __init__(self, line: int, message: str) -> None:
        super().__init__(f"{line}: {message}" if line else f" {message}")


@dataclass(frozen=True, eq=False)
class _Rows:
    """The lines of one tag: their numbers in the file, ids ``(k, 1|2)``, and the rest."""

    line: Indices
    ids: Indices
    numbers: Array


def read(
    path: str | os.PathLike[str],
    *,
    indefinite: Indefinite = "raise",
    unknown: Unknown = "raise",
) -> G2o:
    """Return the graph of a g2o file, its initial poses and its ids.

    Ids may come in any order and with gaps. Pose 0 of the graph is the vertex that a FIX
    line names, else that of the smallest id; the others follow by ascending id. Edges keep
    the order of the file.

    The format does not say which edges are odometry. Here it is, for each pair of ids that
    are neighbours in ascending order, the first edge from the lower to the higher one, or
    if there is none, the first edge back. To change this, use
    ``dataclasses.replace(graph, is_odometry=…)``.

    ``indefinite`` tells what becomes of information matrices that are not positive definite:
    they are refused ("raise") or replaced as in ``definite``, by the "nearest" one or by an
    "isotropic" one. Lines with an ``unknown`` tag are refused or left out ("skip"), and FIX
    lines of their vertices with them. The result counts both.

    Raises:
        G2oError: a line is malformed, a tag unknown, a number not finite, an id not a
            whole number, a vertex given twice or missing, a quaternion zero, an information
            matrix not positive definite; an edge joins a vertex to itself; SE(2) and SE(3)
            are mixed; several vertices are fixed; there are no edges, or they do not
            connect all vertices; or the file, apart from comments, is not UTF-8.
        ValueError: ``indefinite`` or ``unknown`` is not one of the words above.
        OSError: the file cannot be read.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "two.g2o"
    >>> _ = path.write_text("EDGE_SE2 7 9 1 0 0 4 0 0 4 0 9")
    >>> read(path).graph.n, read(path).names.tolist()
    (2, [7, 9])
    """
    _check_word("indefinite", indefinite, ("raise", *get_args(Repair)))
    _check_word("unknown", unknown, get_args(Unknown))
    content = Path(path).read_bytes()
    try:
        return _parsed(_decoded(content), indefinite, unknown)
    except _Fault as fault:
        raise G2oError(f"{os.fspath(path)}:{fault}") from None


def _check_word(name: str, value: str, words: Sequence[str]) -> None:
    if value not in words:
        raise ValueError(f"{name} is {value!r}; give one of {', '.join(map(repr, words))}")


def _decoded(content: bytes) -> str:
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("utf-8-sig", errors="surrogateescape")
    for line, row in enumerate(text.split("\n"), start=1):
        # Bytes that are not UTF-8 have become surrogates; in a comment they do no harm.
        if not row.partition("#")[0].isascii():
            raise _Fault(line, "the bytes are not UTF-8 text; save the file as plain text")
    return text


def _parsed(text: str, indefinite: Indefinite, unknown: Unknown) -> G2o:
    tagged, skipped = _by_tag(text, unknown)
    foreign = [tag for tag in skipped if tag in _TORO]
    if foreign and not (tagged[_PLANE.edge] or tagged[_SPACE.edge]):
        raise _Fault(0, _malformed([foreign[0]]))
    rows = {tag: _rows(tag, lines) for tag, lines in tagged.items()}
    layout = _layout(rows)
    vertices, edges = rows[layout.vertex], rows[layout.edge]
    ascending = _ascending_ids(vertices, edges)
    fix = rows[_FIX]
    if not all(tag.startswith(_PARAMETERS) for tag in skipped):
        fix = _of_poses(fix, ascending, skipped)
    first = _fixed(fix, ascending)
    information, repaired = _information(edges, layout, indefinite)
    ranks = np.searchsorted(ascending, edges.ids)
    _check_joined(ranks, ascending)
    # Pose 0 is the fixed vertex; the poses before it in ascending order move up by one.
    number = np.arange(ascending.size) + (np.arange(ascending.size) < first)
    number[first] = 0
    order = np.argsort(number)
    graph = PoseGraph(
        n=ascending.size,
        edges=number[ranks],
        measurement=_poses(edges, layout),
        information=information,
        is_odometry=_steps(ranks),
    )
    guess = _guess(vertices, layout, order, graph)
    return G2o(graph, guess, _locked(ascending[order]), _locked(repaired), skipped)


def _by_tag(
    text: str, unknown: Unknown
) -> tuple[dict[str, list[tuple[int, list[str]]]], dict[str, int]]:
    """Return the lines of each tag, as their number and fields, and the skipped tags."""
    found: dict[str, list[tuple[int, list[str]]]] = {tag: [] for tag in _FIELDS}
    skipped: dict[str, int] = {}
    for line, content in enumerate(text.split("\n"), start=1):
        fields = content.partition("#")[0].split()
        if not fields:
            continue
        tag = fields[0]
        if tag.startswith(_PARAMETERS) or (unknown == "skip" and tag not in _FIELDS):
            skipped[tag] = skipped.get(tag, 0) + 1
            continue
        if tag == _FIX and len(fields) > _FIELDS[_FIX]:
            found[_FIX] += [(line, [_FIX, name]) for name in fields[1:]]
            continue
        if _FIELDS.get(fields[0]) != len(fields):
            raise _Fault(line, _malformed(fields))
        found[fields[0]].append((line, fields))
    return found, skipped


def _of_poses(fix: _Rows, ascending: Indices, skipped: dict[str, int]) -> _Rows:
    """Return the FIX lines of poses; those of skipped vertices count as skipped."""
    known = np.isin(fix.ids[:, 0], ascending)
    if not np.all(known):
        skipped[_FIX] = int(np.sum(~known))
    return _Rows(fix.line[known], fix.ids[known], fix.numbers[known])


def _malformed(fields: list[str]) -> str:
    tag = fields[0]
    if tag in _FIELDS:
        return f"{tag} has {len(fields) - 1} fields behind it; give {_FIELDS[tag] - 1}"
    if tag in _TORO:
        return f"the tag {tag!r} is of TORO's format; convert the file: {_TORO[tag]}"
    return (
        f"the tag {tag[:40]!r} is unknown; use {', '.join(_FIELDS)}, or leave such lines out "
        'with unknown="skip"'
    )


def _rows(tag: str, lines: list[tuple[int, list[str]]]) -> _Rows:
    count = _IDS[tag]
    ids, numbers = [], []
    for line, fields in lines:
        ids.append([_whole(line, k, fields[k]) for k in range(1, count + 1)])
        numbers.append([_real(line, k, fields[k]) for k in range(count + 1, len(fields))])
    rows = _Rows(
        np.array([line for line, _ in lines], dtype=np.intp),
        np.array(ids, dtype=np.intp).reshape(len(lines), count),
        np.array(numbers, dtype=np.float64).reshape(len(lines), _FIELDS[tag] - count - 1),
    )
    infinite = ~np.all(np.isfinite(rows.numbers), axis=1)
    if np.any(infinite):
        raise _Fault(_first(rows, infinite), "a number is not finite; remove NaN and infinity")
    return rows


def _whole(line: int, place: int, field: str) -> int:
    """Return an id of digits only: int() would also accept '+1' and '1_0'."""
    digits = field.isascii() and field.isdigit() and len(field.lstrip("0")) < 20
    if not digits or int(field) > _LARGEST_ID:
        raise _misread(line, place, field, "a whole number from 0 to 2^63 - 1")
    return int(field)


def _real(line: int, place: int, field: str) -> float:
    """Return a number: float() would also accept '1_0' and digits of other scripts."""
    try:
        if "_" not in field and field.isascii():
            return float(field)
    except ValueError:
        pass
    raise _misread(line, place, field, "a number")


def _misread(line: int, place: int, field: str, wanted: str) -> _Fault:
    return _Fault(line, f"field {place} is {field[:40]!r}; give {wanted}")


def _first(rows: _Rows, wrong: Mask) -> int:
    """Return the number of the first line of the mask ``wrong``."""
    return int(rows.line[np.argmax(wrong)])


def _layout(rows: dict[str, _Rows]) -> _Layout:
    """Return the layout that every line follows."""
    plane, space = (
        np.concatenate([rows[layout.vertex].line, rows[layout.edge].line])
        for layout in (_PLANE, _SPACE)
    )
    if plane.size and space.size:
        first = max(int(plane.min()), int(space.min()))
        raise _Fault(first, "SE(2) and SE(3) are mixed; put them into files of their own")
    layout = _SPACE if space.size else _PLANE
    if not rows[layout.edge].line.size:
        raise _Fault(0, f"no edge is there; add lines {_PLANE.edge} or {_SPACE.edge}")
    return layout


def _ascending_ids(vertices: _Rows, edges: _Rows) -> Indices:
    """Return the ids in ascending order, after checks of vertices and edges."""
    looped = edges.ids[:, 0] == edges.ids[:, 1]
    if np.any(looped):
        name = edges.ids[np.argmax(looped), 0]
        raise _Fault(_first(edges, looped), f"the edge joins vertex {name} to itself; drop it")
    if not vertices.line.size:
        return np.unique(edges.ids)
    ascending, first = np.unique(vertices.ids[:, 0], return_index=True)
    again = ~np.isin(np.arange(vertices.line.size), first)
    if np.any(again):
        name = vertices.ids[np.argmax(again), 0]
        raise _Fault(_first(vertices, again), f"vertex {name} is given twice; drop one line")
    missing = ~np.isin(edges.ids, ascending)
    if np.any(missing):
        lost = np.any(missing, axis=1)
        raise _Fault(
            _first(edges, lost),
            f"vertex {edges.ids[missing][0]} is missing; add its line or drop the edge",
        )
    return ascending


def _fixed(fix: _Rows, ascending: Indices) -> int:
    """Return the index in ``ascending`` of the vertex that is pose 0."""
    if not fix.line.size:
        return 0
    held = int(fix.ids[0, 0])
    other = fix.ids[:, 0] != held
    if np.any(other):
        raise _Fault(
            _first(fix, other),
            f"vertex {fix.ids[np.argmax(other), 0]} is fixed beside vertex {held}; "
            "the library holds one pose: drop all FIX lines but one",
        )
    place = int(np.searchsorted(ascending, held))
    if place == ascending.size or ascending[place] != held:
        raise _Fault(int(fix.line[0]), f"vertex {held} is missing; fix one that is there")
    return place


def _check_joined(ranks: Indices, ascending: Indices) -> None:
    loose = ascending[connected_parts(ascending.size, ranks) > 0]
    if loose.size:
        named = ", ".join(str(name) for name in loose[:_NAMED])
        rest = f" and {loose.size - _NAMED} more" if loose.size > _NAMED else ""
        raise _Fault(
            0,
            f"no path of edges joins vertex {ascending[0]} to {named}{rest}; "
            "add an edge or drop these vertices",
        )


def _steps(ranks: Indices) -> Mask:
    """Return the mask ``(m,)`` of odometry; the rule is in ``read``."""
    i, j = ranks.T
    near = np.flatnonzero(np.abs(j - i) == 1)
    order = near[np.lexsort((near, j[near] < i[near], ranks[near].min(axis=1)))]
    _, first = np.unique(ranks[order].min(axis=1), return_index=True)
    odometry = np.zeros(i.size, dtype=np.bool_)
    odometry[order[first]] = True
    return odometry


def _poses(rows: _Rows, layout: _Layout) -> Array:
    """Return the poses ``(k, 3)`` or ``(k, 3, 4)`` that the lines give."""
    numbers = rows.numbers[:, : layout.pose]
    if layout is _PLANE:
        return numbers
    quaternion = numbers[:, 3:]
    zero = ~np.any(quaternion, axis=1)
    if np.any(zero):
        raise _Fault(_first(rows, zero), "the quaternion is 0; no turn is (0, 0, 0, 1)")
    return se3.from_parts(_matrices(_on_grid(quaternion)), numbers[:, :3])


def _matrices(quaternion: Array) -> Array:
    # Adding 0 turns −0 into 0, so that equal matrices have equal bits.
    return np.asarray(Rotation.from_quat(quaternion).as_matrix()) + 0.0


def _on_grid(quaternion: Array) -> Array:
    """Return unit quaternions ``(k, 4)`` that can be recovered from their matrices.

    The three smaller components are multiples of ``_STEP`` and determine the largest. The
    rounding error of a matrix changes a component by less than half a step. The largest
    component is chosen from coarsely rounded values, so that rounding does not break ties.
    """
    # Scaling by a power of two is exact; the squares of 1e200 and 1e-200 are out of range.
    _, exponent = np.frexp(np.abs(quaternion).max(axis=1, keepdims=True))
    scaled = np.ldexp(quaternion, -exponent)
    unit = scaled / np.linalg.norm(scaled, axis=1, keepdims=True)
    top = np.argmax(np.round(_COARSE * np.abs(unit)), axis=1)[:, None]
    unit = unit * np.sign(np.take_along_axis(unit, top, axis=1))
    smaller = np.where(np.arange(4) == top, 0.0, _STEP * np.round(unit / _STEP))
    largest = np.sqrt(1.0 - np.sum(smaller**2, axis=1, keepdims=True))
    return np.where(np.arange(4) == top, largest, smaller)


def _information(edges: _Rows, layout: _Layout, indefinite: Indefinite) -> tuple[Array, Indices]:
    """Return the information matrices and the edges whose matrix was replaced."""
    rows, columns = np.triu_indices(layout.dof)
    information = np.empty((edges.line.size, layout.dof, layout.dof))
    information[:, rows, columns] = edges.numbers[:, layout.pose :]
    information[:, columns, rows] = edges.numbers[:, layout.pose :]
    weak = ~(np.linalg.eigvalsh(information)[:, 0] > 0.0)
    if np.any(weak) and indefinite == "raise":
        raise _Fault(
            _first(edges, weak),
            f"the information matrix is not positive definite ({int(weak.sum())} of {weak.size} "
            "are not); give the upper triangle of an inverse covariance, or read with "
            'indefinite="nearest" or "isotropic"',
        )
    if indefinite != "raise":
        information[weak], empty = definite(information[weak], indefinite)
        if np.any(empty):
            raise _Fault(
                _first(edges, np.isin(np.arange(weak.size), np.flatnonzero(weak)[empty])),
                "the information matrix has no positive eigenvalue in position or in rotation; "
                "drop the edge",
            )
    return information, np.flatnonzero(weak)


def _guess(vertices: _Rows, layout: _Layout, order: Indices, graph: PoseGraph) -> Array | None:
    if not vertices.line.size:
        return None
    ascending = np.argsort(vertices.ids[:, 0])
    return check_poses("poses", _poses(vertices, layout)[ascending[order]], graph)


def _locked(names: Indices) -> Indices:
    names.flags.writeable = False
    return names


def write(
    path: str | os.PathLike[str],
    graph: PoseGraph,
    poses: ArrayLike | None = None,
    names: ArrayLike | None = None,
) -> None:
    """Write a graph as a g2o file from which ``read`` returns the same numbers.

    ``poses``, ``(n, 3)`` or ``(n, 3, 4)``, become vertices. ``names`` ``(n,)`` are ids for
    poses 0 to n − 1, by default these numbers themselves. A FIX line is written only if the
    id of pose 0 is not the smallest. The module's docstring gives the accuracy of rotation
    matrices. The format has no field for ``is_odometry``, and only the upper triangle of an
    information matrix is written.

    The write is atomic: a temporary file in the same folder is renamed at the end.

    Raises:
        TypeError: ``graph`` is not a pose graph.
        ValueError: ``poses`` do not fit the graph; ``names`` have the wrong length, repeat,
            are negative or not whole numbers, or do not ascend from the second one on.
        OSError: the file cannot be written.
    """
    layout = _PLANE if check_graph(graph).group.DIMENSION == 2 else _SPACE
    given = None if poses is None else check_poses("poses", poses, graph)
    ids = np.arange(graph.n) if names is None else _names(names, graph.n)
    write_lines(path, _lines(graph, given, ids, layout))


def _names(value: ArrayLike, n: int) -> Indices:
    names = np.asarray(value)
    if names.shape != (n,):
        raise ValueError(f"names: the shape is {names.shape}; give ({n},)")
    if not np.issubdtype(names.dtype, np.integer):
        raise ValueError(f"names: the entries are {names.dtype}; give whole numbers")
    if names.min() < 0 or names.max() > _LARGEST_ID:
        raise ValueError("names: an id is out of range; give 0 to 2^63 - 1")
    if np.any(names[2:] <= names[1:-1]) or np.any(names[1:] == names[0]):
        raise ValueError(
            "names: ids must differ, and ascend from entry 1 on, as they do when they are read"
        )
    return names.astype(np.intp)


def _lines(
    graph: PoseGraph, poses: Array | None, names: Indices, layout: _Layout
) -> Iterator[str]:
    if poses is not None:
        yield from _tagged(layout.vertex, names[:, None], _numbers(poses, layout))
    if names[0] > names[1]:
        yield f"{_FIX} {names[0]}\n"
    triangle = graph.information[:, *np.triu_indices(layout.dof)]
    numbers = np.concatenate([_numbers(graph.measurement, layout), triangle], axis=1)
    yield from _tagged(layout.edge, names[graph.edges], numbers)


def _numbers(poses: Array, layout: _Layout) -> Array:
    """Return the numbers ``(k, 3)`` or ``(k, 7)`` of poses in the format."""
    if layout is _PLANE:
        return poses
    quaternion = np.asarray(Rotation.from_matrix(se3.rotation(poses)).as_quat())
    return np.concatenate([se3.translation(poses), _on_grid(quaternion)], axis=1)


def _tagged(tag: str, ids: Indices, numbers: Array) -> Iterator[str]:
    for names, values in zip(ids.tolist(), numbers.tolist(), strict=True):
        yield f"{tag} {_joined(names)} {_joined(values)}\n"


def _joined(values: Sequence[int] | Sequence[float]) -> str:
    return " ".join(map(repr, values))
