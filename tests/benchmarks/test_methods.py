"""The methods of the sweep: their budget, their starts, and where GNC-GM ends."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.errors import NotConverged, Underdetermined
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels, switchable
from robust_slam.graphs import ate, pose_graph
from robust_slam.graphs.pose_graph import PoseGraph, connected_parts
from robust_slam.problems import PoseGraphProblem

from benchmarks import methods
from benchmarks.methods import METHODS, ORACLE, STARTS, Budgeted, counted
from benchmarks.sweep.definition import World, make

C = chi_square_threshold(0.99, 3)
EASY = World("manhattan", "spoiled", 10, 0)
HARD = World("manhattan", "random", 50, 0)


@pytest.fixture(scope="module")
def easy() -> tuple[PoseGraph, np.ndarray, np.ndarray]:
    return make(EASY)


@pytest.fixture(scope="module")
def problem() -> PoseGraphProblem:
    return PoseGraphProblem(make(HARD)[0], steps=1)


@pytest.mark.parametrize("name", methods.available())
def test_each_method_scores_an_easy_world_within_its_budget(name: str, easy) -> None:
    score = methods.run(name, *easy, methods.STEPS)
    assert np.isfinite(score.ate)
    assert 0 < score.ate < 10
    assert 0 <= score.recall <= 1
    if name in methods.GTSAM:
        assert score.solves is None
    else:
        assert 0 <= score.solves <= methods.SOLVES
        assert (score.solves == 0) == (name == "dead reckoning")


def test_the_grid_crosses_every_start_with_graduation() -> None:
    for name in ("IRLS-GM", "GNC-GM", "IRLS-TLS", "GNC-TLS"):
        assert {f"{name} from {start}" for start in STARTS} <= METHODS.keys()


def test_the_oracle_solves_without_the_outliers(easy) -> None:
    graph, is_outlier, reference = easy
    best = methods.run(ORACLE, graph, is_outlier, reference, methods.STEPS)
    assert (best.precision, best.recall) == (1.0, 1.0)
    assert best.ate < methods.run("least squares", *easy, methods.STEPS).ate


def test_a_new_method_is_one_decorated_function(monkeypatch: pytest.MonkeyPatch, easy) -> None:
    monkeypatch.setattr(methods, "METHODS", dict(METHODS))

    @methods.method("Welsch", ("odometry", "least squares"))
    def welsch(problem: PoseGraphProblem, c: float, x0: np.ndarray) -> np.ndarray:
        return irls(problem, kernels.welsch(c), x0, tol=1e-4, max_iterations=500).x

    entered = [name for name in methods.available() if name not in METHODS]
    assert entered == ["Welsch from odometry", "Welsch from least squares"]
    assert methods.run(entered[0], *easy, methods.STEPS).ate < 0.5


def test_the_tree_of_fewest_edges_uses_closures(problem: PoseGraphProblem) -> None:
    graph, tree = problem.graph, STARTS["spanning tree"](problem)
    exact = pose_graph.residual_norms(graph, tree) < 1e-6
    assert np.unique(connected_parts(graph.n, graph.edges[exact])).size == 1
    assert np.sum(exact & ~graph.is_odometry) > 10
    assert not np.allclose(tree, problem.guess)


def test_a_spent_budget_leaves_the_map_as_it_is(
    monkeypatch: pytest.MonkeyPatch, problem: PoseGraphProblem
) -> None:
    monkeypatch.setattr(methods, "SOLVES", 7)
    with counted() as count:
        short = Budgeted(problem.graph, count)
        result = gnc(short, C, x0=short.guess, tol=1e-4)
    assert count.solves == 7
    assert np.array_equal(result.x, result.history[7].x)
    assert not np.array_equal(result.x, result.history[6].x)


def test_solves_are_counted_only_while_asked(problem: PoseGraphProblem) -> None:
    ones = np.ones(len(problem.graph.edges))
    with counted() as count:
        problem.solve(ones, problem.guess)
    problem.solve(ones, problem.guess)
    assert count.solves == 1


def gradient(problem: PoseGraphProblem, poses: np.ndarray) -> float:
    """The length of the gradient of the Geman-McClure cost."""
    norms = problem.residual_norms(poses)
    weights = np.where(problem.trusted, 1.0, kernels.geman_mcclure(C).weight(norms))
    equations = problem._equations
    _, slope = equations.system(equations.at(poses, weights), weights)
    return float(np.linalg.norm(slope[1:]))


def test_gnc_gm_ends_at_a_stationary_point(problem: PoseGraphProblem) -> None:
    """After graduation alone the gradient is far from zero."""
    graduated = gnc(problem, C, "gm", problem.guess, tol=methods.TOL).x
    ended = METHODS["GNC-GM from odometry"](problem, C)
    assert gradient(problem, ended) < 0.01 * gradient(problem, graduated)
    again = irls(problem, kernels.geman_mcclure(C), ended, tol=1e-8, max_iterations=500).x
    assert ate(again, ended) < 1e-3


def test_closed_form_switches_are_irls_with_geman_mcclure(problem: PoseGraphProblem) -> None:
    switched = switchable(problem, C**2, problem.guess, tol=methods.TOL, max_iterations=500).x
    assert np.allclose(METHODS["IRLS-GM from odometry"](problem, C), switched)


def test_a_method_that_fails_says_so(monkeypatch: pytest.MonkeyPatch, easy) -> None:
    monkeypatch.setattr(methods, "METHODS", dict(METHODS))

    @methods.method("restless")
    def restless(problem: PoseGraphProblem, c: float, x0: np.ndarray) -> np.ndarray:
        raise NotConverged

    with pytest.raises((NotConverged, Underdetermined)):
        methods.run("restless", *easy, methods.STEPS)
    with counted() as count:
        pass
    assert count.solves == 0
