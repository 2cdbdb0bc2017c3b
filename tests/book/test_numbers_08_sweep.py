"""Chapter 08's larger sweep: what the page says of the table, and of GTSAM's first μ."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import pyplot as plt
from robust_slam.estimators.graduation import gnc, start_mu
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.metrics import ate
from robust_slam.problems import PoseGraphProblem
from robust_slam_course.results import read_results

from benchmarks.methods import STARTS
from benchmarks.sweep.definition import GROUP, PERCENTS, PLANS, worlds
from tests.book.prose import CHAPTERS, Chapter
from tests.conftest import leave_out

pytestmark = pytest.mark.long

CHAPTER = Chapter("08-showcase")
C = chi_square_threshold(0.99, 3)
RESULTS = read_results(CHAPTERS / "data" / "robustness.csv")
GRID = ("IRLS-GM", "GNC-GM", "IRLS-TLS", "GNC-TLS")


def good(method: str, **wanted: str) -> int:
    return RESULTS.good(method=method, **wanted)[0]


def said(cell: str) -> str:
    return " ".join(CHAPTER.cells[cell].split())


def test_the_graphs_are_those_that_the_text_names() -> None:
    sizes = {name: (plan.poses, plan.closures) for name, plan in PLANS.items()}
    assert sizes == {
        "manhattan": (200, 45),
        "sphere": (100, 45),
        "intel": (None, 45),
        "CSAIL": (None, 45),
    }
    assert PLANS["manhattan"].noise.odometry == (0.05, 0.05)
    assert PLANS["sphere"].noise.odometry == (0.05, 0.02)
    assert "Each has 45 correct closures" in said("larger")
    assert (GROUP, min(PERCENTS), max(PERCENTS)) == (5, 10, 90)
    assert f"in {sum(1 for _ in worlds())} worlds" in said("larger")


def test_without_the_table_the_page_says_where_it_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    cells = ("larger-load", "larger-figure", "larger-table", "larger-others")
    CHAPTER.run(*cells, np=np, Markdown=str)
    printed = capsys.readouterr().out
    assert "make sweep" in printed
    assert printed.count("chapters/data") == 1


def test_the_table_and_the_caption_come_from_the_file(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(CHAPTERS)
    shown: list[tuple[Any, str]] = []
    names = CHAPTER.run(
        *("larger-load", "larger-figure", "larger-table"),
        plt=plt,
        Markdown=str,
        show=lambda fig, caption, alt: shown.append((fig, caption)),
    )
    for start in STARTS:
        cells = ("{} of {}".format(*RESULTS.good(method=f"{name} from {start}")) for name in GRID)
        assert f"| {start} | {' | '.join(cells)} |" in names["text"]
    ((figure, caption),) = shown
    assert RESULTS.conditions() in caption
    town = figure.axes[0]
    share = RESULTS.share(graph="manhattan", method="GNC-TLS from odometry")
    (cell,) = (text for text in town.texts if text.get_position() == (3.5, 0.5))
    assert cell.get_text() == f"{100 * share:.0f}"


def test_the_start_decides() -> None:
    for name in ("IRLS-GM", "GNC-GM", "GNC-TLS"):
        first, *others = (good(f"{name} from {start}") for start in STARTS)
        assert first > max(others)
    assert good("IRLS-Cauchy from odometry") > good("IRLS-Cauchy from least squares")


def test_graduation_helps_tls_and_harms_gm() -> None:
    for start in STARTS:
        assert good(f"GNC-TLS from {start}") > 2 * good(f"IRLS-TLS from {start}")
        assert good(f"GNC-GM from {start}") < good(f"IRLS-GM from {start}")


def test_geman_mcclure_from_odometry_keeps_most_of_the_grid() -> None:
    best, runs = RESULTS.good(method="IRLS-GM from odometry")
    assert best == max(good(f"{name} from {start}") for name in GRID for start in STARTS)
    told = said("larger-methods")
    assert f"{best} of {runs}" in told
    assert f"GNC-TLS from odometry in {good('GNC-TLS from odometry')}" in told
    assert f"one in {good('correct edges alone')}" in told
    for graph in PLANS:
        jointly, in_turn = (
            RESULTS.share(method=name, graph=graph)
            for name in ("SC, jointly", "IRLS-GM from odometry")
        )
        assert abs(jointly - in_turn) < 0.03
        assert jointly > 0.9


def test_the_ranking_changes_with_the_graph() -> None:
    pcm, mixture = (
        {graph: RESULTS.share(graph=graph, method=name) for graph in PLANS}
        for name in ("PCM + GNC-TLS", "max-mixture")
    )
    assert pcm["CSAIL"] > 0.9
    assert mixture["CSAIL"] < 0.1
    assert pcm["intel"] < mixture["intel"] - 0.2
    assert mixture["manhattan"] == 0
    rows = RESULTS.where(graph="manhattan", method="max-mixture")
    assert all(float(row["precision"]) == 1 for row in rows)


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


def test_from_dead_reckoning_no_town_of_the_smaller_sweep_is_lost(town: Any) -> None:
    assert "shares, seeds = [20, 40, 50, 60, 75], range(5)" in CHAPTER.cells["sweep-run"]
    errors = [
        ate(timid(graph), truth)
        for kind in ("random", "consistent")
        for count in (3, 8, 12, 18, 36)
        for graph, _, truth in (town(kind, count, seed) for seed in range(5))
    ]
    assert len(errors) == 50 and max(errors) <= 0.4


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
    from benchmarks.methods import METHODS

    for seed in range(5):
        graph, _, truth = town("consistent", count, seed)
        odometry = PoseGraphProblem(graph, steps=1, tol=1e-6)
        squares = PoseGraphProblem(graph, odometry.initial(), steps=1)
        theirs, bent = (
            ate(METHODS["GTSAM's GNC-TLS"](one, C), truth) for one in (odometry, squares)
        )
        assert (theirs > 0.4) == ((count, seed) in {(18, 0), (18, 3)})
        assert (bent > 0.4) == (seed in (0, 2, 3, 4))
