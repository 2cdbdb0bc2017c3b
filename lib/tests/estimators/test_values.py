"""Kernels are values, huge residuals are no error, and a graph is as good as a problem."""

import pickle

import numpy as np
import pytest
import robust_slam as rs
from robust_slam.consistency.pairwise import pcm
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.kernels import KERNELS, cauchy
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.switches import dcs, joint_switchable, switchable
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.generate import manhattan
from robust_slam.graphs.odometry import dead_reckoning, sessions, spanning_tree
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import LocationProblem, PoseGraphProblem

from ..worlds import refused, with_outliers

HUGE = np.array([0.0, 1e-300, 1e-8, 1.0, 1e100, 1.4e154, 1e200, 1e300])


@pytest.mark.parametrize("name", KERNELS)
def test_kernels_of_one_name_and_scale_are_equal_and_can_be_pickled(name):
    kernel, same, other = KERNELS[name](2.0), KERNELS[name](2.0), KERNELS[name](3.0)
    assert kernel == same and hash(kernel) == hash(same) and kernel != other
    copy = pickle.loads(pickle.dumps(kernel))
    assert copy == kernel
    np.testing.assert_array_equal(copy.rho([1.0, 5.0]), kernel.rho([1.0, 5.0]))
    assert len({kernel, same, other}) == 2


@pytest.mark.parametrize("name", [name for name in KERNELS if name != "squared"])
@pytest.mark.filterwarnings("error")
def test_no_residual_is_too_large_for_a_kernel(name):
    kernel = KERNELS[name](2.0)
    rho, psi, weight = kernel.rho(HUGE), kernel.psi(HUGE), kernel.weight(HUGE)
    assert np.all(np.isfinite(rho)) and np.all(np.diff(rho) >= 0.0)
    assert np.all(np.isfinite(psi)) and np.all(np.diff(weight) <= 0.0)


@pytest.fixture(scope="module")
def town():
    return with_outliers(manhattan, 80, 0, 12, closures=30)[0]


SOLVERS = {
    "gnc": gnc,
    "irls": lambda given, **more: irls(given, cauchy(3.0), **more),
    "switchable": switchable,
    "dcs": dcs,
}


@pytest.mark.parametrize("name", SOLVERS)
def test_a_graph_is_solved_from_dead_reckoning_in_single_steps(town, name):
    problem = PoseGraphProblem(town, tol=1e-6, steps=1)
    ours = SOLVERS[name](town)
    by_hand = SOLVERS[name](problem, x0=problem.guess, tol=1e-6)
    np.testing.assert_array_equal(ours.poses, by_hand.poses)
    assert ours.stop is by_hand.stop
    assert ours.stop in (StopReason.BINARY_WEIGHTS, StopReason.CONVERGED)


def test_a_threshold_follows_from_the_probability(town):
    by_norm = gnc(town, chi_square_threshold(0.9, 3))
    np.testing.assert_array_equal(gnc(town, probability=0.9).weights, by_norm.weights)
    location = LocationProblem([0.0, 0.1, 9.0])
    by_norm = gnc(location, chi_square_threshold(0.99, 1))
    np.testing.assert_array_equal(gnc(location).weights, by_norm.weights)


def test_what_is_neither_a_graph_nor_a_problem_is_refused():
    with pytest.raises(TypeError, match="problem is a list; give a PoseGraph, or a problem"):
        gnc([1, 2, 3], 1.0)


def test_a_watcher_sees_every_step(town):
    seen = []
    result = gnc(town, watch=seen.append)
    assert [step.mu for step in seen] == [s.mu for s in result.history[1:] if s.mu][: len(seen)]
    assert len(seen) >= 5


def test_a_loop_that_cannot_go_on_returns_what_it_has():
    """Two sessions, joined by closures that contradict each other: none is trusted."""
    graph = PoseGraph(
        4,
        [[0, 1], [2, 3], [0, 2], [1, 3], [0, 3]],
        [[1, 0, 0], [1, 0, 0], [0, 5, 1.0], [9, -4, 2.0], [-7, 1, -2.0]],
        [100.0 * np.eye(3)] * 5,
        [True, True, False, False, False],
    )
    far = np.array([[0.0, 0, 0], [1, 0, 0], [50, 50, 0], [51, 50, 0]])
    result = gnc(graph, 0.01, x0=far, mu0=1e6)
    assert result.stop is StopReason.ALL_REJECTED
    np.testing.assert_array_equal(result.poses, far)
    assert len(result.history) == 2


def test_joint_solvers_take_a_graph_too(town):
    problem = PoseGraphProblem(town)
    joint = joint_switchable(town, 9.0)
    np.testing.assert_array_equal(joint.poses, joint_switchable(problem, 9.0, problem.guess).poses)
    with pytest.raises(TypeError, match="is a LocationProblem; give a PoseGraph or a Pose"):
        joint_switchable(LocationProblem([1.0]), 9.0)


@pytest.mark.parametrize("call", [pcm, rs.solve, dead_reckoning, sessions, spanning_tree])
def test_a_problem_in_place_of_a_graph_is_told_at_once(town, call):
    with pytest.raises(TypeError, match="graph is a PoseGraphProblem; give a PoseGraph, its attr"):
        call(PoseGraphProblem(town))


@refused(
    *(((p, 3), "probability is") for p in (0.0, 1.0, -0.1, 99.0, float("nan"))),
    *(((0.99, d), "dimension is") for d in (0, -1, 1.5)),
)
def test_a_threshold_of_what_is_no_probability_or_dimension_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        chi_square_threshold(*wrong)
