"""Max-mixtures: the normaliser decides, each mode stays a square, and ambiguity resolves."""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest
from robust_slam.descent.undamped import gauss_newton
from robust_slam.estimators.mixtures import (
    Mode,
    NullHypothesis,
    alternative,
    max_mixture,
    max_mixture_modes,
)
from robust_slam.estimators.result import StopReason
from robust_slam.graphs import PoseGraph, pose_graph
from robust_slam.problems import PoseGraphProblem
from scipy.stats import multivariate_normal

from tests.lib.worlds import cost_never_rises, curving_walk, refused

seeds = pytest.mark.parametrize("seed", range(4))


def line(z, sigma):
    """Two steps of odometry and one closure on the x axis, where residuals are linear."""
    measurement = np.zeros((3, 3))
    measurement[:, 0] = z
    information = np.eye(3) / np.square(sigma)[:, None, None]
    return PoseGraph(3, [[0, 1], [1, 2], [0, 2]], measurement, information, [True, True, False])


def broad(graph, probability, ratio):
    """The mode of an outlier: the same measurement with a deviation that is larger."""
    return Mode(probability, graph.measurement, graph.information / ratio**2)


@pytest.mark.parametrize(("pi_in", "switch"), [(0.9, 3.015050), (0.5, 2.156777), (0.99, 3.732929)])
def test_the_modes_of_the_lesson_change_where_the_normalisers_say(pi_in, switch):
    rule = NullHypothesis(pi_in, ratio=10.0, dimension=1)
    assert rule.switch_norm == pytest.approx(switch, abs=1e-6)
    around = rule.switch_norm + np.array([-1e-9, 1e-9])
    np.testing.assert_array_equal(rule.weights(around, None), [1.0, 0.01])


@pytest.mark.parametrize("dimension", [1, 3, 6])
@pytest.mark.parametrize("pi_in", [0.05, 0.5, 0.9])
@pytest.mark.parametrize("ratio", [2.0, 10.0])
def test_the_cost_is_the_logarithm_of_the_larger_mode(dimension, pi_in, ratio):
    rule = NullHypothesis(pi_in, ratio, dimension)
    covariance = np.eye(dimension)
    inlier = multivariate_normal(np.zeros(dimension), covariance)
    outlier = multivariate_normal(np.zeros(dimension), ratio**2 * covariance)

    for r in np.random.default_rng(dimension).normal(size=(20, dimension)) * 4.0:
        modes = [log(pi_in) + inlier.logpdf(r), log(1.0 - pi_in) + outlier.logpdf(r)]
        zero = log(pi_in) + inlier.logpdf(np.zeros(dimension))
        norm = np.array([np.linalg.norm(r)])
        assert rule.cost(norm) == pytest.approx(zero - max(modes), abs=1e-10)
        wins = modes[0] >= modes[1]
        assert rule.weights(norm, None)[0] == pytest.approx(1.0 if wins else ratio**-2)


@seeds
def test_the_null_hypothesis_takes_the_outliers_and_never_raises_the_cost(group, seed):
    graph, _ = curving_walk(group, seed, closures=5)
    problem = PoseGraphProblem(graph)
    result = max_mixture(problem, 0.9, 10.0, group.DOF)
    assert cost_never_rises(result)
    assert result.stop is StopReason.CONVERGED
    np.testing.assert_array_equal(result.weights[-3:], 0.01)
    np.testing.assert_array_equal(result.weights[graph.is_odometry], 1.0)
    expected = gauss_newton(graph, problem.guess, result.weights)
    np.testing.assert_allclose(result.x, expected, atol=1e-7)


@seeds
def test_the_null_hypothesis_as_a_mode_ends_where_the_rule_does(group, seed):
    graph, _ = curving_walk(group, seed, closures=5)
    problem = PoseGraphProblem(graph)
    rule = max_mixture(problem, 0.9, 10.0, group.DOF, problem.guess)
    modes = max_mixture_modes(problem, [broad(graph, 0.1, 10.0)])
    assert modes.stop is rule.stop is StopReason.CONVERGED
    np.testing.assert_allclose(modes.x, rule.x, atol=1e-7)
    np.testing.assert_array_equal(modes.modes, rule.weights < 1.0)
    assert modes.cost == pytest.approx(rule.cost, rel=1e-9)


