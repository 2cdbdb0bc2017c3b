"""Every format is told by its content, and its numbers mean what its own program means."""

import logging
from pathlib import Path

import numpy as np
import pytest
import robust_slam as rs
from evo.tools import file_interface
from hypothesis import given, settings
from hypothesis import strategies as st
from robust_slam.files import g2o
from robust_slam.files.graph_file import GraphFileError
from robust_slam.files.reading import read_poses
from robust_slam.files.trajectories import write_kitti, write_tum
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.pose_graph import relative_poses, unreached
from scipy.spatial.transform import Rotation

from ..worlds import assert_same_poses, refused
from .test_g2o import PLANE, SPACE, SPACE_UNIT, UNIT, assert_refused, assert_same_bits, put, read

ROTATION_FIRST = [3, 4, 5, 0, 1, 2]
TRIANGLE = np.arange(1.0, 22.0)
TRIANGLE[[0, 6, 11, 15, 18, 20]] += 100.0
HALF = " ".join(map(repr, TRIANGLE.tolist()))
TORO_PLANE = """\
VERTEX2 3 1 2 0.25
VERTEX2 4 5 6 0.5
EDGE2 3 4 0.1 0.2 0.3 11 1 12 13 2 3
EDGE2 4 3 0.1 0.2 -3.0 11 1 12 13 2 3
"""
TORO_SPACE = f"""\
VERTEX3 3 1 2 3 0.1 -0.2 3.0
VERTEX3 4 5 6 7 0 0 0
EDGE3 3 4 0.1 0.2 0.3 0.4 -1.5 2.6 {HALF}
EDGE3 4 3 1 2 3 -3 0.5 -2 {HALF}
"""
PYFG_PLANE = """\
VERTEX_SE2 0.5 B2 1 2 0.25
VERTEX_SE2 0.1 A10 0 0 0
VERTEX_SE2 0.1 A9 0 0 0
EDGE_SE2 1.5 A9 A10 0.1 0.2 0.3 0.04 0.001 0.002 0.09 0.003 0.01
EDGE_SE2 2.5 A10 B2 1 2 0.3 0.04 0 0 0.09 0 0.01
"""


