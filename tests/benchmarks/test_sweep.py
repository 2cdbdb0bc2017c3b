"""The sweep: its worlds, its journal, runs that come to nothing, and the committed table."""

import csv
import re
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from robust_slam.errors import NotConverged
from robust_slam.files.g2o import write
from robust_slam.graphs import pose_graph
from robust_slam_course.results import read_results

from benchmarks import methods
from benchmarks.methods import Score
from benchmarks.sweep import __main__ as door
from benchmarks.sweep import definition, entry, journal, seal, summary
from benchmarks.sweep.changes import CHANGES, FACTORS, NOISY, SLIPS
from benchmarks.sweep.definition import PLANS, TIERS, World, digest, make, worlds
from benchmarks.sweep.journal import Run
from benchmarks.sweep.run import Task, do, run_world

pytestmark = [pytest.mark.long, pytest.mark.rest]

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
    @pytest.mark.parametrize("kind", definition.KINDS)
    @pytest.mark.parametrize("graph", GENERATED)
    def test_the_rate_is_of_all_closures(self, graph, kind):
        for percent in definition.PERCENTS:
            made = make(World(graph, kind, percent, 0))
            rate = np.mean(made.is_outlier[~made.graph.is_odometry])
            assert rate == pytest.approx(percent / 100, abs=0.0125)

    @pytest.mark.parametrize("graph", GENERATED)
    def test_kinds_and_rates_share_the_graph_of_a_seed(self, graph):
        places = (("local", 10, 3), ("group", 90, 3), ("local", 10, 4), ("spoiled", 50, 3))
        *made, spoiled = (make(World(graph, *place)) for place in places)
        few, many, other = (one.graph.measurement[~one.is_outlier] for one in made)
        right = ~spoiled.is_outlier
        assert np.array_equal(spoiled.graph.measurement[right], few[right])
        assert np.array_equal(made[0].reference, made[1].reference)
        assert np.array_equal(few, many)
        assert not np.array_equal(few, other)


class TestTiers:
    def test_sealed_worlds_are_those_of_a_with_seeds_that_the_hash_is_of(self):
        seeds = seal.seeds()
        assert len(set(seeds)) == seal.COUNT
        tuned, sealed = list(worlds("A")), list(worlds("B"))
        assert [one._replace(tier="A", seed=seeds.index(one.seed)) for one in sealed] == tuned

    def test_other_seeds_than_the_sealed_ones_are_refused(self, tmp_path, monkeypatch):
        monkeypatch.setattr(seal, "OPENED", tmp_path / "opened.txt")
        monkeypatch.setattr(seal, "SEALED", tmp_path / "sealed.txt")
        assert list(worlds("B")) == []
        (tmp_path / "sealed.txt").write_text("salt\n1\n2\n")
        with pytest.raises(ValueError, match="SHA-256 is not HASH"):
            seal.seeds()

    @pytest.mark.parametrize("change", CHANGES["C"])
    def test_a_wrong_claim_leaves_the_measurements(self, change):
        plain, wrong = (make(WORLD._replace(change=one)) for one in ("", change))
        assert np.array_equal(plain.graph.measurement, wrong.graph.measurement)
        assert np.array_equal(plain.graph.information, wrong.honest.information)
        kind, _, factor = change.partition(" ")
        claims = np.maximum(wrong.graph.information, 1e-9)
        ratio = np.diagonal(plain.graph.information / claims, 0, 1, 2)
        claimed = np.ones_like(ratio)
        rows = plain.graph.is_odometry if kind == "odometry" else slice(None)
        claimed[rows, 2 if kind == "rotations" else 0 :] = FACTORS[factor] ** 2
        assert np.allclose(ratio, claimed)

    def test_slips_and_noisy_steps_are_odometry_that_honest_deviations_explain(self):
        for change, share in (("slips", SLIPS), ("noisy steps", round(NOISY * 199))):
            made = make(WORLD._replace(change=change))
            moved = np.any(made.graph.information != made.honest.information, axis=(1, 2))
            assert np.sum(moved) == share
            assert np.all(made.graph.is_odometry[moved])
            norms = pose_graph.residual_norms
            claimed, true = (norms(g, made.reference)[moved] for g in (made.graph, made.honest))
            assert np.median(claimed) > 2 * np.sqrt(3) > np.median(true)

    def test_one_group_is_half_to_twice_the_inliers(self):
        for percent, size in definition.ALIASED.items():
            made = make(World("manhattan", "aliased", percent, 0, "E"))
            closures = ~made.graph.is_odometry
            assert int(made.is_outlier.sum()) == size
            assert np.mean(made.is_outlier[closures]) == pytest.approx(percent / 100, abs=0.01)

    def test_a_place_recogniser_errs_where_corners_look_alike(self):
        few, many = (make(World("town", "recognised", percent, 0, "F")) for percent in (10, 50))
        assert 0 < 3 * few.is_outlier.sum() < many.is_outlier.sum()
        for made in (few, many):
            norms = pose_graph.residual_norms(made.graph, made.reference)
            right = ~made.is_outlier & ~made.graph.is_odometry
            assert np.median(norms[made.is_outlier]) > 10
            assert np.mean(norms[right] ** 2) == pytest.approx(3, rel=0.2)


