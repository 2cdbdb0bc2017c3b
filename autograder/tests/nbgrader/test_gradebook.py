"""The gradebook holds each case's points once, and follows the instructor's notebook."""

import contextlib
import shutil
import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest
from nbgrader.api import Base, Gradebook
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.nbgrader import database as place
from robust_slam_autograder.nbgrader import gradebook
from robust_slam_autograder.nbgrader.database import url_of

from .. import toy
from ..grading.disks import full_disk
from ..reports import samples
from . import course
from .course import FULL, marked, with_text

NAMES = ("double-by-hand", "double-random", "apply-by-hand", "apply-twice")


@pytest.fixture(scope="module")
def empty(tmp_path_factory):
    """A gradebook with nothing in it: to make one takes nbgrader a second."""
    path = tmp_path_factory.mktemp("empty") / "made" / "gradebook.db"
    gradebook.record(path, [], [])
    return path


@pytest.fixture
def database(empty, tmp_path):
    return Path(shutil.copy(empty, tmp_path / "gradebook.db"))


def test_every_case_has_its_points_and_every_exercise_its_message(database):
    refused, ada = samples.refused("why", student="eve"), marked("ada", [4, 0, 5, 5])
    double = replace(ada.exercises[0], message="Look at \x1b[31mred.")
    ada = replace(ada, exercises=(double, *ada.exercises[1:]))
    gradebook.record(database, [toy.assignment()], [ada, refused])
    said = course.rows(database, "comment")["ada"]
    assert said == {"double": "Look at \\x1b[31mred.", "apply": None}
    assert course.rows(database, "score") == {
        "ada": dict(zip(NAMES, [4, 0, 5, 5], strict=True)),
        "eve": dict.fromkeys(NAMES, 0),
    }
    with Gradebook(url_of(database)) as book:
        assert book.find_assignment(toy.NAME).max_score == 20
        assert book.find_submission(toy.NAME, "ada").score == 14
        assert not book.find_submission(toy.NAME, "ada").needs_manual_grade


def test_the_gradebook_follows_the_instructors_cases(database):
    gradebook.record(database, [toy.assignment()], [marked("ada", FULL)])
    value = toy.source_notebook()
    value["cells"][5]["metadata"]["nbgrader"]["grade_id"] = "apply-new"
    fewer = toy.assignment(value=value | {"cells": value["cells"][:6]})
    gradebook.record(database, [fewer], [marked("ada", FULL[:3], fewer)])
    marks = course.rows(database, "score")["ada"]
    assert marks == {"double-by-hand": 4, "double-random": 6, "apply-new": 5}


def test_nbgraders_own_gradebook_is_taken_over(database):
    with Gradebook(url_of(database)) as book:
        book.add_assignment(toy.NAME)
        book.add_notebook(toy.NAME, toy.NAME)
        book.add_grade_cell("double-random", toy.NAME, toy.NAME, max_score=1, cell_type="code")
        book.add_student("ada", first_name="Ada")
    gradebook.record(database, [toy.assignment()], [marked("ada", FULL)])
    assert sum(course.rows(database, "score")["ada"].values()) == 20
    with Gradebook(url_of(database)) as book:
        assert book.find_student("ada").first_name == "Ada"


def test_what_a_person_entered_is_never_lost(database):
    gradebook.record(database, [with_text()], [marked("ada", FULL)])
    course.enter(database, "ada", "why", 2)
    with Gradebook(url_of(database)) as book:
        book.find_comment("why", toy.NAME, toy.NAME, "ada").manual_comment = "Nearly."
        book.db.commit()
    value = course.source_notebook()
    value["cells"].append(toy.test_cell("assert double(1) == 2", "double-one", 7))
    more = toy.assignment(value=value)
    for again in (samples.refused("why"), marked("ada", [0] * 5, more)):
        gradebook.record(database, [more], [again])
        assert course.rows(database, "score")["ada"]["why"] == 2
        assert course.rows(database, "comment")["ada"]["why"] == "Nearly."


def test_a_region_that_is_not_closed_is_named(database):
    value = toy.source_notebook(double=toy.DOUBLE.replace("### END SOLUTION", ""))
    with pytest.raises(GraderFailure, match="no end solution statement"):
        gradebook.declare(database, toy.assignment(value=value))


def test_a_file_that_is_no_gradebook_is_named(tmp_path):
    database = tmp_path / "gradebook.db"
    database.write_text('{"no": "gradebook"}' * 100)
    with pytest.raises(GraderFailure, match=r"is not a database: .* \(mv \S+ \S+\.spoilt\)"):
        gradebook.record(database, [toy.assignment()], [marked("ada", FULL)])


def test_a_full_disk_is_one_sentence_without_names(database, caplog):
    with full_disk(20480), pytest.raises(GraderFailure, match="cannot be writ"):
        gradebook.record(database, [toy.assignment()], [marked("ada", FULL)])
    assert not caplog.records


def test_a_table_that_is_lost_is_noticed(database):
    gradebook.record(database, [toy.assignment()], [marked("ada", FULL)])
    with contextlib.closing(sqlite3.connect(database)) as book:
        book.execute("DROP TABLE grade")
    for use in (place.exists, place.recorded, place.make):
        with pytest.raises(GraderFailure, match=r"has lost its table grade: .*\.spoilt\)"):
            use(database)


def test_the_tables_are_nbgraders():
    assert set(Base.metadata.tables) == place.TABLES