def test_the_plane_of_toro_has_its_own_order_of_the_matrix(tmp_path):
    found = read(tmp_path, TORO_PLANE)
    assert found.ids.tolist() == found.names.tolist() == [3, 4]
    np.testing.assert_array_equal(found.poses, [[1, 2, 0.25], [5, 6, 0.5]])
    np.testing.assert_array_equal(found.graph.edges, [[0, 1], [1, 0]])
    np.testing.assert_array_equal(found.graph.measurement[0], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(found.graph.information[0], [[11, 1, 2], [1, 12, 3], [2, 3, 13]])


def test_the_angles_of_toro_turn_about_x_then_y_then_z(tmp_path):
    found = read(tmp_path, TORO_SPACE)
    turned = Rotation.from_euler("ZYX", [2.6, -1.5, 0.4]).as_matrix()
    np.testing.assert_allclose(found.graph.rotation[0], turned, atol=1e-14)
    np.testing.assert_array_equal(found.graph.translation[0], [0.1, 0.2, 0.3])
    np.testing.assert_array_equal(found.graph.information[0][0], [101, 2, 3, 4, 5, 6])
    turned = Rotation.from_euler("ZYX", [3.0, -0.2, 0.1]).as_matrix()
    np.testing.assert_allclose(found.poses[0][:, :3], turned, atol=1e-14)


def test_toro_lines_in_the_order_of_g2o_are_read_so_and_said_to_be(tmp_path):
    found = read(tmp_path, "EDGE2 0 1 1 0 0 4 1 0 5 0 9\nEQUIV 2 0\nEDGE2 1 2 1 0 0 4 0 0 5 0 9\n")
    np.testing.assert_array_equal(found.graph.information[0], [[4, 1, 0], [1, 5, 0], [0, 0, 9]])
    assert "EDGE2 lines are read row by row, as in g2o" in found.summary()
    assert "skipped 1 line with the tag EQUIV" in found.summary()
    mixed = put(tmp_path, "EDGE2 0 1 1 0 0 4 0 5 9 0 0\nEDGE2 1 2 1 0 0 4 0 0 5 0 9\n")
    assert_refused(mixed, "2: the information matrix is not positive")


def assert_as_gtsam(gtsam, path, *, toro, **options):
    """Compare each relative pose, information matrix and vertex with those of GTSAM's reader."""
    found = rs.read(path, **options)
    graph, plane = found.graph, found.graph.group.DIMENSION == 2
    if plane:
        layout = gtsam.NoiseFormat.NoiseFormatTORO if toro else gtsam.NoiseFormat.NoiseFormatG2O
        factors, values = gtsam.load2D(str(path), None, 0, False, True, layout)
    else:
        factors, values = gtsam.load3D(str(path))
    between = gtsam.BetweenFactorPose2 if plane else gtsam.BetweenFactorPose3
    theirs = [factors.at(k) for k in range(factors.size())]
    theirs = [factor for factor in theirs if isinstance(factor, between)]
    assert [factor.keys() for factor in theirs] == found.ids[graph.edges].tolist()
    measured = np.array([factor.measured().matrix()[:-1] for factor in theirs])
    np.testing.assert_allclose(graph.group.translation(graph.measurement), measured[..., -1])
    np.testing.assert_allclose(graph.rotation, measured[..., :-1], atol=1e-9)
    # Of EDGE3 GTSAM keeps the order of the file, which has the position first, like ours.
    order = slice(None) if plane or toro else ROTATION_FIRST
    information = [factor.noiseModel().R().T @ factor.noiseModel().R() for factor in theirs]
    ours = graph.information[:, order][:, :, order]
    np.testing.assert_allclose(information, ours, rtol=1e-9, atol=1e-9)
    if found.poses is not None:
        at = values.atPose2 if plane else values.atPose3
        given = np.array([at(key).matrix()[:-1] for key in found.ids.tolist()])
        np.testing.assert_allclose(graph.group.translation(found.poses), given[..., -1])
        np.testing.assert_allclose(graph.group.rotation(found.poses), given[..., :-1], atol=1e-9)


IN_GTSAM = {
    "pose2example.txt": (11, 12, 2),
    "noisyToyGraph.txt": (4, 5, 2),
    "toyExample.g2o": (5, 6, 2),
    "pose3example-grid.txt": (27, 44, 18),
    "pose3example-offdiagonal.txt": (2, 1, 0),
    "Klaus3.g2o": (3, 3, 1),
    "w100.graph": (100, 300, 201),
    "example.graph": (95, 94, 0),
    "sphere2500.txt": (2500, 4949, 2450),
    "known_landmark_localization_20.g2o": (20, 19, 0),
}
"""Files of GTSAM's wheel: their poses, edges and closures."""


@pytest.mark.parametrize("name", IN_GTSAM)
def test_files_of_gtsam_are_read_as_gtsam_reads_them(gtsam, name):
    path = Path(gtsam.__file__).parent / "Data" / name
    graph = rs.read(path, unknown="skip").graph
    assert (graph.n, len(graph.edges), int(np.sum(~graph.is_odometry))) == IN_GTSAM[name]
    toro = any(tag in path.read_text() for tag in ("EDGE2", "EDGE3"))
    assert_as_gtsam(gtsam, path, toro=toro, unknown="skip")


def test_pyfg_gives_covariances_and_ids_with_the_letter_of_a_robot(tmp_path):
    found = read(tmp_path, PYFG_PLANE)
    assert found.names.tolist() == ["A9", "A10", "B2"]
    assert found.ids.tolist() == [(65 << 56) + 9, (65 << 56) + 10, (66 << 56) + 2]
    np.testing.assert_array_equal(found.poses[2], [1, 2, 0.25])
    covariance = np.array([[0.04, 0.001, 0.002], [0.001, 0.09, 0.003], [0.002, 0.003, 0.01]])
    np.testing.assert_allclose(found.graph.information[0] @ covariance, np.eye(3), atol=1e-13)
    # What joins two robots is no odometry, whatever their numbers.
    assert found.graph.is_odometry.tolist() == [True, False]


def test_pyfg_in_space_is_that_of_g2o_with_a_time_and_the_inverse(tmp_path):
    half = "1 0 0 0 0 0 2 0 0 0 0 3 0 0 0 4 0 0 5 0 6"
    line = f"EDGE_SE3:QUAT 7.5 A0 A1 1 2 3 0 0 0.6 0.8 {half}\n"
    graph = read(tmp_path, line).graph
    diagonal = 1.0 / np.arange(1.0, 7.0)
    np.testing.assert_allclose(graph.information[0], np.diag(diagonal), atol=1e-15)
    np.testing.assert_array_equal(graph.translation[0], [1, 2, 3])


@refused(
    (PYFG_PLANE.replace("A9 A10", "A9 10"), "4: field 3 is '10'; give a letter and a number"),
    (PYFG_PLANE.replace("1.5 A9", "now A9"), "4: field 1 is 'now'; give a number"),
    (PYFG_PLANE.replace("0 0 0.09", "0 0 0"), "5: the covariance matrix is not positive def"),
    (
        PYFG_PLANE.replace("0.04 0 0 0.09", "1 1 0 1.0000000000000002"),
        "5: the covariance matrix is not positive definite",
    ),
    (PYFG_PLANE.replace("A10 B2 1", "A10 A10 1"), "5: the edge joins vertex A10 to itself"),
    (PYFG_PLANE.replace("A10 B2 1", "A10 B3 1"), "5: vertex B3 is missing; add its line"),
    (PYFG_PLANE[: PYFG_PLANE.index("EDGE_SE2 2.5")], " no path of edges joins vertex A9 to"),
    (TORO_PLANE.replace("13 2 3\n", "13 2\n", 1), "3: EDGE2 has 10 fields behind it; give 11"),
    ("5 1,1,0,0,1,0,0,0 9\n", "1: the tag '5' is unknown; if it is a"),
)
def test_what_is_wrong_is_named_by_the_ids_of_the_file(tmp_path, wrong, message):
    assert_refused(put(tmp_path, wrong), message)


@pytest.mark.parametrize("text", [TORO_SPACE, TORO_PLANE, PYFG_PLANE], ids=["3D", "2D", "pyfg"])
def test_a_graph_of_another_format_is_the_same_when_written_as_g2o(tmp_path, text):
    found = read(tmp_path, text)
    g2o.write(tmp_path / "as.g2o", found.graph, found.poses, found.ids)
    again = rs.read(tmp_path / "as.g2o")
    for name in ("edges", "measurement", "information"):
        np.testing.assert_array_equal(getattr(again.graph, name), getattr(found.graph, name))
    np.testing.assert_array_equal(again.ids, found.ids)
    np.testing.assert_array_equal(again.poses, found.poses)


TRUTHS = {"plane": manhattan(30, 0)[1], "space": sphere(30, 0)[1]}
WRITERS = {"tum": write_tum, "kitti": write_kitti}


@pytest.mark.parametrize("kind", TRUTHS)
def test_evo_reads_the_same_poses(tmp_path, kind):
    poses = TRUTHS[kind]
    write_tum(tmp_path / "a.tum", poses)
    write_kitti(tmp_path / "a.kitti", poses)
    tum = file_interface.read_tum_trajectory_file(tmp_path / "a.tum")
    kitti = file_interface.read_kitti_poses_file(tmp_path / "a.kitti")
    np.testing.assert_array_equal(tum.timestamps, np.arange(30))
    for one, other in zip(tum.poses_se3, kitti.poses_se3, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)
    at = np.stack(kitti.poses_se3)
    if kind == "space":
        np.testing.assert_array_equal(at[:, :3], poses)
    else:
        np.testing.assert_array_equal(at[:, :2, 3], poses[:, :2])
        np.testing.assert_allclose(np.arctan2(at[:, 1, 0], at[:, 0, 0]), poses[:, 2], atol=1e-12)
        np.testing.assert_array_equal(at[:, 2], np.broadcast_to([0, 0, 1, 0], (30, 4)))


@pytest.mark.parametrize("form", WRITERS)
def test_a_trajectory_is_odometry_with_the_given_deviations(tmp_path, form):
    poses = TRUTHS["space"]
    path = tmp_path / "drive.txt"
    WRITERS[form](path, poses)
    found = rs.read(path, odometry=(0.05, 0.01))
    assert_same_poses(found.graph.group, found.poses, poses, atol=1e-12)
    assert np.all(found.graph.is_odometry) and len(found.graph.edges) == 29
    steps = relative_poses(found.graph, poses)
    assert_same_poses(found.graph.group, found.graph.measurement, steps, atol=1e-12)
    expected = np.diag([0.05] * 3 + [0.01] * 3) ** 2
    np.testing.assert_allclose(found.graph.information[7] @ expected, np.eye(6), atol=1e-12)
    assert "no edge is a loop closure" in found.summary()


@pytest.mark.parametrize("form", WRITERS)
@pytest.mark.parametrize("kind", TRUTHS)
def test_closures_of_another_file_make_it_a_graph(tmp_path, form, kind):
    poses = TRUTHS[kind]
    path, closures = tmp_path / "drive.txt", tmp_path / "closures.g2o"
    WRITERS[form](path, poses)
    pose, half = ("1 2 0.5", "4 0 0 5 0 6")
    if kind == "space":
        pose, half = ("1 2 3 0 0 0 1", HALF)
    tag = "EDGE_SE2" if kind == "plane" else "EDGE_SE3:QUAT"
    closures.write_text(f"{tag} 29 3 {pose} {half}\n{tag} 2 3 {pose} {half}\n")
    found = rs.read(path, odometry=(0.05, 0.01), closures=closures)
    graph = found.graph
    assert graph.edges.shape == (31, 2) and graph.measurement.ndim == poses.ndim
    assert_same_poses(graph.group, found.poses, poses, atol=1e-12)
    assert graph.edges[-2:].tolist() == [[29, 3], [2, 3]]
    # A closure is one even between neighbours, because the odometry has a file of its own.
    assert np.flatnonzero(~graph.is_odometry).tolist() == [29, 30]
    assert "1 of the closures join consecutive poses (first line 2)" in found.summary()
    np.testing.assert_array_equal(graph.translation[-1][:2], [1, 2])
    assert graph.information[-1][0, 0] == (4 if kind == "plane" else 101)
    assert rs.load(path, odometry=(0.05, 0.01), closures=closures).n == 30


def test_poses_are_read_without_deviations_and_a_file_is_saved_under_its_names(tmp_path):
    poses, times = TRUTHS["space"], 1e9 + np.arange(30.0)
    write_tum(tmp_path / "a.tum", poses, times)
    found, when = read_poses(tmp_path / "a.tum")
    np.testing.assert_allclose(found, poses, atol=1e-12)
    np.testing.assert_array_equal(when, times)
    file = rs.read(tmp_path / "a.tum", odometry=(0.1, 0.1))
    rs.save(tmp_path / "b.tum", file, poses)
    assert (tmp_path / "a.tum").read_text() == (tmp_path / "b.tum").read_text()
    with pytest.raises(GraphFileError, match=r"a.g2o: it is a graph; rs.read\(path\).poses are"):
        read_poses(put(tmp_path, PLANE, "a.g2o"))
    for suffix, these, words in (("txt", poses, "end it with .g2o"), ("tum", None, "poses alone")):
        with pytest.raises((TypeError, ValueError), match=words):
            rs.save(tmp_path / f"c.{suffix}", file, these)


TUM = "0.5 0 0 0 0 0 0 1\n1.5 1 0 0 0 0 0 1\n2.5 1 1 0 0 0 1 1\n"
KITTI = "1 0 0 0 0 1 0 0 0 0 1 0\n0 -1 0 1 1 0 0 2 0 0 1 0\n"


def table(mark=" ", order=range(8), names="", point=".", ahead=(), behind=(), unit=1.0):
    """The trajectory of ``TUM``, whose columns are in an ``order`` among others."""
    rows = []
    for k, line in enumerate(TUM.splitlines()):
        time, *rest = map(float, line.split())
        given = [f"{(1.4e9 + time) * unit:.0f}" if unit > 1.0 else f"{time:.3f}"]
        given += [f"{value:.9f}" for value in rest]
        row = [*[str(k)] * len(ahead), *[given[place] for place in order], *map(str, behind)]
        rows.append(mark.join(row).replace(".", point))
    return "\n".join([*([names] if names else []), *rows, ""])


W_FIRST = (0, 1, 2, 3, 7, 4, 5, 6)
EUROC = (
    "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y []"
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (table(names="timestamp x y z qx qy qz qw"), ""),
        (table(names="# timestamp(s) tx ty tz qx qy qz qw"), ""),
        (table(", "), ""),
        (table(",", behind=[""]), ""),
        (table("\t", point=","), "the commas in its numbers are read as decimal points"),
        (table(";", point=","), ""),
        (table("; ", names="Time;X;Y;Z;Qx;Qy;Qz;Qw"), ""),
        (table(names="num t x y z qx qy qz qw", ahead=[0]), "read as time x y z qx qy qz qw"),
        (
            table(order=(4, 5, 6, 7, 1, 2, 3, 0), names="qx qy qz qw tx ty tz t"),
            "qx qy qz qw x y z time",
        ),
        (table(",", W_FIRST, names="t,x,y,z,w,x,y,z"), "read as time x y z qw qx qy qz"),
        (table(",", W_FIRST, unit=1e9), "qw qx qy qz, with the time in nanoseconds"),
        (table(",", W_FIRST, unit=1e9, behind=range(9)), "with the time in nanoseconds"),
        (
            table(",", W_FIRST, f"{EUROC}, q_RS_z [], v [m s^-1]", unit=1e9, behind=[0.1]),
            "qw qx qy qz, with the time in nanoseconds",
        ),
        (table(unit=1e9), "qx qy qz qw, with the time in nanoseconds"),
        (table(names="slam:vins\nseq:1\n#Time position:x y z quaternion:x y z w"), ""),
        (table(names="#timestamp x y z qx qy qz qw id", behind=[7]), ""),
        (table(unit=1e6), "with the time in microseconds"),
    ],
)
def test_a_table_is_read_whatever_separates_and_names_its_columns(tmp_path, text, said):
    options = {"odometry": (0.1, 0.1)}
    found, plain = read(tmp_path, text, **options), read(tmp_path, TUM, **options)
    np.testing.assert_allclose(found.poses, plain.poses, atol=1e-8)
    np.testing.assert_allclose(found.times - found.times[0], [0.0, 1.0, 2.0], atol=1e-6)
    assert said in " ".join(found.notes) if said else not found.notes
    with pytest.raises(GraphFileError, match="a trajectory does not tell how exact it is"):
        read(tmp_path, text)


