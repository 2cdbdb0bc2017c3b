"""The loop: what it records, what it leaves to the rule, and when it stops."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from robust_slam.estimators.loop import reweight
from robust_slam.estimators.result import StopReason
from robust_slam.problems import LocationProblem, chain

from ..worlds import refused

Z = np.array([0.0, 0.0, 0.0, 10.0])


@dataclass
class HalvingRule:
    """A rule with a state: weight mu for a residual above 1, and mu is halved each step."""

    seen: list[int] = field(default_factory=list)

    def start(self, norms):
        return 1.0

    def weights(self, norms, state):
        self.seen.append(norms.size)
        return np.where(norms > 1.0, state, 1.0)

    def next(self, state, weights, moved):
        return state / 2.0

    def cost(self, norms):
        return float(np.sum(norms))

    def finished(self, weights, state, settled):
        return StopReason.CONVERGED if state <= 0.25 else None


class SevereRule(HalvingRule):
    """Rejects everything at the second step."""

    def weights(self, norms, state):
        return np.full(norms.shape, 1.0 if state == 1.0 else 0.0)


class SettlingRule(HalvingRule):
    def weights(self, norms, state):
        return np.ones_like(norms)

    def finished(self, weights, state, settled):
        return StopReason.CONVERGED if settled else None


def test_the_history_starts_at_least_squares_with_weights_1_and_no_mu():
    start = reweight(LocationProblem(Z), HalvingRule()).history[0]
    assert (start.x, start.cost, start.mu) == (2.5, 15.0, None)
    np.testing.assert_array_equal(start.weights, np.ones(4))
    assert reweight(LocationProblem(Z), HalvingRule(), 7.0).history[0].x == 7.0


def test_the_rule_sees_the_untrusted_alone_and_the_trusted_cost_half_their_square():
    rule = HalvingRule()
    trusted = np.array([True, False, False, True])
    result = reweight(LocationProblem(Z, trusted=trusted), rule)
    assert set(rule.seen) == {2}
    assert all(np.all(step.weights[trusted] == 1.0) for step in result.history)
    for step in reweight(LocationProblem(Z, 2.0, trusted), HalvingRule()).history:
        u = np.abs(Z - step.x) / 2.0
        expected = u[~trusted].sum() + (u[trusted] ** 2).sum() / 2
        assert step.cost == pytest.approx(expected, rel=1e-14)


def test_when_all_is_rejected_the_last_x_is_kept_unless_the_trusted_determine_it():
    result = reweight(LocationProblem(Z), SevereRule())
    assert (result.stop, result.x) == (StopReason.ALL_REJECTED, 2.5)
    np.testing.assert_array_equal(result.weights, np.zeros(4))
    assert result.history[-1].mu == 0.5
    result = reweight(LocationProblem(Z, trusted=[True, True, False, False]), SevereRule())
    assert (result.stop, result.x) == (StopReason.CONVERGED, 0.0)


def test_a_part_that_is_cut_off_ends_the_loop_with_what_it_has():
    class CuttingRule(HalvingRule):
        def weights(self, norms, state):
            return np.array([1.0, 0.0])

    result = reweight(chain(3, [0, 1], [1, 2], [1.0, 1.0]), CuttingRule())
    assert result.stop is StopReason.UNDERDETERMINED
    np.testing.assert_allclose(result.x, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(result.weights, [1.0, 0.0])


def test_settled_means_that_no_residual_moved_relative_to_1_plus_itself():
    result = reweight(LocationProblem(Z), SettlingRule(), 9.0)
    assert [step.x for step in result.history] == [9.0, 2.5, 2.5]
    loose = reweight(LocationProblem(Z), SettlingRule(), 2.6, tol=0.1)
    tight = reweight(LocationProblem(Z), SettlingRule(), 2.6, tol=0.01)
    assert (len(loose.history), len(tight.history)) == (2, 3)


@refused(
    ({"x0": float("nan")}, "x0"),
    ({"tol": -1.0}, "tol"),
    ({"tol": float("nan")}, "tol"),
    ({"max_iterations": 0}, "max_iterations"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        reweight(LocationProblem(Z), HalvingRule(), **wrong)
