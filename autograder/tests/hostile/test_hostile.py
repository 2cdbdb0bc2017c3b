"""Hostile submissions: none gains a mark, learns a secret, harms a neighbour or stops a batch.

The suite runs against any assignment: here against the toy, in ``make soak`` against all of the
course's too.
"""

import contextlib
import dataclasses
import sqlite3
import subprocess
import sys
from collections import Counter

import pytest

from .. import correct, kernel, toy
from ..kernel import working
from . import batch, catalogue, leaks, verdict
from .batch import SEED, Report
from .entry import Entry
from .target import Target, load

pytestmark = pytest.mark.long


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """One assignment, or in ``make soak`` all."""
    if "assignment" in metafunc.fixturenames:
        more = batch.course_assignments() if kernel.is_soak(metafunc.config) else []
        metafunc.parametrize("assignment", [toy.NAME, *more], scope="module")


@pytest.fixture(scope="module")
def report(wall_name, assignment):
    """What became of a batch of all submissions, hostile and correct."""
    working(wall_name)
    return batch.attack(assignment, wall_name)


@pytest.fixture(scope="module")
def target(tmp_path_factory):
    folder = tmp_path_factory.mktemp("target")
    return load(toy.make_tree(folder), toy.NAME, folder / "release")


WRONGS = [field.name for field in dataclasses.fields(Report) if field.name != "submissions"]


@pytest.mark.sandbox
@pytest.mark.parametrize("wrong", WRONGS)
def test_of_all_submissions_none_is(report, wrong):
    """Hundreds are graded, of which many run into a limit. For each word see ``batch.Report``."""
    assert report.submissions == len(catalogue.entries())
    assert getattr(report, wrong) == ()


def test_names_are_unique_and_twins_and_baselines_are_there():
    names = Counter(entry.name for entry in catalogue.entries())
    assert names.most_common(1)[0][1] == 1
    assert len(catalogue.BASELINES) == 3
    twins = {entry.twin for entry in catalogue.ATTACKS if entry.twin}
    assert twins | {*catalogue.BASELINES} == {entry.name for entry in catalogue.PLAIN}


RIGHT_PART = {"apply-by-hand": 5, "apply-twice": 5}
ALL = {"double-by-hand": 4, "double-random": 6, **RIGHT_PART}
PLAIN = {"plain": RIGHT_PART, "double": {"double-by-hand": 4, **RIGHT_PART}}


def said(target: Target, mine: dict[str, float], bound: str, kind="values: nan", twin=None):
    """What the verdicts say of marks: inflated, under-graded, spilled."""
    entry = Entry("mallory", kind, bound, correct.plain, twin=twin)
    marks = PLAIN | {"mallory": mine}
    return [
        verdict.inflated(entry, marks, target, ["plain"]),
        verdict.under_graded(entry, marks, target),
        verdict.spilled(entry, marks, target, "plain"),
    ]


class TestTheSuiteCanFail:
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
    def test_what_a_bound_allows(self, target, bound, mine, is_inflated):
        assert bool(said(target, mine, bound)[0]) == is_inflated

    def test_what_a_twin_earns_is_allowed_and_lost_points_are_seen(self, target):
        assert not said(target, PLAIN["double"], "wrong", twin="double")[0]
        assert "double-random" in said(target, RIGHT_PART, "full")[1]
        assert not said(target, RIGHT_PART, "wrong")[1] and not said(target, ALL, "full")[1]
        lost = {"apply-by-hand": 5}
        assert "apply-twice" in said(target, lost, "wrong")[2]
        assert not said(target, lost, "wrong", kind="replaced: shell")[2]

    def test_hidden_lines_inputs_and_answers_are_secret(self, target):
        lines = leaks.hidden_lines(target)
        assert f"# {toy.CANARY}" in lines and not any("hint" in line for line in lines)
        found = leaks.drawn(target, SEED)
        drawn = leaks.case_generator(SEED, "double-random").normal(size=5)
        for value in [*drawn, *(2 * drawn)]:
            assert next(leaks.numbers(float(value))) in found

    def test_secrets_are_found_where_they_show(self, tmp_path):
        """The gradebook may hold a test; its comments, which students read, may not."""
        (tmp_path / "ada").mkdir()
        (tmp_path / "ada" / "feedback.html").write_text("you were given 0.123456789 there")
        (tmp_path / ".run.json").write_text("0.12345678")
        (tmp_path / "ada" / "page.html").write_text("assert a &lt; b")
        with contextlib.closing(sqlite3.connect(tmp_path / "gradebook.db")) as book:
            book.execute("create table comment (auto_comment, manual_comment)")
            book.execute("create table source_cell (source)")
            book.execute("insert into source_cell values ('assert a < b')")
            book.execute("insert into comment values (null, 'see assert a < b')")
            book.commit()
        texts = {"0.12345678": "a number", "assert a < b": leaks.HIDDEN_LINE}
        places = leaks.places(tmp_path, ["0.12345678 too"])
        found = leaks.numbers_shown(places, [{"0.87654321"}, {"0.12345678"}])
        assert found == ["a hidden number in output 0: 0.12345678"]
        assert leaks.shown(places, texts) == [
            "a number in ada/feedback.html: 0.12345678",
            "a line of a hidden test in ada/page.html: assert a < b",
            "a number in output 0: 0.12345678",
            "a line of a hidden test in the gradebook's comments: assert a < b",
        ]

    def test_changed_new_and_missing_files_are_seen(self, tmp_path):
        for name in ("same", "changed", "gone"):
            (tmp_path / name).write_text("1")
        before = batch.snapshot(tmp_path)
        (tmp_path / "changed").write_text("2")
        (tmp_path / "gone").unlink()
        (tmp_path / "new").symlink_to("same")
        assert batch.differences(before, batch.snapshot(tmp_path)) == ["changed", "gone", "new"]

    @pytest.mark.parametrize(
        "code",
        ["'mk-of-a-test'", "import ctypes; ctypes.CDLL(None).prctl(15, b'mk-of-a-' + b'test')"],
    )
    def test_a_process_that_lives_on_is_seen_by_its_command_or_its_name(self, code):
        command = [sys.executable, "-c", f"{code}\nprint('ready', flush=True); input()"]
        pipe = subprocess.PIPE
        with subprocess.Popen(command, stdin=pipe, stdout=pipe) as process:
            assert process.stdout and process.stdout.readline() == b"ready\n"
            assert len(batch.left_behind("mk-of-a-test")) == 1
            assert batch.left_behind("mk-of-nobody") == []
            process.communicate(b"\n")