class TestEntry:
    def test_the_awk_script_enters_as_dead_reckoning(self, tmp_path, monkeypatch, capsys):
        places = [("manhattan", "random", 10, 0), ("sphere", "local", 50, 1)]
        chosen = [World(*place) for place in places]
        for module in (entry, door):
            monkeypatch.setattr(module, "worlds", lambda tiers: chosen)
        monkeypatch.chdir(tmp_path)
        benchmarks = Path(door.__file__).parents[1]
        Path("benchmarks").symlink_to(benchmarks)
        entry.main(["write", "build/entry"])
        script = (benchmarks / "entries" / "dead_reckoning.awk").read_text()
        commands = "\n".join(re.findall("^#  (.*)", script, re.MULTILINE))
        subprocess.run(["sh", "-ec", commands], check=True)
        maps = Path("build/entry/awk")
        (maps / "seconds.csv").write_text(f"{entry.name_of(chosen[0])},0.5\n")
        entry.main(["score", str(maps), "--name", "awk", "--journal", "journal.jsonl"])
        said = capsys.readouterr().out.splitlines()
        assert [line.split()[-3:] for line in said[-3:]] == [[n, "of", "2"] for n in "022"]
        done = journal.read(Path("journal.jsonl"))
        assert done[chosen[0], "awk"].seconds == 0.5
        for world in chosen:
            known = methods.run("dead reckoning", make(world))
            assert done[world, "awk"].score.ate == pytest.approx(known.ate, rel=1e-6)
        (row,) = (one for one in rows(summary.tiers(done.values())) if one["method"] == "awk")
        assert (row["runs"], row["cpu"], row["cpu_ratio"]) == ("2", "", "")

    def test_a_missing_map_fails_and_a_g2o_map_is_read_and_a_short_one_refused(self, tmp_path):
        (run,) = entry.score_maps(tmp_path, "none", [WORLD])
        assert (run.score, run.failed) == (None, "no map")
        made = make(WORLD)
        path = tmp_path / f"{entry.name_of(WORLD)}.g2o"
        write(path, made.graph, made.reference)
        (run,) = entry.score_maps(tmp_path, "truth", [WORLD])
        assert run.score.ate == pytest.approx(0, abs=1e-9)
        path.write_text("VERTEX_SE2 0 0 0 0\n")
        with pytest.raises(ValueError, match="1 poses are there; the world has 200"):
            list(entry.score_maps(tmp_path, "short", [WORLD]))


