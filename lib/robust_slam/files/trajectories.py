"""Poses as text files, one line a pose: TUM's and KITTI's formats, and tables of EuRoC's kind.

TUM: ``time x y z qx qy qz qw``. KITTI: the twelve entries of [R | t], row by row. Metres and
seconds. The id of a pose is the number of its line, from 0; blank lines and comments do not
count. Poses in the plane are written with z = 0.

Fields may be separated by spaces, commas or semicolons, and numbers have decimal commas beside
semicolons. A line of names ahead of the numbers, a comment or not, tells where time, position
and quaternion stand. Without one, whole nanoseconds and commas are EuRoC's format, whose
quaternion begins with w: ``time x y z qw qx qy qz``. Times since 1970 may also be in
milliseconds, microseconds or nanoseconds.

Source: Sturm et al. 2012, TUM's format; Geiger et al. 2012, KITTI's; Burri et al. 2016, EuRoC's.
"""

import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, Mask, finite, positive
from robust_slam.files.doubts import ROUNDED, doubted, rolled
from robust_slam.files.graph_file import GraphFile
from robust_slam.files.lines import Fault, Line, Tag, check_near, real, rows_of, write_lines
from robust_slam.files.tagged import Edges, poses_of
from robust_slam.graphs.pose_graph import PoseGraph, with_closures
from robust_slam.groups import se2, se3
from robust_slam.groups.group import group_of
from robust_slam.groups.rotations import nearest_rotations

_NAMES = "time", "x", "y", "z", "qx", "qy", "qz", "qw"
_TUM, _KITTI = tuple(range(8)), tuple(range(12))
_EUROC = (0, 1, 2, 3, 5, 6, 7, 4)
_UNITS = {1e9: "nanoseconds", 1e6: "microseconds", 1e3: "milliseconds"}
"""How many of a unit are a second."""
_EPOCH = 9e8, 2.5e9
"""Since 1970 (s): a time between these in another unit is read in it."""


@dataclass(frozen=True, eq=False)
class Drive:
    """The ``poses`` ``(n, 3, 4)`` of a trajectory, and their ``times`` ``(n,)`` (s) if any.

    ``notes`` say how it was read, and ``w_first`` that its quaternions begin with w.
    """

    poses: Array
    times: Array | None
    notes: tuple[str, ...] = ()
    w_first: bool = False


def drive_of(text: str) -> Drive:
    """Return the trajectory of a text.

    Raises:
        Fault: a line has other than 8 or 12 numbers, unless names tell what they are, or another
            count than the first line; a number, time or rotation is wrong; or a pose is alone.
    """
    lines, names = _table(text)
    (first, fields), count = lines[0], len(lines[0][1])
    if real(fields[-1]) is None and count > 8:
        raise Fault(
            first,
            f"{fields[-1]!r} is no number; images of COLMAP tell where the world is from the "
            "camera, so invert them, order them by time, and write TUM's lines",
        )
    for line, each in lines:
        if len(each) != count:
            raise Fault(line, f"the line has {len(each)} numbers, the first one {count}")
    columns = _named(names, count) or _usual(first, fields, "," in text.split("\n")[first - 1])
    if len(lines) < 2:
        raise Fault(0, "one pose is no trajectory; give at least two")
    # The rows of tagged lines begin with a tag.
    rows = rows_of(((n, ["", *each]) for n, each in lines), Tag(0, count), int, "")
    if columns == _KITTI:
        given = rows.numbers.reshape(-1, 3, 4)
        check_near(rows, given[:, :, 3])
        rotation = nearest_rotations(given[:, :, :3])
        off = np.abs(rotation - given[:, :, :3]).max(axis=(1, 2)) > ROUNDED
        rows.refuse(off, "the left part of [R | t] is not a rotation; give orthonormal columns")
        return Drive(se3.from_parts(rotation, given[:, :, 3]), None)
    times = rows.numbers[:, columns[0]]
    back = np.diff(times, prepend=-np.inf) <= 0.0
    rows.refuse(back, "the time does not ascend; sort the lines and drop copies")
    poses = replace(rows, numbers=rows.numbers[:, columns[1:]])
    check_near(poses, poses.numbers[:, :3])
    told, unit = " ".join(_NAMES[k] for k in np.argsort(columns)), _unit(times[0])
    note = f"a line is read as {told}{f', with the time in {_UNITS[unit]}' if unit > 1 else ''}"
    notes = (note,) if columns != _TUM or unit > 1 else ()
    return Drive(poses_of(poses), times / unit, notes, columns[7] < columns[4])