def ambiguous(group, seed):
    """Each closure says here or there: the true place and the place of another pose."""
    graph, truth = curving_walk(group, seed, outliers=0)
    rng = np.random.default_rng(100 + seed)
    closures = np.flatnonzero(~graph.is_odometry)
    i, j = graph.edges[closures].T
    other = (j + rng.integers(3, graph.n - 3, j.size)) % graph.n
    readings = np.stack([graph.measurement[closures], group.between(truth[i], truth[other])])
    swapped = rng.random(closures.size) < 0.5
    first = swapped.astype(int)
    measurement = graph.measurement.copy()
    measurement[closures] = readings[first, np.arange(j.size)]
    unsaid = readings[1 - first, np.arange(j.size)]
    return graph, replace(graph, measurement=measurement), closures, unsaid, swapped


@seeds
def test_of_two_readings_of_each_closure_it_finds_the_true_one(group, seed):
    true, graph, closures, unsaid, swapped = ambiguous(group, seed)
    problem = PoseGraphProblem(graph)
    result = max_mixture_modes(problem, [alternative(graph, closures, 0.5, unsaid)])
    assert result.stop is StopReason.CONVERGED
    assert swapped.any() and not swapped.all()
    np.testing.assert_array_equal(result.modes[closures], swapped)
    np.testing.assert_array_equal(result.modes[graph.is_odometry], 0)
    np.testing.assert_allclose(result.x, gauss_newton(true, problem.guess), atol=1e-7)
    # Both readings are equally likely and equally sharp, so only residuals cost.
    assert result.cost == pytest.approx(pose_graph.cost(true, result.x), rel=1e-12)


def test_each_recorded_step_has_the_likeliest_modes_and_their_cost(group):
    _, graph, closures, unsaid, _ = ambiguous(group, 1)
    readings, wide = alternative(graph, closures, 0.4, unsaid), broad(graph, 0.1, 20.0)
    history = max_mixture_modes(PoseGraphProblem(graph), [readings, wide]).history
    assert len(history) > 2
    for step in history:
        costs = np.full((3, len(graph.edges)), np.inf)
        for k, (chance, mode) in enumerate([(0.5, graph), (0.4, readings), (0.1, wide)]):
            said = replace(graph, measurement=mode.measurement, information=mode.information)
            # −log(π |Λ|^½) against that of mode 0, whose π is 1/2.
            offset = -np.log(chance * np.sqrt(np.linalg.det(mode.information)))
            offset += np.log(0.5 * np.sqrt(np.linalg.det(graph.information)))
            costs[k] = 0.5 * pose_graph.squared_norms(said, step.x) + offset
        costs[1:, graph.is_odometry] = np.inf
        np.testing.assert_array_equal(step.modes, np.argmin(costs, axis=0))
        assert step.cost == pytest.approx(np.sum(np.min(costs, axis=0)), rel=1e-9)


@pytest.mark.parametrize(("probability", "mode", "x2"), [(0.4, 0, 2.1), (0.6, 1, 1.9)])
def test_between_readings_that_fit_alike_the_likelier_one_wins(probability, mode, x2):
    # The odometry says 2 with σ² = 2·0.1², each reading is 0.1 off with σ² = 0.1².
    graph = line([1.0, 1.0, 2.1], [0.1, 0.1, 0.1])
    low = alternative(graph, [2], probability, [[1.9, 0.0, 0.0]])
    result = max_mixture_modes(PoseGraphProblem(graph), [low])
    assert result.modes.tolist() == [0, 0, mode]
    assert result.x[2, 0] == pytest.approx(2.0 + (x2 - 2.0) * 2.0 / 3.0, rel=1e-9)
    # χ² = 0.1²/(0.02 + 0.01) = 1/3, and mode 1 costs log(π_0/π_1) more than mode 0.
    offset = log((1.0 - probability) / probability) if mode else 0.0
    assert result.cost == pytest.approx(1.0 / 6.0 + offset, rel=1e-9)