class TestJournal:
    def test_half_a_line_and_another_sweep_are_dropped(self, tmp_path, monkeypatch):
        path = tmp_path / "deep" / "journal.jsonl"
        for run in (DONE, FAILED):
            journal.append(path, run)
        path.write_bytes(path.read_bytes()[:-30])
        assert list(journal.read(path)) == [DONE.key]
        journal.append(path, FAILED)
        assert journal.read(path) == {run.key: run for run in (DONE, FAILED)}
        monkeypatch.setitem(methods.PARAMETERS, "steps", methods.STEPS + 1)
        assert journal.read(path) == {}

    def test_a_sweep_that_was_killed_does_only_what_is_missing(self, tmp_path):
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
    def test_two_processes_find_what_one_finds(self):
        tasks: list[Task] = [(world, ("DCS",)) for world in (WORLD, WORLD._replace(seed=1))]
        alone, together = ({run.key: run.score for run in do(tasks, jobs)} for jobs in (1, 2))
        assert alone.keys() == together.keys()
        for key, score in alone.items():
            assert together[key].ate == pytest.approx(score.ate, rel=1e-6)

    def test_a_method_that_does_not_come_to_rest_is_noted(self, monkeypatch):
        def restless(*_: object) -> None:
            raise NotConverged

        monkeypatch.setitem(methods.METHODS, "restless", restless)
        (run,) = run_world(WORLD, ["restless"])
        assert (run.score, run.failed) == (None, "NotConverged")

    def test_a_run_over_the_limit_is_ended_and_noted(self, monkeypatch):
        def endless(*_: object) -> None:
            while True:
                time.process_time()

        monkeypatch.setitem(methods.METHODS, "endless", endless)
        slow, quick = run_world(WORLD, ["endless", "DCS"], limit=1)
        assert (slow.score, slow.failed, slow.seconds) == (None, "over 1 s", 1.0)
        assert quick.score is not None

    def test_an_error_that_nobody_expects_stops_the_sweep(self, monkeypatch, capfd):
        monkeypatch.setitem(methods.METHODS, "broken", lambda *_: 1 / 0)
        with pytest.raises(RuntimeError, match="broken in World"):
            list(run_world(WORLD, ["broken"]))
        assert "ZeroDivisionError" in capfd.readouterr().err


class TestTierTable:
    def test_a_row_compares_a_method_with_the_library_and_the_correct_edges(self):
        def run(method: str, seed: int, ate: float, **more: object) -> Run:
            place = WORLD._replace(seed=seed, tier="B")
            return Run(place, method, replace(SCORE, ate=ate, **more), 2.0)

        runs = [run(methods.ORACLE, seed, 0.15) for seed in range(3)]
        runs += [run(methods.GNC, seed, ate) for seed, ate in enumerate((0.25, 5.0, 0.35))]
        told = [(0.2, True, False), (0.2, False, True), (0.39, True, False)]
        runs += [
            run(methods.SOLVER, seed, ate, assured=assured, flagged=flagged)
            for seed, (ate, assured, flagged) in enumerate(told)
        ]
        found = {row["method"]: row for row in rows(summary.tiers(runs))}
        theirs, ours = found[methods.GNC], found[methods.SOLVER]
        assert [theirs[key] for key in ("good", "close", "won", "lost")] == ["2", "1", "0", "1"]
        assert [ours[key] for key in ("good", "close", "cpu_ratio")] == ["3", "2", "1"]
        told_columns = ("assured_wrong", "flagged", "flagged_close")
        assert [ours[key] for key in told_columns] == ["1", "1", "1"]
        assert [theirs[key] for key in told_columns] == ["", "", ""]

    def test_the_committed_table_is_of_this_sweep(self):
        committed = read_results(door.TIERS_TABLE)
        assert committed.header["version"] == digest()
        assert committed.names("tier") == list(TIERS)
        for tier in TIERS:
            for method in (methods.ORACLE, methods.SOLVER, methods.GNC):
                runs = sum(int(r["runs"]) for r in committed.where(tier=tier, method=method))
                assert runs == sum(1 for _ in worlds(tier)), (tier, method)

    def test_the_gates_of_the_solver_hold(self):
        committed = read_results(door.TIERS_TABLE)

        def total(column: str, tiers: str, method: str = methods.SOLVER) -> float:
            found = (committed.where(tier=tier, method=method) for tier in tiers)
            return sum(float(row[column] or 0) for each in found for row in each)

        assert total("good", "A") >= 388
        for tier, share in (("A", 0.99), ("B", 0.99), ("C", 0.9)):
            assert total("close", tier) >= share * total("close", tier, methods.ORACLE)
        assert total("assured_wrong", "ABCDE") <= 0.01 * total("runs", "ABCDE")
        # D has no gate here: a map whose odometry slipped is weak by design.
        assert total("flagged_close", "ABCE") <= 0.02 * total("close", "ABCE")
        others = total("close", "F", "DCS, then TLS")
        assert total("close", "F") >= others
        for tier in "ABC":
            own = committed.where(tier=tier, method=methods.SOLVER)
            # GNC's time in the same worlds and the same run.
            base = sum(float(row["cpu"]) / float(row["cpu_ratio"]) for row in own)
            assert total("cpu", tier) <= 5 * base


