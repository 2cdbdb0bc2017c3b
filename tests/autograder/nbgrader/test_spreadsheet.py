"""The gradebook as CSV: nbgrader's columns, and names that stay names."""

from __future__ import annotations

import csv
import warnings
from datetime import datetime
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from nbgrader.plugins import CsvExportPlugin
from robust_slam_autograder.nbgrader.spreadsheet import SafeCsv, as_text
from sqlalchemy.exc import SAWarning
from traitlets.config import Config

from tests.autograder.nbgrader import course as course_of

PLAIN = ("ada", "grace")
FORMULAS = ("=cmd()", "+1", "-1", "@SUM(1)", "＝1")
ODD = (*FORMULAS, "Hopper, Grace", 'the "boss"', "o'neill", "a=b")


@pytest.fixture(scope="module")
def gradebook(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two assignments, one of them handed in by some, with a late penalty."""
    path = tmp_path_factory.mktemp("csv") / "gradebook.db"
    with warnings.catch_warnings(), Gradebook(f"sqlite:///{path}") as book:
        warnings.simplefilter("ignore", SAWarning)  # nbgrader's own
        for name in ("01-a", "02-b"):
            book.add_assignment(name, duedate=datetime(2026, 3, 1, 12))
        for student in (*PLAIN, *ODD):
            book.add_student(student, last_name=student, email=None)
        book.add_submission("01-a", "ada").late_submission_penalty = 2.0
        book.add_submission("02-b", "=cmd()")
        book.db.commit()
    return path


def exported(plugin: type, gradebook: Path, to: Path, **options: list[str]) -> str:
    settings = Config({"ExportPlugin": {"to": str(to), **options}})
    with Gradebook(f"sqlite:///{gradebook}") as book:
        plugin(config=settings).export(book)
    return to.read_text(encoding="utf-8")


@pytest.mark.parametrize("assignment", [[], ["01-a"]])
def test_for_plain_names_it_is_nbgraders_own_file(
    gradebook: Path, tmp_path: Path, assignment: list[str]
) -> None:
    options = {"student": list(PLAIN), "assignment": assignment}
    ours, theirs = (
        exported(plugin, gradebook, tmp_path / "marks.csv", **options)
        for plugin in (SafeCsv, CsvExportPlugin)
    )
    assert ours == theirs
    assert len(ours.splitlines()) == (3 if assignment else 5)


def test_every_name_is_one_cell_of_text(gradebook: Path, tmp_path: Path) -> None:
    text = exported(SafeCsv, gradebook, tmp_path / "marks.csv", assignment=["02-b"])
    rows = {row["student_id"]: row for row in csv.DictReader(text.splitlines())}
    assert set(rows) == {*PLAIN, *ODD[len(FORMULAS) :], *(f"'{name}" for name in FORMULAS)}
    assert all(row["last_name"] == name for name, row in rows.items())
    assert {row["score"] for row in rows.values()} == {"0.0"}


@pytest.mark.parametrize("mark", ["=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠"])
def test_what_begins_as_a_formula_gets_an_apostrophe(mark: str) -> None:
    assert as_text(f"{mark}1") == f"'{mark}1"
    assert as_text(f"1{mark}") == f"1{mark}"
    assert as_text("") == "" and as_text(None) is None


def test_nbgraders_export_writes_it_and_the_gradebook_keeps_the_name(tmp_path: Path) -> None:
    course = course_of.make(tmp_path)
    with Gradebook(f"sqlite:///{_made(course)}") as book:
        book.add_assignment("01-a")
        book.add_student("=cmd()")
    assert course_of.nbgrader(course, "export").returncode == 0
    assert "01-a,,,'=cmd(),,,,0.0,0.0,0.0,0.0\n" in (course / "grades.csv").read_text("utf-8")
    with Gradebook(f"sqlite:///{_made(course)}") as book:
        assert [student.id for student in book.students] == ["=cmd()"]


def _made(course: Path) -> Path:
    path = course_of.database(course)
    path.parent.mkdir(parents=True, exist_ok=True)
    return path