@refused(
    (TUM.replace("1.5", "0.5"), "2: the time does not ascend; sort the lines"),
    (TUM.replace("0 0 1 1", "0 0 0 0"), "3: the quaternion is 0"),
    (TUM + "3.5 1 1 1\n", "4: the line has 4 numbers, the first one 8"),
    (TUM.replace("1.5 1", "1.5 nan"), "2: a number is not finite"),
    (TUM.replace("1.5 1", "1.5 1e200"), "2: a number is beyond 1e+30; give metres"),
    (TUM.replace("1.5 1", "1.5 x"), "2: field 2 is 'x'; give a number"),
    (TUM.splitlines()[0], " one pose is no trajectory; give at least two"),
    ("# t x y\n1 2 3\n", "2: 3 numbers are no pose of a trajectory; give 8, as TUM does"),
    (table(",").replace("1.500", "1.500,"), "2: the line has 9 numbers, the first one 8"),
    (
        "a x,a y,a z,a qx,a qy,a qz,a qw,b qx,b qy,b qz,b qw\n" + "1," * 10 + "1\n",
        " the names abo",
    ),
    ("#\n1 1 0 0 0 0 0 0 1 a.png\n5 5 -1\n", "2: 'a.png' is no number; images of COLMAP tell wh"),
    (
        "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n",
        "1: 16 numbers are no pose of a trajectory; give 8, as TUM does (time x y z qx qy qz qw), "
        "or 12, as KITTI does ([R | t] row by row, without a last row 0 0 0 1), or name the "
        "columns in a line above; roll, pitch and yaw have to become a quaternion",
    ),
    (KITTI.replace("0 -1 0 1", "0 -2 0 1"), "2: the left part of [R | t] is not a rotation"),
    (KITTI.replace("0 -1 0 1", "0 1 0 1"), "2: the left part of [R | t] is not a rotation"),
)
def test_what_is_wrong_in_a_trajectory_is_named_by_line(tmp_path, wrong, message):
    assert_refused(put(tmp_path, wrong), message, odometry=(0.1, 0.1))