def test_probability_0_means_that_there_is_no_such_reading():
    graph = line([1.0, 1.0, 50.0], [0.1, 0.1, 0.1])
    true = replace(graph, measurement=[[1.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0]])
    for chance, mode in ((0.0, 0), (1e-9, 1)):
        other = Mode([0.0, 0.0, chance], true.measurement, graph.information)
        result = max_mixture_modes(PoseGraphProblem(graph), [other])
        assert result.modes.tolist() == [0, 0, mode]


def test_trusted_edges_know_no_other_reading():
    graph = line([1.0, 1.0, 50.0], [0.1, 0.1, 0.1])
    problem = PoseGraphProblem(graph, trusted=[True, True, True])
    result = max_mixture_modes(problem, [alternative(graph, [2], 0.999, [[2.0, 0.0, 0.0]])])
    assert result.modes.tolist() == [0, 0, 0]


def test_it_is_not_at_rest_while_a_mode_changes():
    # From x₂ = 5 the second reading is the likelier one; the odometry knows better.
    graph = line([1.0, 1.0, 2.0], [0.01, 0.01, 1.0])
    five = alternative(graph, [2], 0.5, [[5.0, 0.0, 0.0]])
    x0 = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0]]
    result = max_mixture_modes(PoseGraphProblem(graph), [five], x0, tol=1e9)
    assert [step.modes[2] for step in result.history] == [1, 0, 0]
    assert result.stop is StopReason.CONVERGED
    assert result.x[2, 0] == pytest.approx(2.0, rel=1e-12)


GRAPH = line([1.0, 1.0, 2.0], [0.1, 0.1, 0.1])
SAID, INFORMATION = GRAPH.measurement, GRAPH.information


@refused(
    ([Mode(0.1, SAID[:2], INFORMATION)], r"alternatives\[0\]: measurement: the shape"),
    ([Mode(0.1, SAID, -INFORMATION)], r"alternatives\[0\]: information: edge 0"),
    ([Mode([0.1], SAID, INFORMATION)], r"alternatives\[0\].probability: the shape"),
    ([Mode(np.nan, SAID, INFORMATION)], r"alternatives\[0\].probability: the entry"),
    ([Mode(-0.1, SAID, INFORMATION)], r"alternatives\[0\].probability: entry 0 is below"),
    ([Mode(0.5, SAID, INFORMATION)] * 2, "the probabilities of edge 2 leave nothing"),
)
def test_a_mode_that_does_not_fit_is_refused_by_number(wrong, message):
    with pytest.raises(ValueError, match=message):
        max_mixture_modes(PoseGraphProblem(GRAPH), wrong)


@refused(
    ({"x0": np.zeros((2, 3))}, "x0: the shape"),
    ({"tol": -1.0}, "tol is -1.0"),
    ({"max_iterations": 0}, "max_iterations is 0"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        max_mixture_modes(PoseGraphProblem(GRAPH), [], **wrong)


@refused(
    (([3], 0.5, np.zeros((1, 3))), "edges: an entry is outside 0 to 2"),
    (([-1], 0.5, np.zeros((1, 3))), "edges: an entry is outside 0 to 2"),
    (([True, False, True], 0.5, np.zeros((2, 3))), "edges: give the numbers of edges"),
    (([2], 0.5, np.zeros((2, 3))), "measurement: the shape"),
)
def test_an_alternative_for_an_edge_that_is_not_there_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        alternative(GRAPH, *wrong)


@refused(
    ((0.0, 10.0, 1), "pi_in is 0.0"),
    ((1.0, 10.0, 1), "pi_in is 1.0"),
    ((np.nan, 10.0, 1), "pi_in is nan"),
    ((0.9, 1.0, 1), "ratio is 1.0"),
    ((0.9, np.inf, 1), "ratio is inf"),
    ((0.9, 10.0, 0), "dimension is 0"),
    ((0.9, 10.0, 1.5), "dimension is 1.5"),
)
def test_a_null_hypothesis_out_of_range_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        NullHypothesis(*wrong)
