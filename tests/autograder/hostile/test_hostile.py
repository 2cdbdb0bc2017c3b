"""Hostile submissions: none gains a mark, learns a secret, harms a neighbour or stops a batch.

The suite runs against any assignment: here against the toy, with ``--soak`` against all of the
course's too.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import sqlite3
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests import kernel
from tests.autograder import correct, toy
from tests.autograder.hostile import batch, catalogue, kinds, leaks, verdict
from tests.autograder.hostile.batch import SEED, Report
from tests.autograder.hostile.entry import Entry, Place
from tests.autograder.hostile.target import Target, load

pytestmark = pytest.mark.long


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One assignment, or with ``--soak`` all."""
    if "assignment" in metafunc.fixturenames:
        more = batch.course_assignments() if metafunc.config.getoption("--soak") else []
        metafunc.parametrize("assignment", [toy.NAME, *more], scope="module")


@pytest.fixture(scope="module")
def report(wall_name: str, assignment: str) -> Report:
    """What became of a batch of all submissions, hostile and correct."""
    kernel.working(wall_name)
    return batch.attack(assignment, wall_name)


@pytest.fixture(scope="module")
def target(tmp_path_factory: pytest.TempPathFactory) -> Target:
    folder = tmp_path_factory.mktemp("target")
    return load(toy.make_tree(folder), toy.NAME, folder / "release")


WRONGS = [field.name for field in dataclasses.fields(Report) if field.name != "submissions"]


@pytest.mark.sandbox
@pytest.mark.parametrize("wrong", WRONGS)
def test_of_all_submissions_none_is(report: Report, wrong: str) -> None:
    """What each word means: see ``batch.Report`` and ``verdict``."""
    assert report.submissions == len(catalogue.entries())
    assert getattr(report, wrong) == ()


class TestTheSuite:
    def test_every_kind_has_a_submission(self) -> None:
        assert {entry.kind for entry in catalogue.ATTACKS} == set(kinds.KINDS)
        assert {entry.kind for entry in correct.CORRECT} == set(kinds.CORRECT)
        assert len(catalogue.ATTACKS) >= 120

    def test_names_are_unique_and_twins_and_baselines_are_there(self) -> None:
        names = Counter(entry.name for entry in catalogue.entries())
        assert names.most_common(1)[0][1] == 1
        assert len(catalogue.BASELINES) == 3
        twins = {entry.twin for entry in catalogue.ATTACKS if entry.twin}
        assert twins | {*catalogue.BASELINES} == {entry.name for entry in catalogue.PLAIN}

    def test_right_ones_run_beside_hostile_ones(self) -> None:
        flags = [entry in catalogue.ATTACKS for entry in catalogue.entries()]
        assert "0" * 3 not in "".join(str(int(flag)) for flag in flags)

    def test_every_submission_is_written_and_shows_no_hidden_test(
        self, target: Target, tmp_path: Path
    ) -> None:
        """No word of a template is left in any cell either."""
        words = ("<each>", "<end>", "<reference>", "<pipe>", "NAME", "RIGHT", "WITHHELD", "OWNER")
        for entry in catalogue.entries():
            folder = tmp_path / entry.name / toy.NAME
            entry.write(target, Place(folder, tmp_path, "mk-x"))
            assert folder.exists()
            path = folder / target.file
            if entry.kind.startswith(("broken", "others: a link", "files")) or not path.is_file():
                continue
            notebook = json.loads(path.read_bytes().decode("utf-8-sig"))
            text = "\n".join("".join(cell["source"]) for cell in notebook["cells"])
            assert not [word for word in words if word in text], entry.name
        lines = dict.fromkeys(leaks.hidden_lines(target), "a hidden line")
        assert leaks.shown(tmp_path, [], lines) == []


def entry(bound: str = "wrong", kind: str = "values: nan", twin: str | None = None) -> Entry:
    return Entry("mallory", kind, bound, correct.plain, twin=twin)  # type: ignore[arg-type]


RIGHT_PART = {"apply-by-hand": 5, "apply-twice": 5}
ALL = {"double-by-hand": 4, "double-random": 6, **RIGHT_PART}
PLAIN = {"plain": RIGHT_PART, "double": {"double-by-hand": 4, **RIGHT_PART}}


