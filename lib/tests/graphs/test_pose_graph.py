"""A pose graph refuses what is wrong with it, and its residuals obey their laws."""

from dataclasses import replace

import networkx
import numpy as np
import pandas
import pytest
import robust_slam as rs
from robust_slam.files import to_columns, to_rows
from robust_slam.graphs import concatenate, manhattan, pose_graph
from robust_slam.graphs.pose_graph import PoseGraph, deviations, select
from robust_slam.groups import se3
from scipy.spatial.transform import Rotation

from ..worlds import perturbed, random_graph, refused, slopes


def valid():
    return {
        "n": 3,
        "edges": [[0, 1], [1, 2], [0, 2]],
        "measurement": np.zeros((3, 3)),
        "information": np.tile(np.eye(3), (3, 1, 1)),
        "is_odometry": [True, True, False],
    }


def spoiled(key, index, value):
    array = np.array(valid()[key])
    array[index] = value
    return {key: array}


@refused(
    ({"n": 1}, "n is 1"),
    ({"edges": [0, 1, 2]}, "edges: the shape"),
    ({"edges": [[0.0, 1.0], [1.0, 2.0], [0.0, 2.0]]}, "edges: the entries are float64"),
    (spoiled("edges", (1, 1), 3), r"edge 1 is \[1, 3\]; poses are 0 to 2"),
    (spoiled("edges", (2, 0), -1), r"edge 2 is \[-1, 2\]"),
    (spoiled("edges", (1, 1), 1), "edge 1 joins pose 1 to itself"),
    ({"measurement": np.zeros((2, 3))}, "measurement: the shape"),
    (spoiled("measurement", (2, 1), np.nan), r"measurement: the entry at \(2, 1\)"),
    ({"information": np.eye(2)}, "information: the shape"),
    (spoiled("information", (1, 0, 0), np.inf), r"information: the entry at \(1, 0, 0\)"),
    (spoiled("information", (1, 0, 1), 0.5), "information: edge 1 is not symmetric"),
    (spoiled("information", (2, 2, 2), 0.0), "information: edge 2 is not positive definite"),
    ({"is_odometry": [True, True]}, "is_odometry: the shape"),
    ({"is_odometry": [1, 1, 0]}, "is_odometry: the entries"),
    (spoiled("edges", (slice(None),), [[0, 1], [1, 0], [0, 1]]), "pose 2 is not joined"),
)
def test_bad_input_is_refused_by_name_and_number(wrong, message):
    with pytest.raises(ValueError, match=message):
        PoseGraph(**(valid() | wrong))


def test_a_graph_keeps_its_own_copy_and_cannot_be_written_to():
    arguments = valid()
    graph = PoseGraph(**arguments)
    arguments["measurement"][0, 0] = 9.0
    assert graph.measurement[0, 0] == 0.0
    for array in (graph.edges, graph.measurement, graph.information, graph.is_odometry):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


def test_the_residual_is_the_logarithm_of_what_is_left_over(group):
    poses, graph = random_graph(2, group)
    residuals = pose_graph.residuals(graph, poses)
    for (i, j), z, r in zip(graph.edges, graph.measurement, residuals, strict=True):
        unseen = group.compose(group.inverse(z), group.inverse(poses[i]))
        left_over = group.compose(unseen, poses[j])
        np.testing.assert_allclose(r, group.log(left_over), atol=1e-12)


def test_norms_are_whitened_and_the_cost_is_half_the_weighted_sum_of_their_squares(group):
    poses, graph = random_graph(5, group)
    r = pose_graph.residuals(graph, poses)
    whitened = [np.linalg.cholesky(o).T @ e for o, e in zip(graph.information, r, strict=True)]
    u, w = pose_graph.residual_norms(graph, poses), np.linspace(0.0, 1.0, 9)
    np.testing.assert_allclose(u, np.linalg.norm(whitened, axis=1), rtol=1e-12)
    assert pose_graph.cost(graph, poses) == pytest.approx(0.5 * np.sum(u**2), rel=1e-12)
    assert pose_graph.cost(graph, poses, w) == pytest.approx(0.5 * np.sum(w * u**2), rel=1e-12)


@pytest.mark.parametrize("residual", [0.0, 1e-3, 1.0])
def test_jacobians_are_the_derivatives_for_a_perturbation_on_the_right(group, seed, residual):
    poses, graph = random_graph(seed, group, residual=residual)
    for side, jacobian in enumerate(pose_graph.jacobians(graph, poses)):
        for k, end in enumerate(graph.edges[:, side]):

            def residual_of(delta, k=k, end=end):
                return pose_graph.residuals(graph, perturbed(group, poses, end, delta))[k]

            expected = slopes(residual_of, group.DOF)
            np.testing.assert_allclose(jacobian[k], expected, rtol=1e-5, atol=1e-6)


