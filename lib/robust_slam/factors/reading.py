"""Landmarks, priors and GPS in g2o's text format.

Beside the lines of a pose graph these are read: ``VERTEX_XY id x y`` and ``VERTEX_TRACKXYZ id x y
z``, landmarks; ``EDGE_SE2_XY i l x y`` and ``EDGE_SE3_TRACKXYZ i l p x y z``, points;
``EDGE_PRIOR_SE2 i x y θ`` and ``EDGE_SE3_PRIOR i p x y z qx qy qz qw``, priors;
``EDGE_PRIOR_SE2_XY i x y`` and ``EDGE_SE3_XYZ_PRIOR i p x y z``, positions. The upper triangle of
the information follows, row by row. p names the line ``PARAMS_SE3OFFSET p x y z qx qy qz qw`` of a
sensor, whose pose in the frame of the robot is applied: factors are those of the robot.

Source: Kümmerle et al. 2011, "g2o: a general framework for graph optimization".
"""

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robust_slam._arrays import Array, Indices
from robust_slam.factors.factor_graph import FactorGraph, Factors
from robust_slam.files.doubts import few_digits
from robust_slam.files.g2o import G2O
from robust_slam.files.graph_file import GraphFile, skipped_told
from robust_slam.files.lines import Fault, Rows, Tag, Unknown, lines_of
from robust_slam.files.matrices import information_of, row_by_row
from robust_slam.files.reading import named_file, text_of
from robust_slam.files.tagged import graph_of, poses_of, rows_by_tag
from robust_slam.groups import se3

_SENSOR = "PARAMS_SE3OFFSET"


@dataclass(frozen=True)
class _Layout:
    """The tags of one group: landmarks, points, priors and positions, and ids behind each."""

    landmark: str
    points: str
    priors: str
    positions: str
    sensors: int


_PLANE = _Layout("VERTEX_XY", "EDGE_SE2_XY", "EDGE_PRIOR_SE2", "EDGE_PRIOR_SE2_XY", 0)
_SPACE = _Layout("VERTEX_TRACKXYZ", "EDGE_SE3_TRACKXYZ", "EDGE_SE3_PRIOR", "EDGE_SE3_XYZ_PRIOR", 1)


