"""A file of a pose graph in any format that the library knows, told by its content.

A public graph is found by its name.
"""

import logging
import os
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import get_args

from robust_slam._arrays import Array
from robust_slam.files import datasets, trajectories
from robust_slam.files.formats import PYFG, TORO, read_id
from robust_slam.files.g2o import G2O
from robust_slam.files.graph_file import GraphFile, GraphFileError
from robust_slam.files.lines import Fault, Unknown, decoded, lines_of, real, with_points
from robust_slam.files.matrices import Indefinite, Repair
from robust_slam.files.tagged import Edges, Format, edges_alone, graph_of
from robust_slam.graphs.pose_graph import PoseGraph

_PLAYED = (
    "it holds what sensors said, and no pose graph: let a SLAM system play it and export its "
    "graph as g2o, or take its odometry with `evo_traj {} TOPIC --save_as_tum` and give closures "
    "beside it"
)
_ROS_2 = _PLAYED.format("bag2 FOLDER")
_MAGIC = {
    b"#ROSBAG V": ("a ROS 1 bag", _PLAYED.format("bag FILE")),
    b"SQLite format 3\0": ("an SQLite database, such as a ROS 2 bag", _ROS_2),
    b"\x89MCAP0\r\n": ("an MCAP log, such as a ROS 2 bag", _ROS_2),
    b"\x1f\x8b": ("packed with gzip", "unpack it first"),
    b"PK\x03\x04": ("a zip file", "unpack it first"),
    b"BZh": ("packed with bzip2", "unpack it first"),
    b"\xfd7zXZ\0": ("packed with xz", "unpack it first"),
    b"\xdb\x01\xf5\x5b\x7b\x1f\x1d\x7b": (
        "a .pbstream of Cartographer",
        "write its nodes and constraints as lines of g2o",
    ),
    b"{": ("JSON, such as nerfstudio's transforms.json", "write its poses as lines of TUM"),
    b"\x93NUMPY": ("an array of NumPy", "make a graph of it by rs.PoseGraph"),
    b"\x89HDF": ("an HDF5 file", "make a graph of its arrays by rs.PoseGraph"),
    b"ply": ("a cloud of points", "it has no poses"),
}
"""The first bytes of files that people have in place of a pose graph: what it is, and a remedy."""
_LOG = logging.getLogger(__name__)
_AHEAD = 20
"""The largest number of lines, such as names of columns, ahead of a trajectory."""
_ALONE = "it is for a trajectory, and the file is a graph with edges of its own; leave it out"
_MATRICES = ("raise", *get_args(Repair))
_UNTOLD = (
    "a trajectory does not tell how exact it is; give the standard deviations of a step, such as "
    "odometry=(0.05, 0.01) in m and rad"
)


def load(
    source: str | os.PathLike[str],
    *,
    indefinite: Indefinite = "raise",
    unknown: Unknown = "raise",
    odometry: tuple[float, float] | None = None,
    closures: str | os.PathLike[str] | None = None,
) -> PoseGraph:
    """Return the graph of a file in any format that ``read`` knows, or a public graph.

    ``source`` is a path, or one of ``files.datasets.NAMES`` where no such file exists. The other
    arguments are those of ``read``, which also returns the file's poses and ids. What was
    replaced, skipped, assumed or looks wrong is logged as a warning.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing, DatasetChanged: the public graph is not on this machine, or another one.
        GraphFileError, ValueError, OSError: as ``read``.
    """
    path = find(source)
    content = read(
        path, indefinite=indefinite, unknown=unknown, odometry=odometry, closures=closures
    )
    for words in content.remarks():
        _LOG.warning("%s: %s", path, words)
    return content.graph


def find(source: str | os.PathLike[str]) -> Path:
    """Return the path of a file, or of a public graph by its name.

    Raises:
        FileNotFoundError, DatasetMissing, DatasetChanged: as ``load``.
    """
    path, name = Path(source), os.fspath(source)
    if path.exists():
        return path
    try:
        return datasets.find(name)
    except (datasets.DatasetMissing, datasets.DatasetChanged):
        raise
    except ValueError as error:
        raise FileNotFoundError(
            f"{name}: there is no such file, nor a public graph of that name; give the path of "
            f"a file or one of {', '.join(datasets.NAMES)}"
        ) from error


