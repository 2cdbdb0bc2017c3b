"""A pose graph from lines with tags; what a format's tags and numbers mean is an argument.

The formats g2o, TORO and PyFactorGraph write the same things: vertices with their poses, and
edges with a relative pose and half of a symmetric matrix. A ``Format`` says how each of them
writes it, and everything that a graph needs is checked here, once.

Source: Kümmerle et al. 2011, for what such a file holds.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from robust_slam._arrays import Array, Ids, Indices
from robust_slam._words import so_do
from robust_slam.files import lines
from robust_slam.files.doubts import doubted
from robust_slam.files.graph_file import GraphFile, Names
from robust_slam.files.lines import Fault, ReadId, Rows, Tag, Unknown
from robust_slam.files.matrices import Indefinite, information_of, row_by_row, uneven
from robust_slam.graphs.pose_graph import PoseGraph, connected_parts, steps_of
from robust_slam.groups import se3
from robust_slam.groups.group import group_of, upward
from robust_slam.groups.rotations import from_quaternions, on_grid

Matrices: TypeAlias = Callable[[Array, int], tuple[Array, tuple[str, ...]]]
"""Return the symmetric matrices ``(k, D, D)`` of their halves, and sentences about them."""


@dataclass(frozen=True, eq=False)
class Layout:
    """How a format writes one group: its tags, the numbers of a pose, the size of a matrix.

    ``poses`` returns the poses ``(k, 3)`` or ``(k, 3, 4)`` of rows, whose first ``pose``
    numbers they are, and ``matrices`` the matrices of the numbers behind these: information
    or, where ``covariance`` says so, its inverse. The numbers at ``angles`` are angles (rad).
    Lines ``as_edge`` are edges too, with one more number, of no use here, behind the ids.
    """

    vertex: str
    edge: str
    pose: int
    dof: int
    poses: Callable[[Rows], Array] = lambda rows: rows.numbers[:, :3]
    matrices: Matrices = row_by_row
    covariance: bool = False
    angles: tuple[int, ...] = ()
    as_edge: tuple[str, ...] = ()

    def edges(self, stamps: int) -> dict[str, Tag]:
        """Return what stands behind the tags of edges; a triangle that is missing can be taken."""
        sizes = ("0.01", "0.0025") if self.covariance else ("100", "400")
        places = zip(*np.triu_indices(self.dof), strict=True)
        half = tuple("0" if i < j else sizes[int(2 * i // self.dof)] for i, j in places)
        numbers = self.pose + len(half)
        more = {tag: Tag(2, numbers, stamps, unused=1, half=half) for tag in self.as_edge}
        return {self.edge: Tag(2, numbers, stamps, half=half), **more}


@dataclass(frozen=True, eq=False)
class Format:
    """A format of tagged lines: the ``plane``, the ``space``, and what else has a meaning.

    ``stamps`` is the number of time stamps ahead of the ids, ``fix`` the tag of the lines that
    name pose 0. Tags that begin with one of the words ``passed`` hold no measurement, and
    ``elsewhere`` says where unknown ones may be read.
    ``read_id`` makes a whole number of an id, ``names`` the ids again, and ``robots`` tells
    whose they are: odometry joins poses of one robot.
    """

    plane: Layout
    space: Layout
    stamps: int = 0
    fix: str | None = None
    passed: tuple[str, ...] = ()
    elsewhere: str = ""
    read_id: ReadId = lines.whole
    ids_are: str = "a whole number from 0 to 2^63 - 1"
    names: Callable[[Ids], Names] = field(default=lambda ids: ids)
    robots: Callable[[Ids], Ids] = field(default=np.zeros_like)

    @cached_property
    def tags(self) -> Mapping[str, Tag]:
        """What stands behind each tag that has a meaning."""
        found = {}
        for layout in (self.plane, self.space):
            found[layout.vertex] = Tag(1, layout.pose, self.stamps)
            found |= layout.edges(self.stamps)
        return found if self.fix is None else found | {self.fix: Tag(1, 0, many=True)}


@dataclass(frozen=True, eq=False)
class Edges:
    """Relative poses as a file gives them: their ids in ``rows``, and arrays as of a graph.

    ``repaired``, ``skipped`` and ``notes`` are those of ``GraphFile``.
    """

    rows: Rows
    measurement: Array
    information: Array
    repaired: Indices
    skipped: dict[str, int]
    notes: tuple[str, ...]


def poses_of(rows: Rows) -> Array:
    """Return the poses ``(k, 3, 4)`` of lines that begin with x y z qx qy qz qw, or a Fault."""
    turns = rows.numbers[:, 3:7]
    rows.refuse(~np.any(turns, axis=1), "the quaternion is 0; no turn is (0, 0, 0, 1)")
    return se3.from_parts(from_quaternions(on_grid(turns)), rows.numbers[:, :3])


def graph_of(text: str, form: Format, indefinite: Indefinite, unknown: Unknown) -> GraphFile:
    """Return the graph of a text in one of the formats by the rules of ``read``, or a Fault."""
    rows, skipped, layout = _rows(text, form, unknown)
    vertices, edges = rows[layout.vertex], rows[layout.edge]
    ascending = _ascending_ids(vertices, edges, form)
    first = 0 if form.fix is None else _fixed(rows[form.fix], ascending, skipped, form)
    ranks = np.searchsorted(ascending, edges.ids)
    _check_joined(ranks, ascending, form)
    found = _edges(edges, layout, form, indefinite, skipped)
    # Pose 0 is the fixed vertex; the poses before it in ascending order move up by one.
    number = np.arange(ascending.size) + (np.arange(ascending.size) < first)
    number[first] = 0
    order = np.argsort(number)
    steps = steps_of(ranks, found.measurement, form.robots(ascending))
    graph = PoseGraph(order.size, number[ranks], found.measurement, found.information, steps)
    ids = ascending[order]
    ids.flags.writeable = False
    poses, turns = _guess(vertices, layout, order), np.abs(edges.numbers[:, list(layout.angles)])
    file = GraphFile(graph, poses, ids, form.names(ids), found.repaired, skipped, found.notes)
    return doubted(replace(file, lines=edges.line, turns=turns))


def edges_alone(text: str, form: Format, indefinite: Indefinite, unknown: Unknown) -> Edges:
    """Return the edges of a text that need not be a whole graph, or raise a Fault."""
    rows, skipped, layout = _rows(text, form, unknown)
    return _edges(rows[layout.edge], layout, form, indefinite, skipped)


def _edges(
    rows: Rows, layout: Layout, form: Format, indefinite: Indefinite, skipped: dict[str, int]
) -> Edges:
    lines.check_near(rows, rows.numbers[:, :3])
    given, notes = layout.matrices(rows.numbers[:, layout.pose :], layout.dof)
    information, repaired = information_of(rows, given, layout.covariance, indefinite)
    measurement = layout.poses(rows)
    copies = _repeated(rows, measurement, layout.pose, form)
    notes = (*notes, *copies, *uneven(rows, information, form.names))
    return Edges(rows, measurement, information, repaired, skipped, notes)


def _repeated(rows: Rows, measurement: Array, pose: int, form: Format) -> tuple[str, ...]:
    """Return a sentence about copies of lines, also of the inverse, or with fewer digits."""
    group, ahead = group_of(measurement), upward(rows.ids, measurement)
    pairs = np.sort(rows.ids, axis=1)
    place = group.translation(ahead)
    order = np.lexsort((place[:, 0], *pairs.T))
    one, other = order[:-1], order[1:]
    same = np.all(pairs[one] == pairs[other], axis=1)
    one, other = one[same], other[same]
    off = np.abs(group.log(group.between(ahead[one], ahead[other]))).max(axis=1, initial=0.0)
    size = 2.0 + np.abs(place[one]).max(axis=1, initial=0.0)
    unit = _printed(rows.numbers[:, :pose])
    near = off <= size * np.maximum(unit[one], unit[other])
    again = np.unique(np.maximum(one, other)[near])
    if not again.size:
        return ()
    i, j = form.names(rows.ids[again[0]])
    return (
        f"line {rows.line[again[0]]} gives edge {i}-{j} once more with the same numbers, or "
        f"those of its inverse{so_do(again.size - 1)}; drop copies",
    )


def _printed(numbers: Array) -> Array:
    """Return the last place ``(k,)`` to which numbers ``(k, p)`` are printed, or nearly 0.

    To so few places two different measurements may agree.
    """
    unit = np.full(len(numbers), 1e-12)
    for place in 10.0 ** np.arange(-11, -1):
        whole = np.all(np.abs(np.round(numbers / place) - numbers / place) < 1e-4, axis=1)
        unit[whole] = place if place < 0.005 else 1e-12
    return unit


def rows_by_tag(
    text: str, tags: Mapping[str, Tag], form: Format, unknown: Unknown, elsewhere: str = ""
) -> tuple[dict[str, Rows], dict[str, int]]:
    """Return the rows of each of the ``tags``; arguments and faults are those of ``by_tag``."""
    tagged, skipped = lines.by_tag(text, tags, form.passed, unknown, elsewhere)
    return {
        name: lines.rows_of(found, tags[name], form.read_id, form.ids_are)
        for name, found in tagged.items()
    }, skipped


def _rows(
    text: str, form: Format, unknown: Unknown
) -> tuple[dict[str, Rows], dict[str, int], Layout]:
    """Return the rows of each tag, the skipped tags, and the layout that every line follows."""
    rows, skipped = rows_by_tag(text, form.tags, form, unknown, form.elsewhere)
    first = {}
    for layout in (form.plane, form.space):
        rows[layout.edge] = _joined([rows[tag] for tag in (layout.edge, *layout.as_edge)])
        if places := [*rows[layout.vertex].line[:1], *rows[layout.edge].line[:1]]:
            first[layout] = int(min(places))
    if len(first) == 2:
        raise Fault(
            max(first.values()), "SE(2) and SE(3) are mixed; put them into files of their own"
        )
    layout = next(iter(first), form.plane)
    if not len(rows[layout.edge]):
        raise Fault(0, f"no edge is there; add lines {form.plane.edge} or {form.space.edge}")
    i, j = rows[layout.edge].ids.T
    rows[layout.edge].refuse(
        i == j, lambda k: f"the edge joins vertex {form.names(i[k : k + 1])[0]} to itself; drop it"
    )
    return rows, skipped, layout


def _joined(parts: Sequence[Rows]) -> Rows:
    """Return the rows of several tags in the order of the file."""
    order = np.argsort(np.concatenate([rows.line for rows in parts]))
    columns = ([getattr(rows, name) for rows in parts] for name in ("line", "ids", "numbers"))
    return Rows(*(np.concatenate(column)[order] for column in columns))


def _ascending_ids(vertices: Rows, edges: Rows, form: Format) -> Indices:
    """Return the ids in ascending order, after checks of the vertices."""
    if not len(vertices):
        return np.unique(edges.ids)
    ascending, first = np.unique(vertices.ids[:, 0], return_index=True)
    again, names = ~np.isin(np.arange(len(vertices)), first), form.names(vertices.ids[:, 0])
    words = "drop one line or, if two robots have the same ids, add an offset to those of one"
    vertices.refuse(again, lambda k: f"vertex {names[k]} is given twice; {words}")
    missing = ~np.isin(edges.ids, ascending)
    lost, wrong = form.names(edges.ids[missing]), np.any(missing, axis=1)
    edges.refuse(wrong, lambda _: f"vertex {lost[0]} is missing; add its line or drop the edge")
    return ascending


def _fixed(fix: Rows, ascending: Indices, skipped: dict[str, int], form: Format) -> int:
    """Return the index in ``ascending`` of the vertex that is pose 0.

    FIX lines of vertices that were skipped count as skipped.
    """
    known = np.isin(fix.ids[:, 0], ascending)
    if form.fix and not np.all(known | all(tag.startswith(form.passed) for tag in skipped)):
        skipped[form.fix] = int(np.sum(~known))
        fix = Rows(fix.line[known], fix.ids[known], fix.numbers[known])
    if not len(fix):
        return 0
    held, words = fix.ids[:, 0], "the library holds one pose: drop all FIX lines but one"
    others = held != held[0]
    fix.refuse(others, lambda k: f"vertex {held[k]} is fixed beside vertex {held[0]}; {words}")
    fix.refuse(~np.isin(held, ascending), f"vertex {held[0]} is missing; fix one that is there")
    return int(np.searchsorted(ascending, held[0]))


def _check_joined(ranks: Indices, ascending: Indices, form: Format) -> None:
    loose = ascending[connected_parts(ascending.size, ranks) > 0]
    if loose.size:
        first, *named = form.names(np.append(ascending[:1], loose[:5]))
        rest = f" and {loose.size - 5} more" if loose.size > 5 else ""
        words = f"{', '.join(map(str, named))}{rest}; add an edge or drop these vertices"
        raise Fault(0, f"no path of edges joins vertex {first} to {words}")


def _guess(vertices: Rows, layout: Layout, order: Indices) -> Array | None:
    if not len(vertices):
        return None
    lines.check_near(vertices, vertices.numbers[:, :3])
    ascending = np.argsort(vertices.ids[:, 0])
    poses = layout.poses(vertices)[ascending[order]]
    poses.flags.writeable = False
    return poses
