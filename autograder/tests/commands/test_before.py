"""A class that began with an older version: its results, its gradebook and its release count."""

import contextlib
import json
import sqlite3
from pathlib import Path

import pytest
from robust_slam_autograder.grading import results
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading.submission import DATABASE_NAME

from .. import toy
from ..nbgrader import course as course_of

BEFORE = Path(__file__).parents[1] / "grading" / "first_schema.json"
"""Results of schema 1, as commit 8c0c81c wrote them."""
CLOSE = "def close(got, want):\n    assert np.allclose(got, want), 'they differ'\n"


@pytest.fixture
def old(course):
    """The course with results and a journal of before."""
    out = course / "out"
    for value in json.loads(BEFORE.read_text("utf-8")):
        path = results.path_of(out, value["student"], value["assignment"])
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps(value), encoding="utf-8")
    (out / ".run.json").write_text('{"seed": 3}\n')
    (out / ".run.log").write_text(f'["graded", "ada/{toy.NAME}", "older"]\n["other", "line"]\n')
    return course


@pytest.mark.parametrize("command", ["feedback", "report"])
def test_results_of_before_have_their_pages(old, autograder, command):
    status, _, err = autograder(command, "--out", old / "out", "--to", old / "pages")
    assert (status, err) == (0, "")
    pages = [path.read_text("utf-8") for path in (old / "pages").rglob("*.html")]
    assert "Your function raised ValueError" in "".join(pages)


def test_a_gradebook_of_before_goes_on(old, autograder):
    """It holds no note of which results it has, as one that nbgrader itself has made."""
    where = ("grade", *sorted((old / "submitted").glob("*/*")), "--out", old / "out")
    assert autograder(*where, *toy.quickly())[0] == 0
    book = old / "out" / DATABASE_NAME
    course_of.enter(book, "ada", "double-random", 1)
    with contextlib.closing(sqlite3.connect(book)) as opened:
        opened.execute("DROP TABLE autograder_recorded")
        opened.execute("UPDATE grade SET auto_score = 0")
        opened.commit()
    assert autograder(*where, *toy.quickly())[0] == 0
    marks = course_of.rows(book, "score")
    assert sum(marks["bob"].values()) == toy.MOST and sum(marks["ada"].values()) == toy.MOST - 5
    assert toy.result(old / "out", "ada")["schema"] == results.SCHEMA


def test_a_notebook_of_an_older_release_is_graded_and_checked(course, autograder):
    """Its set-up cell lacks what the tests of now call."""
    by_hand = toy.test_cell("close(double(3), 6)\n", "double-by-hand", 4)["source"]
    value = toy.source_notebook(setup=toy.SETUP + CLOSE, double_by_hand=by_hand)
    toy.make_tree(course, value=value)
    release(course / "solutions", [], course / "release")
    own = course / "submitted" / "ada" / toy.NAME / f"{toy.NAME}.ipynb"
    assert "close" not in own.read_text("utf-8")
    where = ("--out", course / "out", *toy.quickly(), "--seed", 1)
    assert autograder("grade", own.parent, *where)[0] == 0
    assert toy.result(course / "out", "ada")["score"] == toy.MOST
    assert autograder("check", own).refused("stands alone", "--release FOLDER")
    assert autograder("check", own, "--release", course / "release").worked("✓ passed   double")
