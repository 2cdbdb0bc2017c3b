"""The compiled kernels give what numpy gives, which is the reference, and are chosen by size."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from robust_slam.descent import normal_equations
from robust_slam.descent.damped import levenberg_marquardt
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.sparse import choice
from robust_slam.descent.start import chordal
from robust_slam.descent.undamped import gauss_newton
from robust_slam.estimators import gnc
from robust_slam.graphs import add_random_closures, spanning_tree
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.descent.sparse.matrices import as_dense, need_numba
from tests.lib.worlds import assert_same_poses, measured, random_graph, random_poses, random_twists

pytestmark = pytest.mark.long


@pytest.fixture
def both():
    """Normal equations of a graph, by numpy and compiled."""
    need_numba()
    return lambda graph: [NormalEquations(graph, compiled=which) for which in (False, True)]


@pytest.fixture
def compiled_from(monkeypatch):
    """Sets the number of edges from which kernels are compiled."""
    return lambda edges: monkeypatch.setenv(choice.COMPILED_FROM, str(edges))


def some_weights(m, seed):
    """Weights from 0 to 1, a quarter of them 0."""
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, 1.0, m) * (rng.uniform(size=m) > 0.25)


def assert_close(one, other, share=1e-12):
    """The numbers agree up to a share of the largest."""
    np.testing.assert_allclose(one, other, rtol=0.0, atol=share * np.abs(other).max())


def systems(equations, poses, weights):
    """The matrix of each as a dense one, and the gradient."""
    found = []
    for each in equations:
        hessian, gradient = each.system(each.at(poses, weights), weights)
        found.append((as_dense(each.pattern, hessian), gradient))
    return found


@pytest.mark.parametrize("residual", [1e-3, 0.3, 3.0])
def test_norms_costs_and_systems_are_those_of_numpy(both, group, seed, residual):
    poses, graph = random_graph(seed, group, n=30, m=90, residual=residual)
    equations, weights = both(graph), some_weights(90, seed)
    # A residual is a difference of poses, whose rounding is a larger share of a smaller one.
    share = max(1e-12, 1e-14 / residual)
    assert_close(*(each.residual_norms(poses) for each in equations[::-1]), share)
    assert_close(*(each.at(poses, weights).cost for each in equations[::-1]), share)
    by_numpy, compiled = systems(equations, poses, weights)
    for one, other in zip(compiled, by_numpy, strict=True):
        assert_close(one, other, share)


@pytest.mark.parametrize("angle", [0.0, 1e-8, 0.049, 0.051, 0.299, 0.301, 2.0, 2.2, 3.1, 3.14159])
def test_they_agree_for_every_angle_of_a_residual(both, group, seed, angle):
    rng = np.random.default_rng(seed)
    error = random_twists(group, 12, rng)
    turn = rng.normal(size=(12, group.DOF - group.DIMENSION))
    error[:, group.DIMENSION :] = angle * turn / np.linalg.norm(turn, axis=1, keepdims=True)
    poses = random_poses(group, 13, rng)
    edges = np.stack([np.arange(12), np.arange(1, 13)], axis=1)
    graph = measured(group, poses, edges, error, np.eye(group.DOF))
    equations, ones = both(graph), np.ones(12)
    # Near a turn of half a circle the angle is known to fewer digits.
    share = 1e-9 if angle > 3.0 else 1e-12
    assert_close(*(each.residual_norms(poses) for each in equations[::-1]), share)
    by_numpy, compiled = systems(equations, poses, ones)
    for one, other in zip(compiled, by_numpy, strict=True):
        assert_close(one, other, share)


@pytest.mark.parametrize("size", [0.0, 1e-9, 0.1, 2.0])
def test_poses_are_retracted_as_numpy_does(both, group, seed, size):
    poses, graph = random_graph(seed, group)
    step = size * np.random.default_rng(seed).normal(size=(graph.n, group.DOF))
    by_numpy, compiled = (each.retract(poses, step) for each in both(graph))
    assert_close(compiled, by_numpy)


def test_norms_are_those_of_the_poses_given_also_when_they_changed_in_place(both, group):
    poses, graph = random_graph(0, group)
    by_numpy, compiled = both(graph)
    moved = poses.copy()
    assert_close(compiled.residual_norms(moved), by_numpy.residual_norms(poses))
    moved[2:] = group.compose(poses[2:], group.exp(np.full(group.DOF, 0.1)))
    assert_close(compiled.residual_norms(moved), by_numpy.residual_norms(moved))
    assert_close(compiled.residual_norms(poses), by_numpy.residual_norms(poses))


def test_a_robust_solve_computes_the_norms_of_each_map_once(compiled_from, monkeypatch):
    need_numba()
    from robust_slam.descent.sparse import edges

    compiled_from(0)
    graph, _ = manhattan(60, np.random.default_rng(0), closures=20)
    poses, computed = [], edges._norms_plane

    def counted(*arguments):
        poses.append(arguments[-1])
        return computed(*arguments)

    monkeypatch.setattr(edges, "_norms_plane", counted)
    # Equations over a part of the edges compute the norms of these again.
    monkeypatch.setattr(normal_equations, "_FULL_SHARE", 0.0)
    gnc(add_random_closures(graph, 10, np.random.default_rng(1))[0])
    maps = {one.tobytes() for one in poses}
    assert len(maps) > 5
    assert len(poses) == len(maps)


@pytest.mark.parametrize("make", [manhattan, sphere], ids=["plane", "space"])
@pytest.mark.parametrize("descend", [gauss_newton, levenberg_marquardt])
def test_descents_end_in_the_same_minimum(compiled_from, make, descend):
    need_numba()
    graph, _ = make(200, np.random.default_rng(0), closures=100)
    by_numpy = descend(graph, chordal(graph))
    compiled_from(0)
    assert_same_poses(graph.group, descend(graph, chordal(graph)), by_numpy, 1e-6)


@pytest.mark.parametrize("make", [manhattan, sphere], ids=["plane", "space"])
def test_gnc_rejects_the_same_closures_and_keeps_to_the_compiled_way(
    compiled_from, monkeypatch, make
):
    need_numba()
    clean, _ = make(150, np.random.default_rng(1), closures=60)
    graph, _ = add_random_closures(clean, 40, np.random.default_rng(2))
    by_numpy = gnc(graph, 4.0)
    compiled_from(len(graph.edges))
    # With fewer edges the rule alone would choose numpy.
    monkeypatch.setattr(normal_equations, "_FULL_SHARE", 0.999)
    compiled = gnc(graph, 4.0)
    np.testing.assert_array_equal(compiled.weights, by_numpy.weights)
    assert_same_poses(graph.group, compiled.x, by_numpy.x, 1e-6)
    equations = NormalEquations(graph)
    assert equations.compiled and equations.restricted(compiled.weights)[0].compiled


def test_compiled_code_is_not_given_too_few_numbers(both, group):
    poses, graph = random_graph(0, group)
    _, compiled = both(graph)
    ones = np.ones(len(graph.edges))
    hessian, gradient = compiled.system(compiled.at(poses, ones), ones)
    with pytest.raises(ValueError, match="poses: the shape"):
        compiled.residual_norms(poses[1:])
    with pytest.raises(ValueError, match="blocks: the shape"):
        compiled.pattern.solve(hessian[1:], gradient)
    with pytest.raises(ValueError, match="blocks: the shape"):
        compiled.pattern.factorise(hessian[1:])


def test_equations_can_be_pickled(both, group):
    poses, graph = random_graph(4, group)
    ones = np.ones(len(graph.edges))
    for each in both(graph):
        again = pickle.loads(pickle.dumps(each))
        steps = (one.step(one.at(poses, ones), ones) for one in (each, again))
        np.testing.assert_array_equal(*steps)


def test_large_graphs_are_compiled_and_small_ones_are_not(compiled_from, monkeypatch):
    monkeypatch.delenv(choice.COMPILED_FROM, raising=False)
    monkeypatch.setattr(choice, "has_numba", lambda: True)
    chosen = [choice.use_compiled(edges) for edges in (1, choice.LARGE - 1, choice.LARGE)]
    assert chosen == [False, False, True]
    compiled_from(10)
    assert [choice.use_compiled(edges) for edges in (9, 10)] == [False, True]


def test_a_number_of_edges_that_is_none_is_refused(compiled_from):
    compiled_from("always")
    with pytest.raises(ValueError, match="ROBUST_SLAM_COMPILED_FROM is 'always'"):
        choice.use_compiled(1)


def test_without_numba_all_graphs_are_solved_by_numpy(compiled_from, monkeypatch):
    monkeypatch.setattr(choice, "has_numba", lambda: False)
    compiled_from(0)
    _, graph = random_graph(0)
    assert isinstance(graph, PoseGraph) and not NormalEquations(graph).compiled
    gauss_newton(graph, spanning_tree(graph))


SMALL = """
import sys
import numpy as np
import robust_slam as rs
rs.solve(rs.graphs.manhattan(100, np.random.default_rng(0), closures=20)[0])
assert "numba" not in sys.modules
"""


def test_a_small_graph_does_not_load_numba():
    environment = {k: v for k, v in os.environ.items() if k != choice.COMPILED_FROM}
    subprocess.run([sys.executable, "-c", SMALL], check=True, env=environment)