SPACE_EDGE = f"EDGE_SE3:QUAT 0 2 1 1 0 0 0 0 1 {HALF}\n"


@refused(
    (SPACE_EDGE.replace("0 2", "0 3", 1), "1: pose 3 is missing: the trajectory has 0 to 2"),
    (SPACE_EDGE.replace("0 2", "2 2", 1), "1: the edge joins vertex 2 to itself"),
    (SPACE_EDGE.replace("101.0", "-1"), "1: the information matrix is not positive"),
    ("0 2 1 1 0 0 0 1\n", " these are no closures; give lines EDGE_SE3:QUAT"),
    ("", " no edge is there; add lines EDGE_SE2 or EDGE_SE3:QUAT"),
)
def test_what_is_wrong_in_the_closures_is_named_by_their_file(tmp_path, wrong, message):
    drive, closures = put(tmp_path, TUM), put(tmp_path, wrong, "closures.g2o")
    assert_refused(drive, message, closures, odometry=(0.1, 0.1), closures=closures)


def test_closures_are_a_part_of_what_is_said_about_the_file(tmp_path, caplog):
    text = SPACE_EDGE + SPACE_EDGE + SPACE_EDGE.replace("101.0", "0", 1) + "VERTEX_TRACKXYZ 0\n"
    options = {"odometry": (0.1, 0.1), "indefinite": "nearest", "unknown": "skip"}
    closures = put(tmp_path, text, "closures.g2o")
    found = read(tmp_path, TUM, closures=closures, **options)
    assert found.repaired.tolist() == [4]
    assert found.skipped == {"VERTEX_TRACKXYZ": 1}
    assert "line 2 gives edge 0-2 once more with the same numbers" in found.summary()
    with caplog.at_level(logging.WARNING):
        rs.load(tmp_path / "graph.g2o", closures=closures, **options)
    assert all(words in caplog.text for words in found.remarks())


