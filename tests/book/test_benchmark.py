"""The page *Benchmark*: its protocol is that of the sweep, its tables those of the file."""

from __future__ import annotations

import re
from types import SimpleNamespace

import matplotlib as mpl
import pytest
from robust_slam_course.results import Results, read_results

from benchmarks import methods
from benchmarks.sweep import summary
from benchmarks.sweep.definition import CPU_LIMIT, GROUP, KINDS, LOST, PERCENTS, PLANS, World, make
from tests.book.prose import CHAPTERS, Chapter

pytestmark = pytest.mark.long

CHAPTER = Chapter("benchmark")
TABLE = CHAPTERS / "data" / "robustness.csv"
WORDS = {3: "Three", 5: "five"}


@pytest.fixture(scope="module")
def results() -> Results:
    return read_results(TABLE)


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The names that the page's cells define, and the figures that it shows with their words."""
    shown: list[tuple[str, str, mpl.figure.Figure]] = []
    with pytest.MonkeyPatch.context() as patch, mpl.rc_context():
        patch.chdir(CHAPTERS)
        names = CHAPTER.run("imports", "load", "grid-table", "heat")
        names["show"] = lambda fig, caption, alt: shown.append((caption, alt, fig))
        CHAPTER.run(*(f"heat-{kind}" for kind in KINDS), **names)
    return SimpleNamespace(shown=shown, **names)


def test_the_protocol_is_that_of_the_sweep() -> None:
    text = " ".join(CHAPTER.cells["protocol"].split())
    assert {plan.closures for plan in PLANS.values()} == {45}
    assert "Each has 45 correct closures" in text
    town, sphere = PLANS["manhattan"], PLANS["sphere"]
    assert (town.poses, town.noise.odometry) == (200, (0.05, 0.05))
    assert "200 poses, with odometry noise of 0.05 m and 0.05 rad a step" in text
    assert (sphere.poses, sphere.noise.odometry) == (100, (0.05, 0.02))
    assert "100 poses in space, with 0.05 m and 0.02 rad" in text
    assert PERCENTS == (10, 30, 50, 70, 90)
    assert "10, 30, 50, 70 or 90 %" in text
    kinds = text.partition("**Outliers**")[2]
    assert re.findall(r"- \*(\w+)\*:", kinds) == list(KINDS)
    assert f"at most {LOST} m" in text
    assert f"after {CPU_LIMIT} s of CPU time" in text
    assert GROUP == 5
    assert "five in a row that follow from one error" in text
    assert {plan.seeds for plan in PLANS.values()} == {3, 5}
    assert "Three or five runs are in a cell" in CHAPTER.text


@pytest.mark.parametrize("seed", range(3))
def test_four_or_five_correct_closures_remain_of_a_spoiled_world(seed: int) -> None:
    graph, is_outlier, _ = make(World("manhattan", "spoiled", 90, seed))
    assert (~graph.is_odometry & ~is_outlier).sum() in (4, 5)
    assert "At 90 % four or five of 45 remain" in " ".join(CHAPTER.text.split())


def test_the_columns_are_explained() -> None:
    explained = re.findall(r"`(\w+)`", CHAPTER.cells["format"].partition("|---|---|")[2])
    columns = [name for name in explained if name in summary.COLUMNS]
    assert tuple(dict.fromkeys(columns)) == summary.COLUMNS


def test_the_start_table_counts_the_good_maps(results: Results, page) -> None:
    lines = page.grid().splitlines()[2:]
    assert len(lines) == len(methods.STARTS)
    for line, start in zip(lines, methods.STARTS, strict=True):
        first, *cells = (part.strip() for part in line.strip("|").split("|"))
        assert first == start
        for cell, name in zip(cells, page.GRID, strict=True):
            own = [row for row in results.rows if row["method"] == f"{name} from {start}"]
            good, runs = (sum(int(row[key]) for row in own) for key in ("good", "runs"))
            assert cell == f"{good} of {runs}"
            assert runs == sum(plan.seeds for plan in PLANS.values()) * 25


def test_the_first_table_states_all_parameters(results: Results) -> None:
    assert "{results.conditions()}" in CHAPTER.cells["grid-table"]
    told = results.conditions()
    for stated in (methods.PROBABILITY, methods.SOLVES, methods.FACTOR, *methods.MIXTURE):
        assert f"{stated:g}" in told
    assert str(methods.START_SOLVES) in told
    assert str(methods.CAUCHY[3]) in told


def test_a_heat_map_has_a_number_in_each_cell(results: Results, page) -> None:
    assert len(page.shown) == len(KINDS)
    for kind, (caption, alt, figure) in zip(KINDS, page.shown, strict=True):
        assert caption.startswith(kind.capitalize())
        assert kind in alt
        assert len(figure.axes) == len(PLANS)
        for ax, graph in zip(figure.axes, PLANS, strict=True):
            assert len(ax.texts) == len(methods.METHODS) * len(PERCENTS)
            share = results.share(graph=graph, kind=kind, percent="90", method="DCS")
            row = list(methods.METHODS).index("DCS")
            (cell,) = (t for t in ax.texts if t.get_position() == (4.5, row + 0.5))
            assert cell.get_text() == f"{100 * share:.0f}"


def test_the_method_on_the_page_can_be_entered(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(methods, "METHODS", {})
    (code,) = re.findall(r"```python\n(.*?)```", CHAPTER.cells["enter"], re.DOTALL)
    exec(compile(code, "page", "exec", dont_inherit=True), vars(methods).copy())
    assert list(methods.METHODS) == ["Welsch from odometry", "Welsch from least squares"]
    score = methods.run("Welsch from odometry", *make(World("manhattan", "random", 10, 0)), 1)
    assert 0 < score.ate < 2
    assert '--methods "Welsch from odometry"' in CHAPTER.cells["enter"]
