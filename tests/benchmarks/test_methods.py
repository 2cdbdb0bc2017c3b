"""The methods of the sweep, and their budget."""

import importlib
from pathlib import Path

import numpy as np
import pytest
from robust_slam.estimators import chi_square_threshold, gnc
from robust_slam.problems import PoseGraphProblem

from benchmarks import methods
from benchmarks.methods import ORACLE, Budgeted, counted
from benchmarks.sweep.definition import World, make

C = chi_square_threshold(0.99, 3)
EASY = World("manhattan", "spoiled", 10, 0)
HARD = World("manhattan", "random", 50, 0)


@pytest.fixture(scope="module")
def easy():
    return make(EASY)


@pytest.fixture(scope="module")
def problem():
    return PoseGraphProblem(make(HARD).graph, steps=1)


@pytest.mark.parametrize("name", methods.available())
def test_each_method_scores_an_easy_world_within_its_budget(name, easy):
    score = methods.run(name, easy)
    assert np.isfinite(score.ate)
    assert 0 < score.ate < 10
    assert 0 <= score.recall <= 1
    if name in methods.GTSAM:
        assert score.solves is None
    else:
        assert 0 <= score.solves <= methods.SOLVES
        assert (score.solves == 0) == (name == "dead reckoning")


def test_the_oracle_solves_without_the_outliers(easy):
    best = methods.run(ORACLE, easy)
    assert (best.precision, best.recall) == (1.0, 1.0)
    assert best.ate < methods.run("least squares", easy).ate


def test_a_spent_budget_leaves_the_map_as_it_is(monkeypatch, problem):
    monkeypatch.setattr(methods, "SOLVES", 7)
    with counted() as count:
        short = Budgeted(problem.graph, count)
        result = gnc(short, C, x0=short.guess, tol=1e-4)
    assert count.solves == 7
    assert np.array_equal(result.x, result.history[7].x)
    assert not np.array_equal(result.x, result.history[6].x)


def test_every_benchmark_can_be_imported():
    """Some take minutes, and are run by hand alone."""
    names = [path.stem for path in Path(methods.__file__).parent.glob("*.py")]
    assert "sandboxes" in names
    for name in names:
        importlib.import_module(f"benchmarks.{name}")