def test_what_a_trajectory_needs_is_asked_for_and_what_it_cannot_use_refused(tmp_path):
    path = put(tmp_path, TUM)
    with pytest.raises(GraphFileError, match=r"graph.g2o: a traj.*odometry=\(0.05, 0.01\) in m"):
        rs.read(path)
    with pytest.raises(ValueError, match=r"odometry is 0.0; give a finite number above 0"):
        rs.read(path, odometry=(0.1, 0.0))
    bent = put(tmp_path, TUM.replace("1.5 1 0 0", "1.5 1 0 0.1"))
    plane = put(tmp_path, "EDGE_SE2 0 2 1 1 0 1 0 0 1 0 1\n", "closures.g2o")
    with pytest.raises(ValueError, match="closures: they are in the plane, and pose 1 of the tra"):
        rs.read(bent, odometry=(0.1, 0.1), closures=plane)
    turned = put(tmp_path, TUM.replace("0 0 0 1\n", "1 0 0 0\n").replace("0 0 1 1", "1 0 0 1"))
    with pytest.raises(ValueError, match=r"pose 2 of the .* begin with w, write qx qy qz qw"):
        rs.read(turned, odometry=(0.1, 0.1), closures=plane)
    for option in ({"odometry": (0.1, 0.1)}, {"closures": path}):
        with pytest.raises(ValueError, match=f"{next(iter(option))}: it is for a trajectory"):
            rs.read(plane, **option)


