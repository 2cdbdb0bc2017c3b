"""A mark by hand is one number wherever it is read, and outlives what is graded again."""

import csv
import re
import shutil
from pathlib import Path

import pytest
from nbgrader.apps import NbGraderAPI
from nbgrader.converters import GenerateFeedback
from nbgrader.coursedir import CourseDirectory
from robust_slam_autograder import cli
from robust_slam_autograder.nbgrader import totals
from robust_slam_autograder.nbgrader.own_files import read_warily
from robust_slam_autograder.nbgrader.settings import nbgrader_settings

from .. import toy
from ..conftest import Run
from . import course as course_of

NO_HALF = "def apply(f, x):\n    return f(x) + 1\n"
REASON = "The statement <b>says</b> nothing of *that*."
ROSTER = "First name,Email address\nAda,ada\nBob,bob\n"


@pytest.fixture(scope="module")
def once(tmp_path_factory):
    """A class of two with free text and a task that a person marks: Ada's ``apply`` is wrong."""
    made = course_of.make(tmp_path_factory.mktemp("class") / "course")
    folder = course_of.hand_in(made, "ada", course_of.answer(apply=NO_HALF))
    (folder / "timestamp.txt").write_text("2026-10-20 12:00:00 Europe/Berlin")
    course_of.hand_in(made, "bob", course_of.answer())
    (made / "roster.csv").write_text(ROSTER)
    paths = sorted(map(str, (made / "class" / "submitted").glob("*/*")))
    where = ["--unsandboxed", "--out", str(made / "class" / "graded")]
    assert cli.main(["--solutions", str(made / "solutions"), "grade", *paths, *where]) == 0
    return made


@pytest.fixture
def graded(once, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copytree(once, tmp_path, dirs_exist_ok=True))


@pytest.fixture
def mark(graded, autograder):
    return lambda *arguments: autograder("mark", "ada", toy.NAME, *arguments)


def everywhere(course: Path, autograder: Run) -> dict[str, tuple[float, float]]:
    """Ada's points and the most, as each door tells them."""
    assert autograder("feedback")[0] == autograder("report")[0] == 0
    assert autograder("export", "--format", "moodle", "--roster", "roster.csv")[0] == 0
    with (course / "class" / "moodle.csv").open(newline="") as file:
        exported = float(next(csv.DictReader(file))[toy.NAME])
    course_of.convert(course, GenerateFeedback, "ada")
    page = (course / "class" / "feedback" / "ada" / f"{toy.NAME}.html").read_text()
    nbgraders = (course / "class" / "feedback" / "ada" / toy.NAME / f"{toy.NAME}.html").read_text()
    of_student = (course / "class" / "report" / "students" / "ada.html").read_text()
    read_warily()
    config = nbgrader_settings(str(course))
    formgraders = NbGraderAPI(CourseDirectory(config=config), config=config)
    listed = formgraders.get_submissions(toy.NAME)
    (submission,) = [one for one in listed if one["student"] == "ada"]
    assert submission["autograded"]
    texts = {
        "feedback": re.search(r'big">([\d.]+)</span> of ([\d.]+) points', page),
        "nbgrader's feedback": re.search(r"\(Score: ([\d.]+) / ([\d.]+)\)", nbgraders),
        "report": re.search(r"<strong>([\d.]+) of ([\d.]+) points", of_student),
    }
    found = {door: (float(text[1]), float(text[2])) for door, text in texts.items() if text}
    found["formgrader"] = (submission["score"], submission["max_score"])
    return found | {"export": (exported, submission["max_score"])}