def _table(text: str) -> tuple[list[Line], str]:
    """Return the lines from the first number on, and the names above them, if there are any."""
    names, lines = "", list[Line]()
    for number, content in enumerate(text.split("\n"), start=1):
        data, _, comment = content.partition("#")
        fields = fields_of(data)
        if fields and (lines or real(fields[0]) is not None):
            lines.append((number, fields))
        elif not lines:
            names = data.strip() or comment.strip() or names
    return lines, names


def fields_of(data: str) -> list[str]:
    """Return the fields of a line, whatever separates them."""
    data = data.strip()
    for mark in ";,":
        if mark in data:
            return [field.strip().replace(",", ".") for field in data.rstrip(mark).split(mark)]
    return data.split()


def _named(names: str, count: int) -> tuple[int, ...] | None:
    """Return the columns of time, x y z and qx qy qz qw by the names above, if these tell."""
    bare = re.sub(r"\[.*?\]|\(.*?\)", "", names.lower()).strip(" ,;")
    marks = "[,;]" if re.search("[,;]", bare) else r"\s+"
    words = [re.sub("[^a-z]", "", word) for word in re.split(marks, bare)]
    turns = _together(words, "wxyz")
    if len(words) != count or not turns:
        return None
    if not set(turns[0]) & set(turns[-1]):
        raise Fault(0, "the names above tell of two poses in a line; leave the columns of one")
    places = [each for each in _together(words, "xyz") if not set(each) & set(turns[-1])]
    times = [k for k, word in enumerate(words) if word == "t" or re.search("time|stamp", word)]
    if not places or not times:
        return None
    w, *turn = turns[-1]
    return (times[0], *places[0], *turn, w)


def _together(words: Sequence[str], axes: str) -> list[list[int]]:
    """Return the columns side by side whose names differ in their last letters, the ``axes``."""
    found = []
    for k in range(len(words) - len(axes) + 1):
        part = words[k : k + len(axes)]
        ends = "".join(word[-1:] for word in part)
        if sorted(ends) == list(axes) and len({word[:-1] for word in part}) == 1:
            found.append([k + ends.index(axis) for axis in axes])
    return found


def _usual(line: int, fields: Sequence[str], commas: bool) -> tuple[int, ...]:
    """Return the columns of a format that has no names; ``commas`` separate its numbers."""
    count = len(fields)
    if commas and count >= 8 and _unit(float(fields[0])) == 1e9:
        return _EUROC
    if count in (8, 12):
        return _TUM if count == 8 else _KITTI
    raise Fault(
        line,
        f"{count} numbers are no pose of a trajectory; give 8, as TUM does (time x y z qx qy qz "
        "qw), or 12, as KITTI does ([R | t] row by row, without a last row 0 0 0 1), or name the "
        "columns in a line above; roll, pitch and yaw have to become a quaternion"
        + "; decimal commas need semicolons between the numbers"
        * (commas and count > 12),
    )


def _unit(time: float) -> float:
    return next((u for u in _UNITS if _EPOCH[0] < time / u < _EPOCH[1]), 1.0)


def check_ends(closures: Edges, n: int) -> None:
    """Refuse, by a Fault, ``closures`` of poses that a trajectory of ``n`` does not have."""
    last = closures.rows.ids.max(axis=1)
    closures.rows.refuse(
        last >= n,
        lambda k: f"pose {last[k]} is missing: the trajectory has 0 to {n - 1}; drop the edge",
    )


def graph_of(drive: Drive, odometry: tuple[float, float], closures: Edges | None) -> GraphFile:
    """Return the graph of a drive: a step between consecutive poses, and closures.

    ``odometry`` are the standard deviations (m, rad) of each coordinate of a step. The graph is
    in SE(2) if the closures are; then the drive has to stay within 1 mm and 1 mrad of its plane.
    """
    position, angle = (positive("odometry", value) for value in odometry)
    poses = drive.poses
    if closures is not None and closures.measurement.ndim == 2:
        poses = _in_plane(poses)
    group, first = group_of(poses), np.arange(len(poses) - 1)
    sigma = np.repeat([position, angle], [group.DIMENSION, group.DOF - group.DIMENSION])
    steps, ends = group.between(poses[:-1], poses[1:]), np.stack([first, first + 1], axis=1)
    graph = PoseGraph(len(poses), ends, steps, np.diag(sigma**-2.0))
    notes, repaired, skipped = drive.notes, np.empty(0, dtype=np.intp), {}
    if closures is not None:
        graph = with_closures(graph, closures.rows.ids, closures.measurement, closures.information)
        repaired, skipped = closures.repaired + len(first), closures.skipped
        notes = (*notes, *closures.notes, *_steps_again(closures))
    ids = np.arange(graph.n, dtype=np.int64)
    file = GraphFile(graph, poses, ids, ids, repaired, skipped, notes, drive.times)
    return doubted(replace(file, w_first=drive.w_first))


