"""g2o files: what is written is read, what is wrong is named by file and line."""

import resource
import stat

import numpy as np
import pytest
from robust_slam.files import datasets, g2o
from robust_slam.files.graph_file import GraphFileError
from robust_slam.files.reading import read as read_file
from robust_slam.graphs import pose_graph
from scipy.spatial.transform import Rotation

from ..worlds import assert_same_poses, public_graph, random_graph, refused

UNIT = "1 0 0 1 0 1"
SPACE_UNIT = "1 0 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0 0 1 0 1"
PLANE = f"""\
VERTEX_SE2 0 0 0 0
VERTEX_SE2 1 1 0 0.5
VERTEX_SE2 2 1.5 1 1
EDGE_SE2 0 1 1 0 0.5 {UNIT}
EDGE_SE2 1 2 0.9 0.1 0.5 {UNIT}
EDGE_SE2 0 2 1.5 1 1 {UNIT}
"""
SPACE = f"""\
VERTEX_SE3:QUAT 0 0 0 0 0 0 0 1
VERTEX_SE3:QUAT 1 1 0 0 0 0 0.6 0.8
EDGE_SE3:QUAT 0 1 1 0 0 0 0 0.6 0.8 {SPACE_UNIT}
"""


def put(folder, text, name="graph.g2o"):
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def read(folder, text, **options):
    return read_file(put(folder, text), **options)


def assert_refused(path, message, of=None, **options):
    """Assert that reading is refused with the path, or that ``of`` another file, and a message."""
    with pytest.raises(GraphFileError) as caught:
        read_file(path, **options)
    assert str(caught.value).startswith(f"{of or path}:{message}")


def written_and_read(folder, record):
    path = folder / "again.g2o"
    g2o.write(path, record.graph, record.poses, record.names)
    return read_file(path)


def assert_same_bits(a, b):
    for name in ("edges", "measurement", "information", "is_odometry"):
        assert getattr(a.graph, name).tobytes() == getattr(b.graph, name).tobytes(), name
    assert a.graph.n == b.graph.n
    np.testing.assert_array_equal(a.names, b.names)
    if a.poses is None or b.poses is None:
        assert a.poses is b.poses
    else:
        assert a.poses.tobytes() == b.poses.tobytes()


def test_each_number_of_the_plane_has_its_place(tmp_path):
    vertices = "VERTEX_SE2 3 1 2 0.25\nVERTEX_SE2 4 5 6 7\n"
    found = read(tmp_path, vertices + "EDGE_SE2 3 4 0.1 0.2 0.3 11 1 2 12 3 13\n")
    assert found.graph.n == 2
    np.testing.assert_array_equal(found.names, [3, 4])
    np.testing.assert_array_equal(found.poses, [[1, 2, 0.25], [5, 6, 7]])
    np.testing.assert_array_equal(found.graph.edges, [[0, 1]])
    np.testing.assert_array_equal(found.graph.measurement, [[0.1, 0.2, 0.3]])
    np.testing.assert_array_equal(found.graph.information, [[[11, 1, 2], [1, 12, 3], [2, 3, 13]]])


