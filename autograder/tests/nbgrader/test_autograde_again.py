"""What a person entered outlives every further run of nbgrader's and of the command line's."""

import contextlib
import json
from pathlib import Path

import pytest
from nbgrader.converters import Autograde
from nbgrader.converters.base import NbGraderException
from robust_slam_autograder import cli, sandbox
from robust_slam_autograder.grading import batch
from robust_slam_autograder.sandbox import Unsandboxed

from .. import kernel, toy
from . import course as course_of

pytestmark = pytest.mark.rest

WRONG = toy.DOUBLE.replace("2 *", "3 *")


@pytest.fixture
def course(tmp_path):
    """A course of the test's own, with one submission."""
    course_of.make(tmp_path)
    course_of.hand_in(tmp_path, "ada", course_of.answer())
    return tmp_path


def autograde(course: Path, student: str = "*") -> None:
    """What formgrader's button does, in this process."""
    is_open = "--unsandboxed" in toy.quickly()
    course_of.convert(course, Autograde, student, unsandboxed=is_open)


def grade(course: Path) -> None:
    submitted = course / "class" / "submitted"
    out = str(course / "class" / "graded")
    tree = ["--solutions", str(course / "solutions")]
    paths = map(str, sorted(submitted.glob("*/*")))
    assert cli.main([*tree, "grade", *paths, "--out", out, *toy.quickly()]) == 0


def scores(course: Path) -> dict[str, float]:
    return course_of.rows(course_of.database(course), "score")["ada"]


@pytest.mark.parametrize("again", [autograde, grade])
def test_manual_scores_stay(course, again):
    autograde(course)
    course_of.enter(course_of.database(course), "ada", "why", 2.5)
    course_of.enter(course_of.database(course), "ada", "double-by-hand", 1)
    course_of.hand_in(course, "ada", course_of.answer(double=WRONG))
    again(course)
    codes = {"double-by-hand": 1, "double-random": 0, "apply-by-hand": 5, "apply-twice": 5}
    assert scores(course) == codes | {"why": 2.5, "draw": 0}
    # As in nbgrader, they are put up for review.
    waiting = course_of.rows(course_of.database(course), "needs_manual_grade")["ada"]
    assert {name for name, w in waiting.items() if w} == {"why", "draw", "double-by-hand"}


@pytest.mark.parametrize("run", [autograde, grade])
def test_a_notebook_that_changes_meanwhile_counts_as_it_was_read(course, run, monkeypatch):
    """It replaces itself while it is graded, as a synchronised folder may do by chance."""
    monkeypatch.setattr(kernel, "quickest", Unsandboxed)  # no wall lets it
    path = course / "class" / "submitted" / "ada" / toy.NAME / f"{toy.NAME}.ipynb"
    later = json.dumps(course_of.answer("", double=WRONG))
    changes = f"open({str(path)!r}, 'w').write({later!r})\n"
    course_of.hand_in(course, "ada", course_of.answer("Mine.", double=changes + toy.DOUBLE))
    run(course)
    assert path.read_text() == later
    assert sum(scores(course).values()) == 20
    waiting = course_of.rows(course_of.database(course), "needs_manual_grade")["ada"]
    assert waiting["why"], "its answer was not empty when it was read"
    for made in (course / "class" / "autograded").rglob("*.ipynb"):
        text = made.read_text()
        assert "Mine." in text and "open(" in text


def test_the_command_line_and_formgrader_take_over_from_each_other(course, capsys):
    autograde(course)
    path = course / "class" / "graded" / "ada" / f"{toy.NAME}.json"
    first = path.read_text()
    grade(course)
    assert "1 of them unchanged and reused" in capsys.readouterr().out
    autograde(course)
    assert path.read_text() == first  # the seconds would differ


@pytest.mark.parametrize(
    ("prevented", "sentence"),
    [
        ("no sandbox", "No sandbox works .*it is not installed.*doctor"),
        ("another batch", "Another batch is at work"),
        ("a wrong setting", "unknown key 'limit'"),
    ],
)
def test_what_the_command_line_would_refuse_is_refused(course, monkeypatch, prevented, sentence):
    with contextlib.ExitStack() as stack:
        if prevented == "no sandbox":
            monkeypatch.setattr(sandbox, "BACK_ENDS", {"broken": toy.Broken()})
        elif prevented == "another batch":
            stack.enter_context(batch.locked(course / "class" / "graded"))
        else:
            toy.make_tree(course, "limit = 3\n")
        with pytest.raises(NbGraderException, match=sentence):
            autograde(course)
    assert not (course / "class" / "autograded").exists()


def test_one_button_grades_one_student(course):
    course_of.hand_in(course, "ben", course_of.answer())
    autograde(course, "ben")
    assert course_of.rows(course_of.database(course), "score").keys() == {"ben"}


def test_a_student_named_as_sqlites_own_file_is_left_out(course, caplog):
    course_of.hand_in(course, "gradebook.db-wal", course_of.answer())
    for _ in range(2):  # the folder of that name would stop the second run
        autograde(course)
    assert set(course_of.rows(course_of.database(course), "auto_score")) == {"ada"}
    assert "names no student" in caplog.text