def read(
    path: str | os.PathLike[str],
    *,
    indefinite: Indefinite = "raise",
    unknown: Unknown = "raise",
    odometry: tuple[float, float] | None = None,
    closures: str | os.PathLike[str] | None = None,
) -> GraphFile:
    """Return the graph of a file, its initial poses and its ids.

    The format is told by the content: g2o, TORO, PyFactorGraph, or a trajectory of TUM, KITTI or
    EuRoC. The modules ``g2o``, ``formats`` and ``trajectories`` say how each is understood.

    Ids may come in any order and with gaps. Pose 0 of the graph is the vertex that a FIX line
    names, else that of the smallest id; the others follow by ascending id. Edges keep their order.

    These formats do not say which edges are odometry: one from each pose to the next is, by
    ascending id. To change this, use ``dataclasses.replace(graph, is_odometry=…)``.

    A trajectory is odometry, a step between consecutive poses, with the standard deviations
    ``odometry`` (m, rad) of each coordinate of a step. ``closures`` is a file of loop closures for
    it, lines ``EDGE_SE3:QUAT i j …`` or ``EDGE_SE2 i j …`` of g2o, or TORO's, each with its
    information; i and j count the poses of the trajectory from 0.

    Information matrices that are not positive definite are refused if ``indefinite`` is "raise",
    or replaced by the "nearest" one or by an "isotropic" one. Lines with an ``unknown`` tag, such
    as landmarks, are refused, because a map without them is another map, or left out ("skip"), and
    FIX lines of their vertices with them; ``read_factors`` uses those of g2o. What was replaced,
    left out or assumed is in the ``remarks`` and the ``summary`` of the result.

    Raises:
        GraphFileError: the file is a robot's log or packed; a line is malformed, a tag unknown,
            a number not finite or beyond 1e30, an id not what it has to be, a vertex given
            twice or missing, a quaternion zero, an information matrix not positive definite;
            an edge joins a vertex to itself; SE(2) and SE(3) are mixed; several vertices are
            fixed; there are no edges, or they do not connect all vertices; a trajectory comes
            without ``odometry``; or the file, apart from comments, is not UTF-8.
        ValueError: ``indefinite`` or ``unknown`` is not one of the words above, a deviation is
            not above 0, or ``odometry`` or ``closures`` comes with a graph that has its own.
        OSError: the file cannot be read.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "two.g2o"
    >>> _ = path.write_text("EDGE_SE2 7 9 1 0 0 4 0 0 4 0 9")
    >>> read(path).graph.n, read(path).names.tolist()
    (2, [7, 9])
    """
    allowed = ("indefinite", indefinite, _MATRICES), ("unknown", unknown, get_args(Unknown))
    for name, value, words in allowed:
        if value not in words:
            raise ValueError(f"{name} is {value!r}; give one of {', '.join(map(repr, words))}")
    with named_file(path):
        text, commas = text_of(path)
        form = _format(text)
        if form is not None:
            found = graph_of(text, form, indefinite, unknown)
            for name, given in (("odometry", odometry), ("closures", closures)):
                if given is not None:
                    raise ValueError(f"{name}: {_ALONE}")
            return replace(found, notes=(*commas, *found.notes))
        drive = trajectories.drive_of(text)
        if odometry is None:
            raise Fault(0, _UNTOLD)
    edges = None
    if closures is not None:
        with named_file(closures):
            edges = _closures(text_of(closures)[0], indefinite, unknown)
            trajectories.check_ends(edges, len(drive.poses))
    drive = replace(drive, notes=(*commas, *drive.notes))
    return trajectories.graph_of(drive, odometry, edges)


def read_poses(path: str | os.PathLike[str]) -> tuple[Array, Array | None]:
    """Return the poses ``(n, 3, 4)`` of a trajectory and their times ``(n,)`` (s), if it has any.

    Raises:
        GraphFileError, OSError: the file is no trajectory, or as ``read``.

    >>> import tempfile
    >>> path = Path(tempfile.mkdtemp()) / "drive.tum"
    >>> _ = path.write_text("0 0 0 0 0 0 0 1\\n1 2 0 0 0 0 0 1\\n")
    >>> read_poses(path)[0][1, :, 3].tolist()
    [2.0, 0.0, 0.0]
    """
    with named_file(path):
        text, _ = text_of(path)
        if _format(text) is not None:
            raise Fault(0, "it is a graph; rs.read(path).poses are those of its vertices")
        drive = trajectories.drive_of(text)
    return drive.poses, drive.times


def text_of(path: str | os.PathLike[str]) -> tuple[str, tuple[str, ...]]:
    """Return the text of a file, with decimal points, and a sentence if it had decimal commas.

    Raises:
        Fault: it is of another kind, by its first bytes, or not UTF-8.
    """
    if Path(path).is_dir():
        raise Fault(0, f"a folder is no file; if it is a ROS 2 bag, {_ROS_2}")
    content = Path(path).read_bytes()
    for magic, (kind, remedy) in _MAGIC.items():
        if content.startswith(magic):
            raise Fault(0, f"this is {kind}; {remedy}")
    return with_points(decoded(content))


def _format(text: str) -> Format | None:
    """Return the format of a text; None is a trajectory, whose lines have no tags."""
    for k, (_, fields) in enumerate(lines_of(text)):
        if k < _AHEAD and real(trajectories.fields_of(" ".join(fields))[0]) is not None:
            return None
        # The tags of .pyfg are those of g2o; a time and an id with a letter follow them.
        if fields[0] in PYFG.tags and any(read_id(field) is not None for field in fields[2:3]):
            return PYFG
        for form in (TORO, G2O):
            if fields[0] in form.tags:
                return form
    return G2O


def _closures(text: str, indefinite: Indefinite, unknown: Unknown) -> Edges:
    form = _format(text)
    if form is None or form is PYFG:
        wanted = "EDGE_SE3:QUAT i j x y z qx qy qz qw and 21 numbers of information, or EDGE_SE2"
        raise Fault(0, f"these are no closures; give lines {wanted}")
    return edges_alone(text, form, indefinite, unknown)


@contextmanager
def named_file(path: str | os.PathLike[str]) -> Iterator[None]:
    """Name the file in front of what is wrong in it.

    Raises:
        GraphFileError: in place of a ``Fault``.
    """
    try:
        yield
    except Fault as fault:
        raise GraphFileError(f"{os.fspath(path)}:{fault}") from None
