"""The sweep: its worlds, its journal, runs that come to nothing, and the committed table."""

from __future__ import annotations

import csv
import json
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from robust_slam.errors import NotConverged
from robust_slam.graphs import pose_graph
from robust_slam_course.results import read_results

from benchmarks import methods
from benchmarks.methods import Score
from benchmarks.sweep import __main__ as door
from benchmarks.sweep import journal, summary
from benchmarks.sweep.definition import (
    GROUP,
    KINDS,
    LOST,
    PERCENTS,
    PLANS,
    World,
    digest,
    make,
    worlds,
)
from benchmarks.sweep.journal import Run
from benchmarks.sweep.run import Task, do, run_world

pytestmark = pytest.mark.long

WORLD = World("manhattan", "random", 10, 0)
SCORE = Score(precision=0.5, recall=0.25, ate=0.125, seconds=2.0, solves=10)
DONE = Run(WORLD, "DCS", SCORE, 2.0)
FAILED = Run(WORLD, "GNC-TLS from odometry", None, 3.0, "NotConverged")
NAMES = methods.available()
GENERATED = [name for name, plan in PLANS.items() if plan.poses is not None]


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(line for line in text.splitlines() if line[0] != "#"))


def pretended(tasks: Sequence[Task]) -> Iterator[Run]:
    for world, names in tasks:
        yield from (Run(world, name, SCORE, 2.0) for name in names)


class TestWorlds:
    @pytest.mark.parametrize("kind", KINDS)
    @pytest.mark.parametrize("graph", GENERATED)
    def test_the_rate_is_of_all_closures(self, graph: str, kind: str) -> None:
        for percent in PERCENTS:
            spoiled, is_outlier, _ = make(World(graph, kind, percent, 0))
            assert np.mean(is_outlier[~spoiled.is_odometry]) == pytest.approx(
                percent / 100, abs=0.0125
            )

    @pytest.mark.parametrize("graph", GENERATED)
    def test_spoiled_closures_replace_correct_ones(self, graph: str) -> None:
        few, many = (make(World(graph, "spoiled", percent, 0)) for percent in (10, 90))
        for spoiled, is_outlier, _ in (few, many):
            closures = ~spoiled.is_odometry
            assert np.sum(closures) == PLANS[graph].closures
            assert not np.any(is_outlier & ~closures)
        assert np.array_equal(few[0].edges, many[0].edges)
        untouched = ~few[1] & ~many[1]
        assert np.array_equal(few[0].measurement[untouched], many[0].measurement[untouched])
        wrong = many[1]
        norms = pose_graph.residual_norms(many[0], many[2])
        assert np.median(norms[wrong]) > 20 * np.median(norms[~wrong])

    @pytest.mark.parametrize("graph", GENERATED)
    def test_kinds_and_rates_share_the_graph_of_a_seed(self, graph: str) -> None:
        places = (("local", 10, 3), ("group", 90, 3), ("local", 10, 4))
        made = [make(World(graph, *place)) for place in places]
        few, many, other = (spoiled.measurement[~is_outlier] for spoiled, is_outlier, _ in made)
        assert np.array_equal(made[0][2], made[1][2])
        assert np.array_equal(few, many)
        assert not np.array_equal(few, other)


