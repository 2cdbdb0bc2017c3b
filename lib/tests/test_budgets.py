"""A computation whose time is used up returns the best so far, and says so."""

import itertools
from math import inf

import numpy as np
import pytest
import robust_slam as rs
from robust_slam.certificates.newton import Stop
from robust_slam.certificates.optimality import Verdict, unproven
from robust_slam.consistency.cliques import max_clique
from robust_slam.consistency.pairwise import pcm
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.solver import Support
from robust_slam.solver.candidates import Sparing

from .worlds import refused, slipped

CLEAN, TRUTH = manhattan(60, 0, closures=20)
GRAPH, WRONG = add_random_closures(CLEAN, 20, 1, poses=TRUTH)
SPHERE = add_random_closures(sphere(80, 0)[0], 20, 1)[0]


@pytest.fixture
def ticking(monkeypatch):
    """A CPU clock that is a second later each time it is read."""
    seconds = itertools.count()
    monkeypatch.setattr("time.process_time", lambda: float(next(seconds)))


@pytest.mark.parametrize("graph", [SPHERE, CLEAN], ids=["space", "clean"])
def test_without_time_there_is_a_map_and_a_reason(graph):
    answer = rs.solve(graph, max_seconds=0.0)
    assert answer.stop is StopReason.TIME_LIMIT
    assert answer.certificate.stop is Stop.TIME_LIMIT
    assert answer.certificate.verdict is Verdict.NOT_STATIONARY
    assert answer.certificate.lower_bound == 0.0 < answer.certificate.cost
    assert np.all(np.isfinite(answer.poses))
    assert np.all(answer.kept[graph.is_odometry])
    assert "The time limit ended the computation" in answer.summary()
    assert answer.support is Support.WEAK and "Odometry alone" not in answer.summary()


@pytest.mark.parametrize("seconds", [0, 1, 2, 4, 7, 10, 15, 30, 60, 150, 300])
def test_whenever_the_time_ends_there_is_a_map_with_a_reason(ticking, seconds):
    answer = rs.solve(GRAPH, max_seconds=seconds)
    certified = answer.certificate.verdict is Verdict.CERTIFIED
    stopped = {answer.stop, answer.certificate.stop} & {StopReason.TIME_LIMIT, Stop.TIME_LIMIT}
    assert certified or stopped
    assert answer.stop is not StopReason.TIME_LIMIT or answer.support is Support.WEAK
    assert certified or seconds < 300
    assert not certified or seconds > 10
    assert np.all(np.isfinite(answer.poses))
    assert answer.best.evidence == max(one.evidence for one in answer.candidates)


def test_slips_are_not_looked_for_beyond_the_limit(monkeypatch):
    """A second goes by with each linear solve, and one limit ends amid the search for slips."""
    graph = slipped(manhattan(100, 0, closures=45)[0], (30, 75))
    spent, solve = [0.0], Sparing.solve

    def slow(problem, weights, x):
        spent[0] += 1.0
        return solve(problem, weights, x)

    monkeypatch.setattr("time.process_time", lambda: spent[0])
    monkeypatch.setattr(Sparing, "solve", slow)
    rs.solve(graph, max_seconds=inf)
    whole = spent[0]
    for share in (0.0, 0.5, 0.9):
        spent[0] = 0.0
        rs.solve(graph, max_seconds=share * whole)
        assert spent[0] <= 0.7 * share * whole + 8.0


def test_pairs_that_are_not_compared_count_as_consistent_and_a_clique_has_a_bound():
    none, every = pcm(GRAPH, max_seconds=0.0), pcm(GRAPH, max_seconds=inf)
    assert none.kept.all() and not none.complete
    assert every.complete and not every.kept.all()
    np.testing.assert_array_equal(every.kept, pcm(GRAPH).kept)
    rng = np.random.default_rng(0)
    joined = rng.random((80, 80)) < 0.6
    joined = np.triu(joined, 1) | np.triu(joined, 1).T
    quick, best = max_clique(joined, max_seconds=0.0), max_clique(joined)
    members = joined[np.ix_(quick.members, quick.members)]
    assert np.all(members | np.eye(quick.members.size, dtype=bool))
    assert quick.members.size <= best.members.size <= quick.bound
    assert quick.proven == (quick.members.size == quick.bound)


@pytest.mark.parametrize("method", [gnc, lambda g, **o: irls(g, kernels.cauchy(1.0), **o)])
def test_the_loop_takes_one_step_and_no_more_when_time_is_up(method):
    result = method(GRAPH, max_seconds=0.0)
    assert result.stop is StopReason.TIME_LIMIT
    assert len(result.history) == 2
    np.testing.assert_array_equal(result.x, result.history[-1].x)
    assert method(GRAPH, max_seconds=inf).cost == method(GRAPH).cost < result.cost


def test_an_unproven_map_has_a_cost_and_no_bound():
    proof = unproven(GRAPH, TRUTH)
    assert proof.bound == proof.cost == pytest.approx(rs.certificates.chordal_cost(GRAPH, TRUTH))


@refused(
    (lambda: rs.solve(GRAPH, max_seconds=-1.0), "max_seconds is -1.0; give a number of at least"),
    (lambda: rs.solve(GRAPH, max_seconds=np.nan), "max_seconds is nan"),
    (lambda: pcm(GRAPH, max_seconds=-1.0), "max_seconds is -1"),
    (lambda: gnc(GRAPH, max_seconds=-1.0), "max_seconds is -1"),
)
def test_a_negative_time_is_refused(wrong, message):
    with pytest.raises(ValueError, match=message):
        wrong()