@refused(
    (b"#ROSBAG V2.0\n\x00\x01", "this is a ROS 1 bag; .*evo_traj bag FILE TOPIC --save_as"),
    (b"SQLite format 3\x00\x10", "this is an SQLite database, such as a ROS 2 bag; it holds"),
    (b"\x89MCAP0\r\n\x01", "this is an MCAP log, .*export its graph as g2o, or take its odom"),
    (b"\x1f\x8b\x08\x00", "this is packed with gzip; unpack it first"),
    (b"PK\x03\x04", "this is a zip file; unpack it first"),
    (b"{'frames': []}", "this is JSON, such as nerfstudio's transforms.json; write its poses as"),
    (
        b"\xdb\x01\xf5\x5b\x7b\x1f\x1d\x7b",
        "this is a .pbstream of Cartographer; write its nodes and",
    ),
)
def test_a_log_of_a_robot_is_named_with_the_remedy_whatever_its_suffix(tmp_path, wrong, message):
    with pytest.raises(GraphFileError, match=rf"graph.g2o: {message}"):
        rs.load(put(tmp_path, wrong, "graph.g2o"))


def test_a_folder_is_named_as_what_it_may_be(tmp_path):
    with pytest.raises(GraphFileError, match="a folder is no file; if it is a ROS 2 bag, it"):
        rs.load(tmp_path)


