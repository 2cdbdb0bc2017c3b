"""Chapter 08's larger sweep: what the page says of the table, and of GTSAM's first μ."""

from __future__ import annotations

import csv
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robust_slam.estimators.graduation import gnc, start_mu
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.metrics import ate
from robust_slam.problems import PoseGraphProblem

from benchmarks.sweep.definition import GROUP, PLANS
from tests.book.prose import CHAPTERS, Chapter
from tests.conftest import leave_out

CHAPTER = Chapter("08-showcase")
C = chi_square_threshold(0.99, 3)
LINES = (CHAPTERS / "data" / "robustness.csv").read_text(encoding="utf-8").splitlines()
ROWS = list(csv.DictReader(line for line in LINES if not line.startswith("#")))


def chosen(**wanted: str) -> Iterator[dict[str, str]]:
    return (row for row in ROWS if all(row[key] == value for key, value in wanted.items()))


def good(**wanted: str) -> float:
    """Return the share of good maps among the runs."""
    rows = list(chosen(**wanted))
    return sum(int(row["good"]) for row in rows) / sum(int(row["runs"]) for row in rows)


def test_the_graphs_are_those_that_the_text_names() -> None:
    sizes = {name: (plan.poses, plan.closures, plan.seeds) for name, plan in PLANS.items()}
    assert sizes == {
        "manhattan": (200, 45, 10),
        "sphere": (100, 45, 10),
        "intel": (None, 90, 3),
        "CSAIL": (None, 128, 3),
    }
    assert PLANS["manhattan"].noise.odometry == (0.05, 0.05)
    assert PLANS["sphere"].noise.odometry == (0.05, 0.02)


def test_without_the_table_the_page_says_where_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    CHAPTER.run("larger-load", "larger-figure", "larger-table", np=np)
    said = capsys.readouterr().out
    assert "make sweep" in said
    assert said.count("chapters/data") == 1


def of(graph: str, method: str) -> list[dict[str, str]]:
    return list(chosen(graph=graph, method=method))


def test_pcm_and_max_mixture_change_places_between_csail_and_intel() -> None:
    counts = {
        (graph, method): sum(int(row["good"]) for row in of(graph, method))
        for graph in ("manhattan", "intel", "CSAIL")
        for method in ("PCM + GNC-TLS", "max-mixture")
    }
    assert counts["CSAIL", "PCM + GNC-TLS"] == 36
    assert 36 - counts["intel", "PCM + GNC-TLS"] == 14
    assert counts["intel", "max-mixture"] == 34
    assert counts["CSAIL", "max-mixture"] == 5
    assert counts["manhattan", "max-mixture"] == 0
    assert all(
        sum(int(row["runs"]) for row in of(graph, "max-mixture")) == 36
        for graph in ("intel", "CSAIL")
    )
    assert all(float(row["precision"]) == 1 for row in of("manhattan", "max-mixture"))


@pytest.mark.parametrize("method", ["SC, jointly", "SC, closed form"])
def test_switches_keep_nearly_every_map(method: str) -> None:
    assert min(good(graph=graph, method=method) for graph in {row["graph"] for row in ROWS}) >= 0.9


@pytest.mark.parametrize("graph", ["manhattan", "intel"])
def test_gnc_from_least_squares_loses_maps_that_irls_keeps(graph: str) -> None:
    irls = good(graph=graph, method="IRLS, Cauchy")
    assert irls > good(graph=graph, method="GNC-TLS") > good(graph=graph, method="GNC-GM")


@pytest.mark.parametrize("graph", ["manhattan", "sphere", "intel", "CSAIL"])
def test_gnc_keeps_more_maps_from_dead_reckoning(graph: str) -> None:
    better = good(graph=graph, method="GNC-TLS, odom.") - good(graph=graph, method="GNC-TLS")
    assert better >= 0.1


def test_small_consistent_groups_seldom_outvote_the_inlier_closures() -> None:
    town = {"graph": "manhattan", "kind": "consistent", "percent": "90"}
    (row,) = chosen(**town, method="PCM + GNC-TLS")
    assert (row["good"], row["runs"]) == ("8", "10")
    assert (GROUP, PLANS["manhattan"].closures) == (5, 45)


@pytest.fixture(scope="module")
def town() -> Any:
    """The page's function (kind, count, seed) -> graph, outliers, truth."""
    return CHAPTER.run("imports", "town", C=C)["with_outliers"]


def timid(graph: Any) -> np.ndarray:
    """GNC-TLS from dead reckoning, as on the page."""
    problem = PoseGraphProblem(graph, steps=1, tol=1e-6)
    return gnc(problem, C, x0=problem.guess, tol=1e-6).x


@pytest.mark.parametrize("count", [12, 18])
def test_dead_reckoning_brings_all_lost_towns_back(count: int, town: Any) -> None:
    lost: dict[str, list[int]] = {"bold": [], "timid": []}
    for seed in range(5):
        graph, _, truth = town("consistent", count, seed)
        bold = gnc(PoseGraphProblem(graph, steps=1, tol=1e-6), C, tol=1e-6).x
        for name, poses in (("bold", bold), ("timid", timid(graph))):
            lost[name] += [seed] if ate(poses, truth) > 0.4 else []
    assert lost == {"bold": [0, 2, 3, 4], "timid": []}


@pytest.mark.parametrize("count", [12, 18])
def test_two_towns_stay_lost_when_only_the_first_mu_comes_from_the_odometry(
    count: int, town: Any
) -> None:
    lost = []
    for seed in range(5):
        graph, _, truth = town("consistent", count, seed)
        problem = PoseGraphProblem(graph, steps=1, tol=1e-6)
        first = start_mu(problem.residual_norms(problem.guess)[~graph.is_odometry].max(), C)
        mixed = gnc(problem, C, x0=problem.initial(), mu0=first, tol=1e-6).x
        lost += [seed] if ate(mixed, truth) > 0.4 else []
    assert lost == ([0, 3] if count == 18 else [])


@pytest.mark.parametrize("count", [12, 18])
def test_gtsam_loses_the_same_towns_from_least_squares(count: int, town: Any) -> None:
    if importlib.util.find_spec("gtsam") is None:
        leave_out("gtsam is not installed; nothing is compared with it")
    from benchmarks.methods import GTSAM, METHODS

    for seed in range(5):
        graph, _, truth = town("consistent", count, seed)
        odometry = PoseGraphProblem(graph, steps=1, tol=1e-6)
        squares = PoseGraphProblem(graph, odometry.initial(), steps=1)
        theirs, bent = (ate(METHODS[GTSAM](one, C), truth) for one in (odometry, squares))
        assert (theirs > 0.4) == ((count, seed) in {(18, 0), (18, 3)})
        assert (bent > 0.4) == (seed in (0, 2, 3, 4))
