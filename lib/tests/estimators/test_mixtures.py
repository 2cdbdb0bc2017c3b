"""Max-mixtures: the normaliser decides, and each mode stays a square."""

from math import log

import numpy as np
import pytest
from robust_slam.descent.minimise import gauss_newton
from robust_slam.estimators.mixtures import NullHypothesis, max_mixture
from robust_slam.estimators.result import StopReason
from robust_slam.problems import PoseGraphProblem
from scipy.stats import multivariate_normal

from ..worlds import cost_never_rises, curving_walk, refused


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


@pytest.mark.parametrize("seed", range(4))
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