class TestJournal:
    def test_what_is_noted_is_read(self, tmp_path: Path) -> None:
        path = tmp_path / "deep" / "journal.jsonl"
        for run in (DONE, FAILED):
            journal.append(path, run)
        assert journal.read(path) == {run.key: run for run in (DONE, FAILED)}

    def test_half_a_line_is_dropped_and_the_next_is_whole(self, tmp_path: Path) -> None:
        path = tmp_path / "journal.jsonl"
        for run in (DONE, FAILED):
            journal.append(path, run)
        path.write_bytes(path.read_bytes()[:-30])
        assert list(journal.read(path)) == [DONE.key]
        journal.append(path, FAILED)
        assert list(journal.read(path)) == [DONE.key, FAILED.key]

    def test_another_sweep_does_not_count(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        path = tmp_path / "journal.jsonl"
        journal.append(path, DONE)
        monkeypatch.setitem(methods.PARAMETERS, "steps", methods.STEPS + 1)
        assert journal.read(path) == {}

    def test_a_sweep_that_was_killed_does_only_what_is_missing(self, tmp_path: Path) -> None:
        path = tmp_path / "journal.jsonl"
        tasks = door.missing({}, ["manhattan"], NAMES)
        total = sum(len(names) for _, names in tasks)

        def killed(some: Sequence[Task]) -> Iterator[Run]:
            for number, run in enumerate(pretended(some)):
                if number == 25:
                    raise KeyboardInterrupt
                yield run

        with pytest.raises(KeyboardInterrupt):
            door.sweep(path, killed(tasks), total)
        done = journal.read(path)
        assert len(done) == 25
        left = door.missing(done, ["manhattan"], NAMES)
        assert sum(len(names) for _, names in left) == total - 25
        door.sweep(path, pretended(left), total - 25)
        assert len(path.read_text().splitlines()) == len(journal.read(path)) == total
        assert door.missing(journal.read(path), ["manhattan"], NAMES) == []


class TestRuns:
    def test_two_processes_find_what_one_finds(self) -> None:
        tasks: list[Task] = [(world, ("DCS",)) for world in (WORLD, WORLD._replace(seed=1))]
        alone, together = ({run.key: run.score for run in do(tasks, jobs)} for jobs in (1, 2))
        assert alone.keys() == together.keys()
        for key, score in alone.items():
            assert together[key].ate == pytest.approx(score.ate, rel=1e-6)

    def test_a_method_that_does_not_come_to_rest_is_noted(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def restless(*_: object) -> None:
            raise NotConverged

        monkeypatch.setitem(methods.METHODS, "restless", restless)
        (run,) = run_world(WORLD, ["restless"])
        assert (run.score, run.failed) == (None, "NotConverged")

    def test_a_run_over_the_limit_is_ended_and_noted(
        self, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def endless(*_: object) -> None:
            while True:
                time.process_time()

        monkeypatch.setitem(methods.METHODS, "endless", endless)
        slow, quick = run_world(WORLD, ["endless", "DCS"], limit=1)
        assert (slow.score, slow.failed, slow.seconds) == (None, "over 1 s", 1.0)
        assert quick.score is not None

    def test_an_error_that_nobody_expects_stops_the_sweep(
        self, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
    ) -> None:
        monkeypatch.setitem(methods.METHODS, "broken", lambda *_: 1 / 0)
        with pytest.raises(RuntimeError, match="broken in World"):
            list(run_world(WORLD, ["broken"]))
        assert "ZeroDivisionError" in capfd.readouterr().err


class TestTable:
    def test_a_row_says_what_came_of_its_runs(self) -> None:
        far = Run(WORLD._replace(seed=1), "DCS", Score(1.0, 0.75, 2.0, 4.0, 31), 4.0)
        none = Run(WORLD._replace(seed=2), "DCS", None, 9.0, "NotConverged")
        (row,) = rows(summary.text([DONE, far, none]))
        assert list(row.values()) == [
            *("manhattan", "random", "10", "DCS", "3", "1", "1"),
            *("0.75", "0.5", "1.062", "2", "4", "20"),
        ]

    def test_runs_without_a_map_leave_their_places_empty(self) -> None:
        (row,) = rows(summary.text([FAILED]))
        assert (row["failed"], row["good"], row["ate_worst"]) == ("1", "0", "")

    def test_the_committed_table_is_of_this_sweep_and_small(self) -> None:
        committed = read_results(door.TABLE)
        runs = sum(int(row["runs"]) for row in committed.rows)
        wanted = sum(1 for _ in worlds()) * len(methods.METHODS)
        assert committed.header["version"] == digest()
        assert committed.header["runs"] == f"{runs} of {wanted}"
        assert runs == wanted
        assert door.TABLE.stat().st_size <= 200 * 1024

    def test_a_row_of_the_committed_table_comes_out_again(self) -> None:
        method = "GNC-TLS from least squares"
        (committed,) = (
            row
            for row in rows(door.TABLE.read_text(encoding="utf-8"))
            if (row["graph"], row["kind"], int(row["percent"])) == WORLD[:3]
            and row["method"] == method
        )
        seeds = range(int(committed["runs"]))
        again = [run for seed in seeds for run in run_world(WORLD._replace(seed=seed), [method])]
        (row,) = rows(summary.text(again))
        assert len(seeds) > 0
        assert [row[key] for key in ("failed", "good")] == [
            committed[key] for key in ("failed", "good")
        ]
        for key in ("precision", "recall", "ate_median", "ate_worst"):
            assert float(row[key]) == pytest.approx(float(committed[key]), abs=2e-3)

    def test_the_committed_table_states_every_parameter(self) -> None:
        header = read_results(door.TABLE).header
        for name, value in methods.PARAMETERS.items():
            assert header["parameters"][name] == json.loads(json.dumps(value)), name
        for name, plan in PLANS.items():
            stated = header["graphs"][name]
            assert (stated["closures"], stated["seeds"]) == (plan.closures, plan.seeds)
        assert (header["group"], header["good"]) == (GROUP, LOST)