class TestTable:
    def test_a_row_says_what_came_of_its_runs_also_where_none_has_a_map(self):
        far = Run(WORLD._replace(seed=1), "DCS", Score(1.0, 0.75, 2.0, 4.0, 31), 4.0)
        none = Run(WORLD._replace(seed=2), "DCS", None, 9.0, "NotConverged")
        (row,) = rows(summary.text([DONE, far, none]))
        assert list(row.values()) == [
            *("manhattan", "random", "10", "DCS", "3", "1", "1"),
            *("0.75", "0.5", "1.062", "2", "4", "20"),
        ]
        (row,) = rows(summary.text([FAILED]))
        assert (row["failed"], row["good"], row["ate_worst"]) == ("1", "0", "")

    def test_rows_stay_that_the_journal_does_not_hold_whole(self, tmp_path, monkeypatch):
        tables = [tmp_path / "table.csv", tmp_path / "tiers.csv"]
        found: list[Mapping[str, object]] = []

        def written(number: int, *runs: Run) -> list[tuple[str, str]]:
            path = tmp_path / f"{number}.jsonl"
            for run in runs:
                journal.append(path, run)
            options = {"--journal": path, "--table": tables[0], "--tiers-table": tables[1]}
            door.main(["--write", *(f"{name}={file}" for name, file in options.items())])
            found.extend(read_results(table).header for table in tables)
            one, other = ([(r["method"], r["runs"]) for r in rows(t.read_text())] for t in tables)
            assert one == other
            return one

        seeds = [replace(DONE, world=WORLD._replace(seed=seed)) for seed in range(3)]
        first = replace(DONE, method="least squares")
        assert written(1, *seeds[:2]) == [("DCS", "2")]
        assert written(2, DONE, first) == [("least squares", "1"), ("DCS", "2")]
        assert [header["kept"] for header in found[2:]] == [{"manhattan": ["DCS"]}, {"A": ["DCS"]}]
        assert found[2]["runs"] == f"3 of {400 * len(methods.METHODS)}"
        assert written(3, *seeds) == [("least squares", "1"), ("DCS", "3")]
        monkeypatch.setattr(seal, "HASH", "of other seeds")
        for name in ("OPENED", "SEALED"):
            monkeypatch.setattr(seal, name, tmp_path / "none")
        assert written(4, first) == [("least squares", "1")]

    def test_the_committed_table_is_of_this_sweep_and_small(self):
        committed = read_results(door.TABLE)
        runs = sum(int(row["runs"]) for row in committed.rows)
        wanted = sum(1 for _ in worlds("A")) * len(methods.METHODS)
        assert committed.header["version"] == digest()
        assert committed.header["runs"] == f"{runs} of {wanted}"
        assert committed.header["parameters"].keys() > methods.PARAMETERS.keys()
        assert runs == wanted
        assert door.TABLE.stat().st_size <= 240 * 1024

    def test_a_row_of_the_committed_table_comes_out_again(self):
        method = "GNC-TLS from least squares"
        place = dict(zip(("graph", "kind", "percent"), map(str, WORLD), strict=False))
        wanted = (place | {"method": method}).items()
        table = rows(door.TABLE.read_text(encoding="utf-8"))
        (committed,) = (row for row in table if wanted <= row.items())
        seeds = range(int(committed["runs"]))
        again = [run for seed in seeds for run in run_world(WORLD._replace(seed=seed), [method])]
        (row,) = rows(summary.text(again))
        assert len(seeds) > 0
        assert all(row[key] == committed[key] for key in ("failed", "good"))
        for key in ("precision", "recall", "ate_median", "ate_worst"):
            assert float(row[key]) == pytest.approx(float(committed[key]), abs=2e-3)