class TestTheVerdict:
    """The suite can fail: each rule says so of marks that break it."""

    @pytest.mark.parametrize(
        ("bound", "mine", "is_inflated"),
        [
            ("wrong", RIGHT_PART, False),
            ("wrong", RIGHT_PART | {"double-by-hand": 4}, True),
            ("less", RIGHT_PART | {"double-by-hand": 4}, False),
            ("less", ALL, True),
            ("refused", {}, False),
            ("refused", {"apply-twice": 5}, True),
            ("full", ALL, False),
            ("full", ALL | {"apply-twice": 6}, True),
            ("any", ALL | {"extra": 1}, True),
        ],
    )
    def test_what_a_bound_allows(
        self, target: Target, bound: str, mine: dict[str, float], is_inflated: bool
    ) -> None:
        marks = PLAIN | {"mallory": mine}
        assert bool(verdict.inflated(entry(bound), marks, target, ["plain"])) == is_inflated

    def test_a_twin_raises_what_is_allowed(self, target: Target) -> None:
        marks = PLAIN | {"mallory": PLAIN["double"]}
        assert verdict.inflated(entry(), marks, target, ["plain"])
        assert not verdict.inflated(entry(twin="double"), marks, target, ["plain"])

    def test_lost_points_are_seen(self, target: Target) -> None:
        marks = PLAIN | {"mallory": RIGHT_PART}
        assert "double-random" in verdict.under_graded(entry("full"), marks, target)
        assert not verdict.under_graded(entry("wrong"), marks, target)
        assert not verdict.under_graded(entry("full"), {"mallory": ALL}, target)

    def test_points_lost_elsewhere_are_seen(self, target: Target) -> None:
        marks = PLAIN | {"mallory": {"apply-by-hand": 5}}
        assert "apply-twice" in verdict.spilled(entry(), marks, target, "plain")
        assert not verdict.spilled(entry(kind="replaced: shell"), marks, target, "plain")


class TestWhatNobodyMayLearn:
    def test_hidden_lines_but_not_hints_are_secret(self, target: Target) -> None:
        lines = leaks.hidden_lines(target)
        assert f"# {toy.CANARY}" in lines
        assert not any("hint" in line for line in lines)

    def test_hidden_inputs_and_answers_are_secret(self, target: Target) -> None:
        found = leaks.secrets(target, SEED)
        drawn = leaks.case_generator(SEED, "double-random").normal(size=5)
        for value in [*drawn, *(2 * drawn)]:
            assert found[next(leaks.numbers(float(value)))] == "a hidden number"

    @pytest.mark.parametrize(
        ("value", "digits"),
        [
            (0.123456789, ["0.12345678"]),
            (-12.3456789012, ["12.345678"]),
            (0.000123456789012, ["0.00012345678"]),
            (1.23456789e-7, ["1.2345678"]),
            (1234567890.5, ["12345678"]),
            (1.25, []),
            ([0.5, (np.array([[1 / 3]]), {"a": 7})], ["0.33333333"]),
        ],
    )
    def test_first_digits(self, value: object, digits: list[str]) -> None:
        assert list(leaks.numbers(value)) == digits

    def test_they_are_found_where_they_show(self, tmp_path: Path) -> None:
        (tmp_path / "ada").mkdir()
        (tmp_path / "ada" / "feedback.html").write_text("you were given 0.123456789 there")
        (tmp_path / ".run.json").write_text("0.12345678")
        (tmp_path / "ada" / "page.html").write_text("assert a &lt; b")
        texts = {"0.12345678": "a number", "assert a < b": "a line"}
        found = leaks.shown(tmp_path, ["0.12345678 too"], texts)
        assert found == [
            "a number in ada/feedback.html: 0.12345678",
            "a line in ada/page.html: assert a < b",
            "a number in output 0: 0.12345678",
        ]

    def test_the_gradebook_may_hold_tests_but_no_comment_may(self, tmp_path: Path) -> None:
        with contextlib.closing(sqlite3.connect(tmp_path / "gradebook.db")) as book:
            book.execute("create table comment (auto_comment, manual_comment)")
            book.execute("create table source_cell (source)")
            book.execute("insert into source_cell values ('assert hidden, 0.12345678')")
            book.commit()
            texts = {"assert hidden": leaks.HIDDEN_LINE, "0.12345678": "a hidden number"}
            in_file = ["a hidden number in gradebook.db: 0.12345678"]
            assert leaks.shown(tmp_path, [], texts) == in_file
            book.execute("insert into comment values (null, 'see assert hidden')")
            book.commit()
        in_comment = "a line of a hidden test in the gradebook's comments: assert hidden"
        assert leaks.shown(tmp_path, [], texts) == [*in_file, in_comment]


class TestWhatIsLeftBehind:
    def test_changed_new_and_missing_files_are_seen(self, tmp_path: Path) -> None:
        for name in ("same", "changed", "gone"):
            (tmp_path / name).write_text("1")
        before = batch.snapshot(tmp_path)
        (tmp_path / "changed").write_text("2")
        (tmp_path / "gone").unlink()
        (tmp_path / "new").symlink_to("same")
        assert batch.differences(before, batch.snapshot(tmp_path)) == ["changed", "gone", "new"]

    @pytest.fixture(params=["by its command", "by its name"])
    def sleeper(self, request: pytest.FixtureRequest) -> Iterator[str]:
        mark = "mk-of-a-test"
        named = f"import ctypes; ctypes.CDLL(None).prctl(15, bytes({list(mark.encode())}))"
        code = f"'{mark}'" if request.param == "by its command" else named
        process = subprocess.Popen(
            [sys.executable, "-c", f"{code}\nprint('ready', flush=True); input()"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )
        assert process.stdout and process.stdout.readline() == b"ready\n"
        yield mark
        process.communicate(b"\n")

    def test_a_process_that_lives_on_is_seen(self, sleeper: str) -> None:
        assert len(batch.left_behind(sleeper)) == 1
        assert batch.left_behind("mk-of-nobody") == []