def test_a_matrix_that_is_no_rotation_is_refused_by_number():
    _, graph = random_graph(11, se3)
    for spoil in (1.001 * np.eye(3), np.diag([1.0, 1.0, -1.0])):
        measurement = graph.measurement.copy()
        measurement[4, :, :3] = measurement[4, :, :3] @ spoil
        with pytest.raises(ValueError, match=r"measurement: the left part of entry 4 is not"):
            PoseGraph(6, graph.edges, measurement, graph.information, graph.is_odometry)


def test_selected_edges_are_a_graph_of_their_own(group):
    poses, graph = random_graph(13, group)
    used = np.arange(9) != 7
    rest = select(graph, used)
    np.testing.assert_array_equal(rest.edges, graph.edges[used])
    whole = pose_graph.residual_norms(graph, poses)
    np.testing.assert_array_equal(pose_graph.residual_norms(rest, poses), whole[used])
    with pytest.raises(ValueError, match="is not joined to pose 0"):
        select(graph, np.arange(9) > 6)


def test_indices_in_place_of_a_mask_are_refused():
    _, graph = random_graph(13)
    ones = np.ones(len(graph.edges), dtype=np.intp)
    for choose in (select, pose_graph.unreached):
        with pytest.raises(ValueError, match="give booleans, not indices"):
            choose(graph, ones)
        with pytest.raises(ValueError, match=r"used: the shape is \(4,\)"):
            choose(graph, [3, 4, 6, 7])


def test_graphs_are_equal_where_all_numbers_are_and_odometry_is_found_as_in_a_file(tmp_path):
    _, graph = random_graph(0)
    again = PoseGraph(graph.n, graph.edges, graph.measurement, graph.information)
    same = replace(again, is_odometry=graph.is_odometry)
    assert graph == same and len({graph, same}) == 1 and graph != graph.n
    other = graph.information.copy()
    other[3, 0, 0] *= 2.0
    assert graph != replace(graph, information=other)
    town, _ = manhattan(30, 0, closures=8)
    alone = PoseGraph(town.n, town.edges, town.measurement, town.information[0])
    rs.save(tmp_path / "town.g2o", alone)
    assert alone == town == rs.load(tmp_path / "town.g2o")


def test_drives_become_one_graph_that_closures_join(group):
    drives = [random_graph(seed, group)[1] for seed in range(3)]
    first = np.cumsum([0, *(drive.n for drive in drives)])
    joins = np.stack([first[:2], first[1:3]], axis=1)
    whole = concatenate(drives, joins, [group.identity()] * 2, 4.0 * np.eye(group.DOF))
    assert whole.n == first[-1] and np.array_equal(whole.edges[-2:], joins)
    np.testing.assert_array_equal(whole.measurement[-2:], [group.identity()] * 2)
    np.testing.assert_array_equal(whole.information[-2:], [4.0 * np.eye(group.DOF)] * 2)
    assert not whole.is_odometry[-2:].any()
    start = 0
    for drive, at in zip(drives, first, strict=False):
        rows = slice(start, start := start + len(drive.edges))
        np.testing.assert_array_equal(whole.edges[rows], drive.edges + at)
        np.testing.assert_array_equal(whole.measurement[rows], drive.measurement)
        np.testing.assert_array_equal(whole.is_odometry[rows], drive.is_odometry)
    with pytest.raises(ValueError, match=r"edges: pose .* is not joined to pose 0"):
        concatenate(drives, joins[:1], [group.identity()], np.eye(group.DOF))
    with pytest.raises(ValueError, match="graphs: give at least one, and all in the plane or"):
        concatenate([], joins, [group.identity()] * 2, np.eye(group.DOF))


def test_tables_and_networks_take_the_edges(group):
    _, graph = random_graph(0, group)
    table = pandas.DataFrame(to_columns(graph))
    np.testing.assert_array_equal(table[["x", "y"]], graph.translation[:, :2])
    if group is se3:
        turned = Rotation.from_quat(table[["qx", "qy", "qz", "qw"]].to_numpy()).as_matrix()
        np.testing.assert_allclose(turned, graph.rotation, atol=1e-12)
    else:
        np.testing.assert_array_equal(table["theta"], graph.measurement[:, 2])
    network = networkx.MultiDiGraph(to_rows(graph))
    assert network.number_of_edges() == len(graph.edges) == len(table)
    i, j, columns = to_rows(graph)[2]
    assert columns in network[i][j].values() and columns["x"] == graph.translation[2, 0]
    assert table["sigma_m"][2] == columns["sigma_m"] == deviations(graph)[0][2]