def other_orders(file: GraphFile) -> dict[str, PoseGraph]:
    """Return graphs of a trajectory with w at the other end of its quaternions, by their words."""
    graph, poses = file.graph, file.poses
    if file.times is None or poses is None or poses.ndim == 2:
        return {}
    by, words = (1, "end") if file.w_first else (-1, "begin")
    i, j = graph.edges.T
    turned, steps = rolled(poses, by), graph.is_odometry[:, None, None]
    ahead = graph.group.between(turned[i], turned[j])
    closures = {"": graph.measurement, " and the closures": rolled(graph.measurement, -1)}
    return {
        f"with quaternions of the trajectory{more} that {words} with w": replace(
            graph, measurement=np.where(steps, ahead, z)
        )
        for more, z in closures.items()
    }


def _steps_again(closures: Edges) -> tuple[str, ...]:
    """Return a sentence about closures between consecutive poses, if there are any."""
    near = closures.rows.line[np.abs(np.diff(closures.rows.ids, axis=1)[:, 0]) == 1]
    words = "as the odometry does; drop those that are its steps"
    many = f"{near.size:,} of the closures join consecutive poses"
    return tuple(f"{many} (first line {line}), {words}" for line in near[:1])


def _in_plane(poses: Array) -> Array:
    """Return the poses ``(n, 3)`` of a drive that stays in the plane z = constant."""
    out = _out_of_plane(poses)
    if np.any(out):
        remedy = "give closures in space, EDGE_SE3:QUAT"
        if not np.any(_out_of_plane(rolled(poses, -1))):
            remedy = "if its quaternions begin with w, write qx qy qz qw"
        raise ValueError(
            f"closures: they are in the plane, and pose {int(np.argmax(out))} of the trajectory "
            f"is not; {remedy}"
        )
    heading = np.arctan2(poses[:, 1, 0], poses[:, 0, 0])
    return np.column_stack([poses[:, :2, 3], heading])


def _out_of_plane(poses: Array) -> Mask:
    off = np.column_stack([poses[:, 2, 3] - poses[0, 2, 3], poses[:, 2, :2]])
    return np.asarray(np.any(np.abs(off) > ROUNDED, axis=1))


def write_tum(
    path: str | os.PathLike[str], poses: ArrayLike, times: ArrayLike | None = None
) -> None:
    """Write poses ``(n, 3)`` or ``(n, 3, 4)`` in TUM's format, as the tool evo reads it.

    Their ``times`` ``(n,)`` (s) are by default 0, 1, 2, …. It is written at once or not at all.

    Raises:
        TypeError: ``poses`` are not numbers, for instance a graph.
        ValueError: the shape does not fit, or an entry is not finite.
        OSError: the file cannot be written.
    """
    matrices = _in_space(poses)
    given = np.arange(len(matrices)) if times is None else times
    stamps = finite("times", given, (len(matrices),))
    # A copy, since SciPy 1.14 takes no array that is only to be read.
    turns = np.asarray(Rotation.from_matrix(matrices[:, :, :3].copy()).as_quat(canonical=True))
    write_lines(path, _rows(np.column_stack([stamps, matrices[:, :, 3], turns])))


def write_kitti(path: str | os.PathLike[str], poses: ArrayLike) -> None:
    """Write poses ``(n, 3)`` or ``(n, 3, 4)`` in KITTI's format; errors as of ``write_tum``."""
    write_lines(path, _rows(_in_space(poses).reshape(-1, 12)))


def _in_space(poses: ArrayLike) -> Array:
    """Return poses as ``(n, 3, 4)``; those in the plane turn about z."""
    if np.ndim(poses) == 3:
        return finite("poses", poses, (-1, 3, 4))
    plane = finite("poses", poses, (-1, 3))
    matrices = np.tile(se3.identity(), (len(plane), 1, 1))
    matrices[:, :2, :2], matrices[:, :2, 3] = se2.rotation(plane), plane[:, :2]
    return matrices


def _rows(numbers: Array) -> Iterator[str]:
    for row in numbers.tolist():
        yield " ".join(map(repr, row)) + "\n"
