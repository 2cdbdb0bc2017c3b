"""The gradebook as CSV: nbgrader's columns, and names that stay names."""

import csv
import warnings
from datetime import datetime
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from nbgrader.plugins import CsvExportPlugin
from robust_slam_autograder.markup import Grade, as_csv, as_text
from robust_slam_autograder.nbgrader import database
from robust_slam_autograder.nbgrader.spreadsheet import SafeCsv
from sqlalchemy.exc import SAWarning
from traitlets.config import Config

PLAIN = ("ada", "grace")
FORMULAS = ("=cmd()", "+1", "-1", "@SUM(1)", "＝1")
ODD = (*FORMULAS, "Hopper, Grace", 'the "boss"', "o'neill", "a=b")


@pytest.fixture(scope="module")
def gradebook(tmp_path_factory):
    """Two assignments, one of them handed in by some, with a late penalty."""
    path = tmp_path_factory.mktemp("csv") / "gradebook.db"
    database.make(path)  # nbgrader itself would start two processes for it
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
def test_for_plain_names_it_is_nbgraders_own_file(gradebook, tmp_path, assignment):
    options = {"student": list(PLAIN), "assignment": assignment}
    ours = exported(SafeCsv, gradebook, tmp_path / "marks.csv", **options)
    assert ours == exported(CsvExportPlugin, gradebook, tmp_path / "marks.csv", **options)
    assert len(ours.splitlines()) == (3 if assignment else 5)


def test_every_name_is_one_cell_of_text(gradebook, tmp_path):
    text = exported(SafeCsv, gradebook, tmp_path / "marks.csv", assignment=["02-b"])
    rows = {row["student_id"]: row for row in csv.DictReader(text.splitlines())}
    assert set(rows) == {*PLAIN, *ODD[len(FORMULAS) :], *(f"'{name}" for name in FORMULAS)}
    assert all(row["last_name"] == name for name, row in rows.items())
    assert {row["score"] for row in rows.values()} == {"0.0"}


@pytest.mark.parametrize("mark", ["=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠"])
def test_what_begins_as_a_formula_gets_an_apostrophe(mark):
    assert as_text(f"{mark}1") == f"'{mark}1"
    assert as_text(f"1{mark}") == f"1{mark}"
    row = as_csv([[f"{mark}1", None, -1.5, Grade("-3,5"), Grade(f"{mark}x")]])
    assert row.count("'") == (0 if mark == "\r" else 2), "a control character is its code"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("Ada;=cmd()", "Ada;'=cmd()"),
        ("Ada\t=cmd()", "Ada\t'=cmd()"),
        ("Ada\n@cmd()", "Ada\n'@cmd()"),
        ('Ada;"=cmd()"', 'Ada;\'"=cmd()"'),
        ("Ada; -1", "Ada;' -1"),
        (" =cmd()", "' =cmd()"),
        ("Lovelace, =Ada; a-b", "Lovelace, =Ada; a-b"),
    ],
)
def test_a_cell_that_another_separator_makes_is_no_formula_either(name, text):
    assert as_text(name) == text
    for separator in (";", "\t"):
        cells = next(csv.reader([text.replace("\n", " ")], delimiter=separator))
        assert not [cell for cell in cells if cell.strip().startswith(("=", "@", "-"))]
