"""Switchable constraints: Geman–McClure in closed form, and the same map found jointly."""

import numpy as np
import pytest
from robust_slam.errors import Underdetermined
from robust_slam.estimators import StopReason, kernels
from robust_slam.estimators import switched_cost as cost_of
from robust_slam.estimators.switches import dcs, dcs_switch, joint_switchable, switch, switchable
from robust_slam.graphs import Noise, circle, pose_graph
from robust_slam.groups import se2
from robust_slam.problems import LocationProblem, PoseGraphProblem

from ..worlds import cost_never_rises, curving_walk, refused, shaken, slopes

CHI2 = np.array([0.0, 1e-3, 0.1, 1.0, 7.0, 100.0, 1e6])
LAM = 12.0
seeds = pytest.mark.parametrize("seed", range(2))


@pytest.fixture(params=[0.3, 1.0, 40.0])
def lam(request):
    """λ of switchable constraints and Φ of DCS."""
    return request.param


def objective(s, chi2, lam):
    return s**2 * chi2 + lam * (1.0 - s) ** 2


def test_the_closed_form_is_the_minimum_over_s_and_geman_mcclure(lam):
    grid = np.linspace(0.0, 1.0, 10001)
    values = objective(grid[:, None], CHI2, lam)
    np.testing.assert_allclose(switch(CHI2, lam), grid[np.argmin(values, axis=0)], atol=5e-5)
    np.testing.assert_allclose(objective(switch(CHI2, lam), CHI2, lam), cost_of(CHI2, lam))
    assert np.all(cost_of(CHI2, lam) <= values.min(axis=0) * (1.0 + 1e-12))
    kernel = kernels.geman_mcclure(np.sqrt(lam))
    np.testing.assert_allclose(cost_of(CHI2, lam), 2.0 * kernel.rho(np.sqrt(CHI2)), rtol=1e-12)
    np.testing.assert_allclose(switch(CHI2, lam) ** 2, kernel.weight(np.sqrt(CHI2)), rtol=1e-12)


def test_the_switch_of_dcs_is_capped_and_twice_that_of_sc_beyond_phi(lam):
    s = dcs_switch(CHI2, lam)
    inside = lam >= CHI2
    np.testing.assert_array_equal(s[inside], 1.0)
    np.testing.assert_allclose(s[~inside], 2.0 * switch(CHI2, lam)[~inside], rtol=1e-12)
    assert np.all(s[~inside] < 1.0)


def test_dcs_weighs_by_its_switch_squared():
    problem = LocationProblem([0.0, 0.3, -0.2, 0.1, 9.0])
    result = dcs(problem, 2.0)
    assert result.stop is StopReason.CONVERGED
    chi2 = problem.residual_norms(result.x) ** 2
    np.testing.assert_allclose(result.weights, dcs_switch(chi2, 2.0) ** 2, rtol=1e-9)
    np.testing.assert_array_equal(result.weights[:4], 1.0)
    assert result.weights[4] < 0.01


@seeds
def test_poses_and_switches_together_end_where_geman_mcclure_does(group, seed):
    graph, truth = curving_walk(group, seed)
    problem = PoseGraphProblem(graph)
    closed = switchable(problem, LAM, max_iterations=500)
    joint = joint_switchable(problem, LAM)
    assert joint.stop is closed.stop is StopReason.CONVERGED
    np.testing.assert_allclose(joint.x, closed.x, atol=1e-7)
    np.testing.assert_allclose(joint.weights, closed.weights, atol=1e-7)
    assert joint.cost == pytest.approx(closed.cost, rel=1e-10)
    # The three outliers are switched off, and the map is the true one.
    assert joint.weights[-3:].max() < 1e-3 < 1e-2 < joint.weights[:-3].min()
    place = group.translation(joint.x) - group.translation(truth)
    assert np.linalg.norm(place, axis=-1).max() < 0.5


def far(group, seed):
    graph, truth = curving_walk(group, seed)
    rng = np.random.default_rng(seed)
    return graph, shaken(group, truth, 1.0, rng), rng.uniform(size=len(graph.edges))


@seeds
def test_the_joint_cost_is_half_the_papers_never_rises_and_switches_stay_in_the_box(group, seed):
    graph, x0, s0 = far(group, seed)
    result = joint_switchable(PoseGraphProblem(graph), LAM, x0, s0)
    assert cost_never_rises(result, 1e-11) and len(result.history) > 2
    assert result.cost < 0.5 * result.history[0].cost
    for step in result.history:
        assert np.all((step.weights >= 0.0) & (step.weights <= 1.0))
        np.testing.assert_array_equal(step.weights[graph.is_odometry], 1.0)
        chi2 = pose_graph.squared_norms(graph, step.x)
        expected = 0.5 * np.sum(objective(np.sqrt(step.weights), chi2, LAM))
        assert step.cost == pytest.approx(expected, rel=1e-12)


def test_a_damped_step_is_no_rest_however_small(group):
    graph, x0, s0 = far(group, 4)
    problem = PoseGraphProblem(graph)
    result = joint_switchable(problem, LAM, x0, s0, damping=1e9, tol=1e3)
    assert result.stop is StopReason.CONVERGED
    x, s = result.history[-2].x, np.sqrt(result.history[-2].weights)
    plain = joint_switchable(problem, LAM, x, s, damping=0.0, max_iterations=1)
    np.testing.assert_allclose(plain.x, result.x, rtol=1e-9)