TAGS = ["VERTEX_SE2", "EDGE_SE2", "VERTEX_SE3:QUAT", "EDGE_SE3:QUAT", "FIX"]
IDS = ["0", "1", "2", "-1", "1.0", "9223372036854775807", "9223372036854775808", "9" * 5000]
NUMBERS = ["nan", "inf", "-inf", "1e400", "1e-400", "1e308", "-1e308", "1e154", "5e-324"]
ODD = ["1_0", "0x1", "1e", "٣", "²", "\ufeff", "\x00", "\u2028", "", "#", "\n", "\r", "\x0c"]
WORDS = st.sampled_from([*TAGS, *IDS, *NUMBERS, *ODD, UNIT, SPACE_UNIT])
FUZZ = settings(max_examples=200, deadline=None, derandomize=True)


def accepted(path, content, comes_back=True, **options):
    """Read bytes: a whole graph, which ``comes_back`` from a file of g2o, or the one error."""
    path.write_bytes(content)
    try:
        found = rs.read(path, **options)
    except GraphFileError as error:
        assert str(error).startswith(f"{path}:")
        return
    except ValueError as error:
        assert "odometry" in options and str(error).startswith("odometry: it is for a trajectory")
        return
    graph = found.graph
    assert graph.n == found.ids.size == found.names.size == len(set(found.names.tolist()))
    assert len(graph.edges) == len(graph.measurement) == len(graph.information)
    assert found.poses is None or len(found.poses) == graph.n
    assert unreached(graph, np.ones(len(graph.edges), dtype=bool)).size == 0
    if comes_back:
        g2o.write(path.with_name("again.g2o"), graph, found.poses, found.ids)
        assert_same_bits(rs.read(path.with_name("again.g2o")), found)


@pytest.fixture(scope="module")
def scratch(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "graph.g2o"


@FUZZ
@given(content=st.binary(max_size=300) | st.text(max_size=300).map(str.encode))
def test_anything_is_a_graph_or_the_one_error(scratch, content):
    accepted(scratch, content)


@refused((10.5, "t: 10.5 s is over 0.5 s, a usual step, from"), (np.nan, "finite"))
def test_the_pose_nearest_in_time_is_found_and_none_far_away(tmp_path, wrong, message):
    write_tum(tmp_path / "drive.tum", TRUTHS["space"][:20], 0.5 * np.arange(20))
    file = rs.read(tmp_path / "drive.tum", odometry=(0.1, 0.1))
    assert file.nearest([[0.2, 0.3], [9.6, -0.4]]).tolist() == [[0, 1], [19, 0]]
    assert file.nearest(1.1) == 2
    with pytest.raises(ValueError, match=message):
        file.nearest([1.0, wrong])
    without = put(tmp_path, PLANE)
    with pytest.raises(ValueError, match="the file has no times; give the numbers of poses"):
        rs.read(without).nearest(0.0)


AFAR = SPACE.replace("T 1", "T 77").replace("0 1 1", "0 77 1")
OF_G2O = [PLANE, AFAR, "FIX 1\n" + PLANE]


@pytest.mark.parametrize("at", range(30, 51))
def test_information_that_is_nearly_singular_is_read_or_refused(at, scratch):
    fields = TORO_SPACE.replace("\n", " \n ").split(" ")
    fields[at] = str(2**63 - 1)
    accepted(scratch, " ".join(fields).encode(), comes_back=False)


@FUZZ
@given(
    data=st.data(),
    text=st.sampled_from([*OF_G2O, TORO_PLANE, TORO_SPACE, PYFG_PLANE, TUM, KITTI]),
    indefinite=st.sampled_from(["raise", "nearest", "isotropic"]),
)
def test_a_mutated_file_of_any_format_is_a_graph_or_the_one_error(scratch, data, text, indefinite):
    fields = text.replace("\n", " \n ").split(" ")
    for _ in range(data.draw(st.integers(0, 3))):
        fields[data.draw(st.integers(0, len(fields) - 1))] = data.draw(WORDS)
    drive = {"odometry": (0.1, 0.1)} if text in (TUM, KITTI) else {}
    content = " ".join(fields).encode()
    accepted(scratch, content, text in OF_G2O, indefinite=indefinite, **drive)