def test_every_door_tells_the_same_mark(graded, mark, autograder):
    assert set(everywhere(graded, autograder).values()) == {(10, 25)}
    status, out, _ = mark("apply", "+4", "--reason", REASON)
    assert status == 0 and "0 by the tests, +4 by hand: 4/10 points" in out
    assert mark("double", "-1.5", "--reason", "Copied.")[0] == 0
    course_of.enter(course_of.database(graded), "ada", "why", 2.25)
    found = everywhere(graded, autograder)
    assert len(found) == 5 and set(found.values()) == {(14.75, 25)}
    page = (graded / "class" / "feedback" / "ada" / f"{toy.NAME}.html").read_text()
    assert "The statement &lt;b&gt;says&lt;/b&gt; nothing of *that*." in page
    assert "2.25 of 3 points" in page and "not marked yet" in page and "-1.5 points" in page
    assert "`+4 points`" not in page and "<td>4 of 10 points</td>" in page
    report = (graded / "class" / "report" / f"{toy.NAME}.html").read_text()
    assert "Copied." in report and "of *that*." in report
    autograder("report", "--no-names")
    assert "Copied." not in (graded / "class" / "report" / f"{toy.NAME}.html").read_text()


def test_it_stays_when_tests_change_and_waits_for_another_look(graded, mark, autograder):
    mark("apply", "+4", "--reason", REASON)
    value = course_of.source_notebook()
    kept = [cell for cell in value["cells"] if cell["id"] != "apply-by-hand"]
    toy.write(graded / "solutions" / toy.NAME / f"{toy.NAME}.ipynb", value | {"cells": kept})
    value["cells"][-2]["source"] = "assert apply(abs, 1) == 2"
    toy.write(graded / "solutions" / toy.NAME / f"{toy.NAME}.ipynb", value)
    status, out, _ = autograder("regrade", toy.NAME, "--apply", "--unsandboxed")
    assert status == 0 and "ada 14 → 19, waits for a person" in out
    assert set(everywhere(graded, autograder).values()) == {(19, 25)}
    assert mark("apply", "+4", "--reason", REASON)[1].count("in place of +4") == 1
    rows = course_of.rows(course_of.database(graded), "needs_manual_grade")["ada"]
    assert {name for name, waits in rows.items() if waits} == {"why", "draw"}


def test_the_same_command_twice_adds_once_and_zero_takes_it_back(graded, mark):
    database = course_of.database(graded)
    for _ in range(2):
        assert mark("apply", "+4", "--reason", REASON)[0] == 0
    assert totals.read(database, toy.NAME).students["ada"].score == 14
    assert mark("apply", "0")[0] == 0
    assert totals.read(database, toy.NAME).students["ada"].score == 10
    assert REASON not in str(course_of.rows(database, "comment"))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("ada", toy.NAME, "apply", "+11", "--reason", "x"), "Say from +0 to +10."),
        (("ada", toy.NAME, "apply", "-1", "--reason", "x"), "would make -1"),
        (("ada", toy.NAME, "apply", "+1"), "needs its reason"),
        (("ada", toy.NAME, "apply", "+1", "--reason", " \n"), "needs its reason"),
        (("ada", toy.NAME, "aply", "+1", "--reason", "x"), "no exercise aply; it has double, ap"),
        (("eve", toy.NAME, "apply", "+1", "--reason", "x"), "no mark of eve in 07-toy"),
        (("ada", "08", "apply", "+1", "--reason", "x"), "has no assignment 08; it has 07-toy"),
        (("ada", toy.NAME, "apply", "nan", "--reason", "x"), "points are a number"),
        (("ada", toy.NAME, "double", "0", "--out", "no"), "There is no gradebook no/gradebook.db"),
    ],
)
def test_what_cannot_be_meant_is_refused_and_nothing_changes(graded, autograder, arguments, words):
    before = course_of.rows(course_of.database(graded), "score")
    assert autograder("mark", *arguments).refused(words)
    assert course_of.rows(course_of.database(graded), "score") == before


def test_a_score_that_was_entered_in_formgrader_is_not_written_over(graded, mark):
    course_of.enter(course_of.database(graded), "ada", "apply-twice", 3)
    status, _, err = mark("apply", "+1", "--reason", "x")
    assert status == 2 and "gave the case apply-twice 3 points in formgrader" in err