def _tags(layout: _Layout, d: int, pose: int) -> dict[str, Tag]:
    """Return what stands behind each tag, where a ``pose`` is written as so many numbers."""
    more, dof = layout.sensors, d * (d + 1) // 2
    triangle = {size: size * (size + 1) // 2 for size in (d, dof)}
    return {
        layout.landmark: Tag(1, d),
        layout.points: Tag(2 + more, d + triangle[d]),
        layout.priors: Tag(1 + more, pose + triangle[dof]),
        layout.positions: Tag(1 + more, d + triangle[d]),
    }


_FACTORS = _tags(_PLANE, 2, 3) | _tags(_SPACE, 3, 7)
_TAGS = _FACTORS | {_SENSOR: Tag(1, 7)}


@dataclass(frozen=True, eq=False, repr=False)
class FactorFile:
    """The factor graph of a file, and the map of its vertices.

    ``x`` is the map ``(n + l, …)``, or None if the file does not give the vertices of all poses
    and landmarks. ``ids`` ``(n + l,)`` are those of the file, of poses and then of landmarks.
    ``skipped`` maps each skipped tag to its number of lines, and ``notes`` are sentences about how
    the edges were understood, and ``doubts`` about what was hardly meant, as in ``GraphFile``.
    """

    graph: FactorGraph
    x: Array | None
    ids: Indices
    skipped: dict[str, int]
    notes: tuple[str, ...]
    doubts: tuple[str, ...]

    def summary(self) -> str:
        """Return what is in the file, a line each."""
        rows = [("factors", f"{self.graph!r}"[len("<FactorGraph: ") : -1])]
        said = (*skipped_told(self.skipped), *self.notes, *self.doubts)
        rows += [("note", words) for words in said]
        return "\n".join(f"{name:<10} {words}" for name, words in rows)

    __str__ = summary

    def __repr__(self) -> str:
        return f"<FactorFile: {repr(self.graph)[1:-1]}>"


def has_factors(path: str | os.PathLike[str]) -> bool:
    """Tell whether a file has lines of landmarks, priors or GPS; it may raise an OSError."""
    text = Path(path).read_bytes().decode("utf-8", errors="replace")
    return any(fields[0] in _FACTORS for _, fields in lines_of(text))


def read_factors(path: str | os.PathLike[str], *, unknown: Unknown = "raise") -> FactorFile:
    """Return the factor graph of a g2o file; the module ``factors.reading`` lists its lines.

    Poses, edges and FIX are those of ``rs.read``, and edges between poses have to connect all
    poses. Landmarks follow the poses by ascending id. Lines with an ``unknown`` tag are refused or
    left out ("skip").

    Raises:
        GraphFileError: as ``rs.read``; or a vertex is missing, given twice or in no factor, a
            sensor is missing, a landmark is fixed, a pose is fixed beside priors or positions,
            or an information matrix is not positive definite.
        OSError: the file cannot be read.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "tree.g2o"
    >>> _ = path.write_text("EDGE_SE2 7 9 1 0 0 4 0 0 4 0 9\\nEDGE_SE2_XY 7 8 2 1 25 0 25")
    >>> file = read_factors(path)
    >>> file.graph, file.ids.tolist()
    (<FactorGraph: 2 poses in SE(2), 1 landmark, 1 edge, 1 point>, [7, 9, 8])
    """
    with named_file(path):
        text, commas = text_of(path)
        found = _parsed(text, unknown)
        return replace(found, notes=(*commas, *found.notes))


def _parsed(text: str, unknown: Unknown) -> FactorFile:
    tags = {**_TAGS, **G2O.tags}
    rows, skipped = rows_by_tag(text, tags, G2O, unknown)
    poses = graph_of(text, G2O, "raise", "skip")
    space = poses.graph.group is se3
    layout, other = (_SPACE, _PLANE) if space else (_PLANE, _SPACE)
    for name in (other.landmark, other.points, other.priors, other.positions):
        if len(rows[name]):
            raise Fault(int(rows[name].line[0]), "SE(2) and SE(3) are mixed; use two files")
    _check_fixed(rows, layout, poses)
    landmarks = _landmarks(rows[layout.landmark], rows[layout.points], poses)
    ids = np.concatenate([poses.ids, landmarks])
    own = rows[_SENSOR]
    sensors = dict(zip(own.ids[:, 0].tolist(), poses_of(own), strict=True)) if space else None
    graph = FactorGraph(
        relative=poses.graph,
        landmarks=landmarks.size,
        priors=_priors(rows[layout.priors], poses, sensors),
        positions=_positions(rows[layout.positions], poses, sensors),
        points=_points(rows[layout.points], ids, poses, sensors),
    )
    x = _map(poses, rows[layout.landmark], landmarks)
    doubts = (*poses.doubts, *_few_digits(graph))
    return FactorFile(graph, x, ids, skipped, poses.notes, doubts)


def _few_digits(graph: FactorGraph) -> list[str]:
    """Return a sentence about priors or GPS far from the origin with six digits."""
    said, d = [], graph.group.DIMENSION
    for block in graph.blocks:
        if block.name in ("priors", "positions"):
            z = block.measurement
            place = graph.group.translation(z) if block.name == "priors" else z
            claimed = np.linalg.norm(np.linalg.inv(block.root)[:, :d], axis=2)
            said.append(few_digits(block.name, place, float(np.median(claimed))))
    return [words for words in said if words]


def _check_fixed(rows: Mapping[str, Rows], layout: _Layout, poses: GraphFile) -> None:
    """Refuse FIX lines that a factor graph cannot honour."""
    fix = rows["FIX"]
    foreign = ~np.isin(fix.ids[:, 0], poses.ids)
    fix.refuse(foreign, "a landmark is fixed; give it a position, or drop the line")
    placed = len(rows[layout.priors]) or len(rows[layout.positions])
    fix.refuse(
        foreign | bool(placed),
        "a pose is fixed beside priors or positions, which place the map already; drop the "
        "line, or give the pose a prior",
    )


def _landmarks(vertices: Rows, points: Rows, poses: GraphFile) -> Indices:
    """Return the ids of the landmarks ``(l,)``, ascending."""
    given = vertices.ids[:, 0]
    vertices.refuse(
        np.isin(given, poses.ids), lambda k: f"vertex {given[k]} is a pose as well; renumber it"
    )
    found, first = np.unique(given, return_index=True)
    again = ~np.isin(np.arange(len(vertices)), first)
    vertices.refuse(again, lambda k: f"vertex {given[k]} is given twice; drop one line")
    seen = points.ids[:, 1]
    used = np.setdiff1d(seen, poses.ids)
    if not len(vertices):
        return used
    missing = ~np.isin(seen, given) & ~np.isin(seen, poses.ids)
    points.refuse(missing, lambda k: f"vertex {seen[k]} is missing; add its line")
    idle = ~np.isin(given, used)
    vertices.refuse(idle, lambda k: f"landmark {given[k]} is in no edge; drop the line")
    return found


def _nodes(rows: Rows, column: int, ids: Indices, what: str) -> Indices:
    """Return the nodes ``(k,)`` of the ids in one column of lines."""
    wanted, order = rows.ids[:, column], np.argsort(ids)
    rows.refuse(
        ~np.isin(wanted, ids),
        lambda k: f"there is no {what} {wanted[k]}; add it, or drop the line",
    )
    return order[np.searchsorted(ids, wanted, sorter=order)]


def _offsets(rows: Rows, sensors: Mapping[int, Array]) -> Array:
    """Return the pose ``(k, 3, 4)`` of the sensor of each line in the frame of the robot."""
    wanted = rows.ids[:, -1]
    missing = ~np.isin(wanted, list(sensors))
    rows.refuse(missing, lambda k: f"sensor {wanted[k]} is missing; add its {_SENSOR} line")
    return np.array([sensors[k] for k in wanted.tolist()]).reshape(-1, 3, 4)


def _matrices(rows: Rows, given: int, dof: int) -> Array:
    """Return the information matrices ``(k, dof, dof)`` behind the ``given`` numbers."""
    return information_of(rows, row_by_row(rows.numbers[:, given:], dof)[0], False, "raise")[0]


def _points(
    rows: Rows, ids: Indices, poses: GraphFile, sensors: Mapping[int, Array] | None
) -> Factors | None:
    """Return what is seen, in the frames of the poses; without ``sensors`` these see it."""
    if not len(rows):
        return None
    d = poses.graph.group.DIMENSION
    ends = [_nodes(rows, 0, poses.ids, "pose"), _nodes(rows, 1, ids, "vertex")]
    place, information = rows.numbers[:, :d], _matrices(rows, d, d)
    if sensors is not None:
        turn, shift = np.split(_offsets(rows, sensors), [3], axis=2)
        place = (turn @ place[..., None] + shift)[..., 0]
        information = turn @ information @ np.swapaxes(turn, 1, 2)
    return Factors(np.stack(ends, axis=1), place, information)


def _positions(
    rows: Rows, poses: GraphFile, sensors: Mapping[int, Array] | None
) -> Factors | None:
    if not len(rows):
        return None
    if sensors is not None:
        away = np.any(_offsets(rows, sensors)[:, :, 3] != 0.0, axis=1)
        rows.refuse(away, "the antenna is not at the robot's origin; correct the position")
    d = poses.graph.group.DIMENSION
    own = _nodes(rows, 0, poses.ids, "pose")
    return Factors(own, rows.numbers[:, :d], _matrices(rows, d, d))


def _priors(rows: Rows, poses: GraphFile, sensors: Mapping[int, Array] | None) -> Factors | None:
    if not len(rows):
        return None
    group, own = poses.graph.group, _nodes(rows, 0, poses.ids, "pose")
    if sensors is None:
        return Factors(own, rows.numbers[:, :3], _matrices(rows, 3, 3))
    offset = _offsets(rows, sensors)
    # With z = x ∘ o ∘ Exp(r) the pose has z ∘ o⁻¹ = x ∘ Exp(Ad(o) r).
    back = group.adjoint(group.inverse(offset))
    information = np.swapaxes(back, 1, 2) @ _matrices(rows, 7, 6) @ back
    return Factors(own, group.compose(poses_of(rows), group.inverse(offset)), information)


def _map(poses: GraphFile, vertices: Rows, landmarks: Indices) -> Array | None:
    """Return the map ``(n + l, …)`` of the vertices, if the file gives all of them."""
    if poses.poses is None or len(vertices) < landmarks.size:
        return None
    group = poses.graph.group
    place = vertices.numbers[np.argsort(vertices.ids[:, 0])]
    return np.concatenate([poses.poses, group.from_parts(np.eye(group.DIMENSION), place)])