def stacked(graph, poses, switches, lam):
    """Every residual of the joint problem, (s √Ω r, √λ (1 − s)), for trusted edges √Ω r."""
    root = np.swapaxes(np.linalg.cholesky(graph.information), 1, 2)
    r = (root @ pose_graph.residuals(graph, poses)[..., None])[..., 0]
    return np.concatenate([(switches[:, None] * r).ravel(), np.sqrt(lam) * (1.0 - switches)])


def dense_step(group, graph, poses, switches, lam):
    """The Gauss–Newton step on all unknowns at once, with numerical derivatives."""
    doubted = np.flatnonzero(~graph.is_odometry)
    free = group.DOF * (graph.n - 1)

    def at(delta):
        motion, turned = np.zeros((graph.n, group.DOF)), switches.copy()
        motion[1:] = delta[:free].reshape(-1, group.DOF)
        turned[doubted] += delta[free:]
        return stacked(graph, group.compose(poses, group.exp(motion)), turned, lam)

    size = free + doubted.size
    delta = np.linalg.lstsq(slopes(at, size), -at(np.zeros(size)), rcond=None)[0]
    turn = np.zeros(switches.size)
    turn[doubted] = delta[free:]
    return delta[:free].reshape(-1, group.DOF), turn


@seeds
def test_eliminating_the_switches_leaves_the_step_of_the_dense_joint_problem(group, seed):
    graph, truth = curving_walk(group, seed, n=8, closures=3, outliers=2)
    rng = np.random.default_rng(seed)
    poses = shaken(group, truth, 0.005, rng)
    # A λ of the size of the χ² of the outliers: their switches move, and stay inside the box.
    lam = float(np.median(pose_graph.squared_norms(graph, poses)[-2:]))
    switches = np.where(graph.is_odometry, 1.0, rng.uniform(0.4, 0.6, len(graph.edges)))
    motion, turn = dense_step(group, graph, poses, switches, lam)
    problem = PoseGraphProblem(graph)
    result = joint_switchable(problem, lam, poses, switches, damping=0.0, max_iterations=1)
    step, moved = result.history[1], switches + turn
    assert np.all((moved[-2:] > 0.0) & (moved[-2:] < 1.0) & (turn[-2:] != 0.0))
    np.testing.assert_allclose(group.log(group.between(poses, step.x))[1:], motion, atol=1e-6)
    np.testing.assert_allclose(np.sqrt(step.weights), np.clip(moved, 0.0, 1.0), atol=1e-6)


@seeds
def test_a_switch_that_is_off_comes_back(group, seed):
    # A Jacobian s·r in the place of r is 0 at s = 0, and the switch could never move.
    graph, _ = curving_walk(group, seed)
    problem = PoseGraphProblem(graph)
    on = joint_switchable(problem, LAM)
    off = joint_switchable(problem, LAM, problem.guess, np.zeros(len(graph.edges)))
    assert off.history[0].weights[~graph.is_odometry].max() == 0.0
    np.testing.assert_allclose(off.weights, on.weights, atol=1e-7)
    np.testing.assert_allclose(off.x, on.x, atol=1e-7)


def test_poses_that_hang_on_switches_that_are_off_are_not_determined():
    graph, _ = curving_walk(se2, 0)
    m = len(graph.edges)
    problem = PoseGraphProblem(graph, trusted=np.zeros(m, dtype=bool))
    with pytest.raises(Underdetermined):
        joint_switchable(problem, LAM, problem.guess, np.zeros(m))


@refused(
    ({"lam": 0.0}, "lam is 0.0"),
    ({"lam": np.nan}, "lam is nan"),
    ({"x0": np.zeros((2, 3))}, "x0: the shape"),
    ({"s0": [1.0]}, "s0: the shape"),
    ({"s0": np.full(26, 1.5)}, "s0: an entry is outside"),
    ({"damping": -1.0}, "damping is -1.0"),
    ({"damping": np.inf}, "damping is inf"),
    ({"tol": -1.0}, "tol is -1.0"),
    ({"max_iterations": 0}, "max_iterations is 0"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    graph, _ = curving_walk(se2, 0)
    with pytest.raises(ValueError, match=message):
        joint_switchable(PoseGraphProblem(graph), **({"lam": LAM} | wrong))


@pytest.mark.parametrize("function", [switch, cost_of, dcs_switch])
@pytest.mark.parametrize(
    ("chi2", "scale", "told"),
    [(-1.0, 1.0, "chi2: an entry"), (np.nan, 1.0, "chi2: an entry"), (1.0, -1.0, "-1.0; give")],
)
def test_a_switch_refuses_what_is_no_squared_norm(function, chi2, scale, told):
    with pytest.raises(ValueError, match=told):
        function([0.0, chi2], scale)


@pytest.mark.parametrize("method", [switchable, dcs])
def test_a_threshold_of_0_is_refused_by_name(method):
    with pytest.raises(ValueError, match=r"(lam|phi) is 0.0; give"):
        method(LocationProblem([0.0]), 0.0)


def test_a_map_that_fits_exactly_is_at_rest():
    graph, truth = circle(20, np.random.default_rng(3), laps=2, closures=5, noise=Noise(scale=0.0))
    result = joint_switchable(PoseGraphProblem(graph), 1.0)
    assert result.stop is StopReason.CONVERGED
    np.testing.assert_allclose(result.x[:, :2], truth[:, :2], atol=1e-9)