def test_each_number_of_space_has_its_place(tmp_path):
    # The upper triangle holds 1, 2, … 21 off a heavy diagonal. The quaternion (0, 0, 3, 4)
    # turns about z with cos(θ/2) = 4/5: cos θ = 7/25 and sin θ = 24/25.
    triangle = np.arange(1.0, 22.0)
    triangle[[0, 6, 11, 15, 18, 20]] += 100.0
    found = read(tmp_path, f"EDGE_SE3:QUAT 0 1 1 2 3 0 0 3 4 {' '.join(map(str, triangle))}")
    information = found.graph.information[0]
    np.testing.assert_array_equal(information[0], [101, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(information[1], [2, 107, 8, 9, 10, 11])
    np.testing.assert_array_equal(information[5], [6, 11, 15, 18, 20, 121])
    turned = [[7 / 25, -24 / 25, 0, 1], [24 / 25, 7 / 25, 0, 2], [0, 0, 1, 3]]
    np.testing.assert_allclose(found.graph.measurement[0], turned, atol=3e-15)
    assert found.poses is None


def test_ids_may_come_in_any_order_and_with_gaps(tmp_path):
    found = read(
        tmp_path,
        f"EDGE_SE2 40 7 1 0 0 {UNIT}\nVERTEX_SE2 40 4 0 0\nVERTEX_SE2 7 1 0 0\n"
        f"EDGE_SE2 7 9000000000000000000 2 0 0 {UNIT}\nVERTEX_SE2 9000000000000000000 9 0 0\n",
    )
    np.testing.assert_array_equal(found.names, [7, 40, 9000000000000000000])
    np.testing.assert_array_equal(found.graph.edges, [[1, 0], [0, 2]])
    np.testing.assert_array_equal(found.poses[:, 0], [1, 4, 9])


def test_the_fixed_vertex_is_pose_0_and_the_others_ascend(tmp_path):
    found = read(tmp_path, "FIX 1\nFIX 1\n" + PLANE)
    np.testing.assert_array_equal(found.names, [1, 0, 2])
    np.testing.assert_array_equal(found.graph.edges, [[1, 0], [0, 2], [1, 2]])
    np.testing.assert_array_equal(found.poses[:, 0], [1, 0, 1.5])
    plain = read(tmp_path, PLANE)
    # The same edges between the same vertices cost the same.
    assert pose_graph.cost(found.graph, found.poses) == pose_graph.cost(plain.graph, plain.poses)
    np.testing.assert_array_equal(found.graph.is_odometry, plain.graph.is_odometry)


def test_odometry_is_the_first_forward_edge_between_neighbours_or_else_the_first_back(tmp_path):
    ends = [(20, 10), (10, 20), (10, 20), (10, 30), (30, 20), (30, 20), (30, 40), (40, 30)]
    found = read(tmp_path, "".join(f"EDGE_SE2 {i} {j} 1 0 0 {UNIT}\n" for i, j in ends))
    assert found.graph.is_odometry.tolist() == [k in (1, 4, 6) for k in range(8)]


@pytest.mark.parametrize("ends", [(12, 13), (13, 12)])
def test_a_wrong_closure_between_neighbours_is_none_wherever_it_stands(tmp_path, ends):
    walk = [
        f"EDGE_SE2 {k} {k + 1} {1 + 0.01 * (k % 3)} 0 {k % 4 // 3} {UNIT}\n" for k in range(30)
    ]
    wrong, back = f"EDGE_SE2 {ends[0]} {ends[1]} 3 2 2 {UNIT}\n", f"EDGE_SE2 13 12 -1 0 0 {UNIT}\n"
    for lines in ([wrong, *walk], [*walk, wrong], [wrong, *walk[:12], back, *walk[13:]]):
        graph = read(tmp_path, "".join(lines)).graph
        assert np.flatnonzero(~graph.is_odometry).tolist() == [lines.index(wrong)]


@pytest.mark.parametrize(
    ("harmless", "end"),
    [
        (b"# caf\xe9\n", "\n"),
        (b"FIX 0 0\n", "\n"),
        (b"PARAMS_SE2OFFSET 0 0 0 0\n", "\n"),
        (b"\xef\xbb\xbf# a graph\n\n", "  # and so on\r\n\t\r\n"),
    ],
    ids=["a comment in Latin-1", "one vertex fixed twice", "parameters", "other line ends"],
)
def test_what_changes_no_number_is_accepted(tmp_path, harmless, end):
    noisy = harmless + PLANE.replace("\n", end).encode()
    assert_same_bits(read(tmp_path, noisy), read(tmp_path, PLANE))


@pytest.mark.parametrize(
    ("ends", "leap"),
    [
        ([(0, 1), (1, 2), (2, 3), (3, 900), (900, 901)], "edge 3-900 crosses a gap"),
        ([(0, 1), (1, 2), (901, 900), (900, 2), (0, 900)], "edge 900-2 crosses a gap"),
        ([(10, 20), (20, 30), (30, 40), (10, 40)], ""),
        ([(7, 9000)], ""),
        ([(0, 1), (1, 2), (0, 900), (900, 901)], ""),
    ],
)
def test_odometry_across_a_gap_in_the_ids_is_told(tmp_path, ends, leap):
    found = read(tmp_path, "".join(f"EDGE_SE2 {i} {j} 1 0 0 {UNIT}\n" for i, j in ends))
    assert leap in found.summary() and ("a gap" in found.summary()) == bool(leap)


SECOND = "VERTEX_SE2 1 1 0 0.5"
FOURTH = f"EDGE_SE2 0 1 1 0 0.5 {UNIT}"


@refused(
    ("", " no edge is there; add"),
    ("VERTEX_SE2 0 0 0 0\n", " no edge is there; add"),
    (PLANE + "VERTEX_SE2 3 0 0\n", "7: VERTEX_SE2 has 3 fields behind it; give 4"),
    (PLANE + FOURTH + " 1\n", "7: EDGE_SE2 has 12 fields behind it; give 11"),
    ("FIX\n" + PLANE, "1: FIX has 0 fields behind it; give 1"),
    ("FIX 0 1\n" + PLANE, "1: vertex 1 is fixed beside vertex 0; the library"),
    (PLANE + "FIX 7\nPARAMS_SE2OFFSET 0 0 0 0\n", "7: vertex 7 is missing; fix one"),
    (SPACE + "VERTEX3 2 0 0 0 0 0 0\n", "4: the tag 'VERTEX3' is unknown; use VERTEX_SE2"),
    (PLANE + "EDGE_SE2_XY 0 1 1 1 1 0 1\n", "7: the tag 'EDGE_SE2_XY' is unknown; use VERT"),
    (PLANE.replace("0.9", "0,9"), "5: field 3 is '0,9'; give a number"),
    (PLANE.replace("0.9", "1_0"), "5: field 3 is '1_0'; give a number"),
    (PLANE.replace("0.9", "٣"), "5: field 3 is '٣'; give a number"),
    (PLANE.replace("0.9", "nan"), "5: a number is not finite; remove"),
    (PLANE.replace("1.5 1 1\n", "1.5 -inf 1\n", 1), "3: a number is not finite"),
    (PLANE.replace("_SE2 2", "_SE2 2.0"), "3: field 1 is '2.0'; give a whole number"),
    (PLANE.replace("_SE2 2", "_SE2 -2"), "3: field 1 is '-2'; give a whole number"),
    (PLANE.replace("_SE2 2", "_SE2 " + "9" * 6000), "3: field 1 is '999"),
    (PLANE + SECOND + "\n", "7: vertex 1 is given twice; drop one line"),
    (PLANE.replace(SECOND + "\n", ""), "3: vertex 1 is missing; add its line"),
    (PLANE + FOURTH.replace("0 1", "1 1", 1), "7: the edge joins vertex 1 to itself; drop"),
    (PLANE + FOURTH.replace(UNIT, "1 2 0 1 0 1"), "7: the information matrix is not pos"),
    (PLANE + FOURTH.replace(UNIT, "1 0 0 1 0 0"), "7: the information matrix is not pos"),
    (SPACE.replace("0 0 0.6 0.8 1", "0 0 0 0 1"), "3: the quaternion is 0; no turn is"),
    (PLANE + SPACE, "7: SE(2) and SE(3) are mixed; put"),
    (SPACE + PLANE, "4: SE(2) and SE(3) are mixed; put"),
    ("FIX 0\nFIX 0\nFIX 2\n" + PLANE, "3: vertex 2 is fixed beside vertex 0; the library"),
    ("FIX 7\n" + PLANE, "1: vertex 7 is missing; fix one that is there"),
    (
        PLANE + f"EDGE_SE2 7 9 1 0 0 {UNIT}\nVERTEX_SE2 7 0 0 0\nVERTEX_SE2 9 0 0 0\n",
        " no path of edges joins vertex 0 to 7, 9; add an edge or drop",
    ),
    (
        f"EDGE_SE2 0 1 1 0 0 {UNIT}\n"
        + "".join(f"EDGE_SE2 {k} {k + 1} 1 0 0 {UNIT}\n" for k in range(10, 18)),
        " no path of edges joins vertex 0 to 10, 11, 12, 13, 14 and 4 more; add",
    ),
    (PLANE.encode() + b"caf\xe9 # \xe9\n", "7: the bytes are not UTF-8 text; save"),
    (PLANE.encode("utf-16"), "1: the bytes are not UTF-8 text; save"),
)
def test_what_is_wrong_is_named_with_file_line_and_fix(tmp_path, wrong, message):
    assert_refused(put(tmp_path, wrong), message)


@pytest.mark.parametrize("seed", range(5))
def test_the_second_round_trip_changes_no_bit_and_the_first_hardly_one(tmp_path, group, seed):
    poses, graph = random_graph(seed, group, n=40, m=90)
    path = tmp_path / "graph.g2o"
    g2o.write(path, graph, poses)
    first = read_file(path)
    assert_same_poses(group, first.graph.measurement, graph.measurement, atol=3e-15)
    assert_same_poses(group, first.poses, poses, atol=3e-15)
    np.testing.assert_array_equal(first.graph.edges, graph.edges)
    np.testing.assert_array_equal(np.triu(first.graph.information), np.triu(graph.information))
    np.testing.assert_array_equal(first.names, np.arange(40))
    g2o.write(path, first.graph, first.poses, first.names)
    assert_same_bits(read_file(path), first)


def quaternions(kind, rng):
    """Quaternions that are hard to find again: equals, zeros, tiny turns, wild lengths."""
    count = 400
    angle = rng.uniform(0.0, 2.0 * np.pi, size=(count, 1))
    if kind == "any length":
        return rng.normal(size=(count, 4)) * 10.0 ** rng.uniform(-200, 200, size=(count, 1))
    if kind == "tiny turns":
        turn = rng.normal(size=(count, 3)) * 10.0 ** rng.uniform(-20, 0, size=(count, 1))
        return np.concatenate([turn, np.ones((count, 1))], axis=1)
    if kind == "equal components":
        return np.tile(np.concatenate([np.cos(angle), np.sin(angle)], axis=1), 2)
    every = np.array(np.meshgrid(*[[0.0, 1.0, -1.0, np.sqrt(0.5), 1e-9, 1e-17]] * 4))
    return every.reshape(4, -1).T[1:]


@pytest.mark.parametrize("kind", ["any length", "tiny turns", "equal components", "corners"])
def test_every_quaternion_comes_back_to_the_last_bit(tmp_path, kind, seed):
    q = quaternions(kind, np.random.default_rng(seed))
    lines = (
        f"EDGE_SE3:QUAT {k} {k + 1} 0 0 0 {' '.join(map(repr, row))} {SPACE_UNIT}\n"
        for k, row in enumerate(q.tolist())
    )
    first = read(tmp_path, "".join(lines))
    scale = np.abs(q).max(axis=1, keepdims=True)
    expected = Rotation.from_quat(q / scale).as_matrix()
    np.testing.assert_allclose(first.graph.rotation, expected, atol=3e-15)
    assert_same_bits(written_and_read(tmp_path, first), first)


def test_a_fix_line_is_written_only_where_it_is_needed(tmp_path):
    _, graph = random_graph(1, n=3, m=3)
    path = tmp_path / "graph.g2o"
    g2o.write(path, graph, names=[5, 6, 9])
    assert "FIX" not in path.read_text()
    g2o.write(path, graph, names=[6, 5, 9])
    assert path.read_text().startswith("FIX 6\n")


@pytest.mark.parametrize("name", ["CSAIL", "intel", "M3500", "smallGrid3D", "parking-garage"])
def test_public_graphs_come_back_to_the_last_bit(tmp_path, name):
    found = public_graph(name, lambda name: read_file(datasets.find(name)))
    assert_same_bits(written_and_read(tmp_path, found), found)
    assert np.sum(found.graph.is_odometry) == found.graph.n - 1


@refused(
    ([0, 1], r"names: the shape is \(2,\); give \(3,\)"),
    ([0.0, 1.0, 2.0], "names: the entries are float64; give whole numbers"),
    ([0, -1, 2], "names: an id is out of range"),
    (np.array([0, 1, 2**63], dtype=np.uint64), "names: an id is out of range"),
    ([0, 2, 1], "names: ids must differ, and ascend from entry 1 on"),
    ([0, 1, 1], "names: ids must differ, and ascend from entry 1 on"),
    ([2, 1, 2], "names: ids must differ, and ascend from entry 1 on"),
)
def test_names_that_would_not_come_back_are_refused(tmp_path, wrong, message):
    _, graph = random_graph(1, n=3, m=3)
    with pytest.raises(ValueError, match=message):
        g2o.write(tmp_path / "graph.g2o", graph, names=wrong)
    assert list(tmp_path.iterdir()) == []


def test_a_file_is_replaced_whole_or_not_at_all_and_has_the_permissions_of_any_new_file(tmp_path):
    _, graph = random_graph(3)
    path = put(tmp_path, "as it was")
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, limits[1]))
    try:
        with pytest.raises(OSError, match="File too large"):
            g2o.write(path, graph)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_text() == "as it was"
    assert list(tmp_path.iterdir()) == [path]
    g2o.write(path, graph)
    assert read_file(path).graph.n == graph.n
    assert list(tmp_path.iterdir()) == [path]
    (plain := tmp_path / "plain").touch()
    assert stat.S_IMODE(path.stat().st_mode) == stat.S_IMODE(plain.stat().st_mode)
