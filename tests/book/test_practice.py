"""The page *In practice*: its numbers and its calls."""

import operator
import re
from importlib import import_module

import numpy as np
import pytest
import robust_slam as rs
from robust_slam.estimators import chi_square_threshold, gnc, irls, kernels, switchable
from robust_slam.estimators.result import Result, StopReason
from robust_slam.graphs import add_random_closures, dead_reckoning, manhattan
from robust_slam.problems import PoseGraphProblem
from scipy.stats import chi2

from tests.book.prose import CHAPTERS, DECIMAL
from tests.book.samples import efficiency

PAGE = (CHAPTERS / "practice.md").read_text(encoding="utf-8")
THRESHOLDS = re.findall(r"^\| (\d), .+ \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", PAGE, re.M)
CALLS = sorted(set(re.findall(r"\{py:(?:func|class)\}`[^<]+<robust_slam\.([\w.]+)>`", PAGE)))


@pytest.fixture(scope="module")
def graph():
    """A walk through a town, with six wrong closures."""
    clean, truth = manhattan(60, 0, closures=15)
    return add_random_closures(clean, 6, 1, poses=truth)[0]


@pytest.fixture(scope="module")
def answer(graph):
    return rs.solve(graph)


@pytest.mark.parametrize("row", THRESHOLDS, ids=lambda row: f"d={row[0]}")
def test_a_threshold_is_the_root_of_a_quantile(row):
    for probability, printed in zip((0.95, 0.99, 0.999), row[1:], strict=True):
        c = chi_square_threshold(probability, int(row[0]))
        assert printed == f"{c:.3f}" == f"{np.sqrt(chi2.ppf(probability, int(row[0]))):.3f}"


def test_the_other_numbers_are_right():
    assert [row[0] for row in THRESHOLDS] == ["1", "2", "3", "6"]
    scalar = chi_square_threshold(0.99, 1)
    assert f"{100 * chi2.sf(scalar**2, 6):.1f}" == "35.6"
    assert efficiency(kernels.cauchy(2.666), 3) == pytest.approx(0.95, abs=1e-4)
    assert "odometry=(0.05, 0.01)" in PAGE
    known = {"0.95", "0.99", "0.999", "35.6", "2.666", "0.05", "0.01"}
    assert set(DECIMAL.findall(PAGE)) == known | {c for row in THRESHOLDS for c in row[1:]}


@pytest.mark.parametrize("name", CALLS)
def test_a_call_exists_and_is_public(name):
    folder, _, short = f"robust_slam.{name}".rpartition(".")
    module = import_module(folder)
    assert hasattr(module, short)
    listed = f"robust_slam.{name}\n" in (CHAPTERS / "api.md").read_text(encoding="utf-8")
    assert listed or short in module.__all__


def test_every_method_of_the_tree_is_linked():
    methods = {"solve", "gnc", "irls", "certify", "pcm"}
    assert {name.rpartition(".")[2] for name in CALLS} >= methods
    tree = PAGE.partition("## A decision tree")[2].partition("\n## ")[0]
    leaves = re.findall(r"^   - (.+(?:\n     .+)*)", tree, re.M)
    ends = [leaf for leaf in leaves if not re.search(r"go to \d\.$", leaf)]
    assert len(ends) == 9
    assert not [leaf for leaf in ends if "](" not in leaf]
    assert not [leaf for leaf in ends if "{py:func}" not in leaf and "#what-to-watch" not in leaf]


def test_the_calls_begin_where_the_page_says(graph):
    first = dead_reckoning(graph)
    for result in (gnc(graph), irls(graph, kernels.cauchy(2.666)), switchable(graph)):
        np.testing.assert_allclose(result.history[0].x, first, atol=1e-12)
    squares = gnc(PoseGraphProblem(graph)).history[0].x
    assert np.abs(squares - first).max() > 0.1


def test_all_rejected_is_seen_in_the_stop_the_cost_and_the_map(graph):
    c, closures = 1e-3, int(np.sum(~graph.is_odometry))
    ends = {irls: irls(graph, kernels.tls(c)), gnc: gnc(graph, c)}
    assert ends[irls].stop is StopReason.CONVERGED
    assert ends[gnc].stop is StopReason.BINARY_WEIGHTS
    for result in ends.values():
        assert not np.any(result.kept & ~graph.is_odometry)
        assert result.cost == pytest.approx(closures * c**2 / 2)
        np.testing.assert_allclose(result.poses, dead_reckoning(graph), atol=1e-9)


def test_what_is_to_be_watched_is_there(answer):
    for name in re.findall(r"`answer\.([\w.]+?)(?:\(\))?`", PAGE):
        operator.attrgetter(name)(answer)
    assert "`verdict` and `bound` of `answer.certificate`" in PAGE
    assert hasattr(answer.certificate, "verdict") and hasattr(answer.certificate, "bound")
    named = re.findall(r"`result\.(\w+)`", PAGE)
    assert named and not [
        name for name in named if not hasattr(Result, name) and name not in Result.__annotations__
    ]
