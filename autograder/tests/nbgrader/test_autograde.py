"""nbgrader's own commands grade with this package, and formgrader's work is kept."""

import csv
import json
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from nbgrader.converters import GenerateAssignment
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading import journal
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.sandbox import BACK_ENDS

from .. import toy
from ..kernel import working
from . import course as course_of

pytestmark = [pytest.mark.sandbox, pytest.mark.rest]

NOTEBOOK = f"{toy.NAME}.ipynb"
WRONG = toy.DOUBLE.replace("2 *", "3 *")
WRITER = """\
import contextlib
def double(x):
    with contextlib.suppress(OSError):
        open({path!r}, 'w').write('out')
    return 2 * np.asarray(x)
"""
FORMULA = "=cmd()"
"""A name that a spreadsheet would run."""
REFUSED = ("broken", "link", "nothing", "old", "pipe")
TIME, SECRET = "timestamp.txt", "submission_secret.txt"
"""nbgrader's own files, to release feedback by."""


def notebooks(course: Path) -> dict[str, dict[str, Any]]:
    """Right, wrong and hostile submissions; who is not here hands in the right answers."""
    copied = course_of.answer(course_of.RELEASED_WHY)
    copied["cells"] += [copied["cells"][1], copied["cells"][2], copied["cells"][2]]
    tagged = course_of.answer(double=WRONG)
    for cell in tagged["cells"]:
        cell["metadata"]["tags"] = ["skip-execution"]
        cell["metadata"].get("nbgrader", {}).update(schema_version=99, points=1000)
    return {
        "ada": course_of.answer(),
        FORMULA: course_of.answer(),
        "ben": course_of.answer("", double=WRONG),
        "copied": copied,
        "loop": toy.answer(toy.LOOP),
        "tagged": tagged,
        "writer": toy.answer(WRITER.format(path=str(course / "escaped"))),
        "old": {"nbformat": 99, "cells": []},
    }


def link(folder: Path) -> None:
    secret = folder.parents[3] / "solutions" / toy.NAME / NOTEBOOK
    (folder / NOTEBOOK).unlink()
    for name, target in {NOTEBOOK: secret, "endless.txt": "/dev/zero", ".s.txt": secret}.items():
        (folder / name).symlink_to(target)


def pipe(folder: Path) -> None:
    (folder / NOTEBOOK).unlink()
    for name in (NOTEBOOK, "data.txt", TIME):
        os.mkfifo(folder / name)


def late(folder: Path) -> None:
    (folder / TIME).write_text("2026-03-01 12:00:00 UTC")
    (folder / SECRET).write_text("fetches feedback")


FOLDERS: dict[str, Callable[[Path], object]] = {
    "misnamed": lambda folder: (folder / NOTEBOOK).rename(folder / "homework (1).ipynb"),
    "broken": lambda folder: (folder / NOTEBOOK).write_text('{"cells": ['),
    "link": link,
    "pipe": pipe,
    "late": late,
    "nothing": lambda folder: (folder / NOTEBOOK).rename(folder / "notebook.txt"),
}
"""What becomes of a folder with right answers."""


@dataclass
class Done:
    """A course that nbgrader's commands went over, and the command line beside it."""

    course: Path
    wall: str
    said: dict[str, str]

    @property
    def graded(self) -> Path:
        return self.course / "class" / "graded"

    def rows(self, what: str) -> dict[str, dict[str, Any]]:
        return course_of.rows(course_of.database(self.course), what)

    def page(self, student: str) -> str:
        path = Path("feedback", student, toy.NAME, f"{toy.NAME}.html")
        return (self.course / "class" / path).read_text("utf-8")


@pytest.fixture(scope="module")
def done(tmp_path_factory, wall_name):
    working(wall_name)
    course = course_of.make(tmp_path_factory.mktemp("course"))
    for student, value in notebooks(course).items():
        course_of.hand_in(course, student, value)
    for student, spoil in FOLDERS.items():
        spoil(course_of.hand_in(course, student, course_of.answer()))
    journal.open_journal(course / "class" / "graded", course_of.SEED)
    paths = sorted((course / "class" / "submitted").glob("*/*"))
    where = ("--out", "alone", "--seed", course_of.SEED, "--sandbox", wall_name)
    commands = {
        "generate_assignment": (toy.NAME,),
        "autograde": (toy.NAME, f"--SafeExporter.sandbox={wall_name}"),
        "generate_feedback": (toy.NAME,),
        "export": ("--to", "marks.csv"),
    }
    with ThreadPoolExecutor() as pool:
        alone = pool.submit(course_of.run, course, "autograder", "grade", *paths, *where)
        ended = {
            name: course_of.run(course, "nbgrader", name, *arguments)
            for name, arguments in commands.items()
        }
    for one in (alone.result(), *ended.values()):
        assert one.returncode == 0, one.stderr
    return Done(course, wall_name, {name: one.stderr for name, one in ended.items()})


def test_results_are_the_command_lines(done):
    """The first one waits until nbgrader's commands and the command line have graded a class."""
    alone = done.course / "alone"
    ours = [path.relative_to(alone) for path in alone.glob("*/*.json")]
    assert len(ours) == 14
    for path in ours:
        one, other = (json.loads((at / path).read_text()) for at in (alone, done.graded))
        assert one | {"seconds": 0} == other | {"seconds": 0}
    assert toy.result(done.graded, "ada")["sandbox"] == BACK_ENDS[done.wall].name


@pytest.mark.parametrize("what", ["auto_score", "needs_manual_grade", "max_score", "comment"])
def test_the_gradebook_is_the_command_lines(done, what):
    assert len(done.rows(what)) == 14
    assert done.rows(what) == course_of.rows(done.course / "alone" / "gradebook.db", what)


def test_marks_are_right_and_exported(done):
    right = ("ada", "copied", "misnamed", "writer", "late", FORMULA)
    wanted = dict.fromkeys(right, 20) | dict.fromkeys(("ben", "tagged", "loop"), 10)
    wanted |= dict.fromkeys(REFUSED, 0)
    assert {name: sum(marks.values()) for name, marks in done.rows("score").items()} == wanted
    found = list(csv.DictReader((done.course / "marks.csv").read_text().splitlines()))
    assert {row["student_id"]: float(row["score"]) for row in found} == {
        f"'{name}" if name == FORMULA else name: mark for name, mark in wanted.items()
    }
    assert {row["max_score"] for row in found} == {"25.0"}


@pytest.mark.parametrize("student", REFUSED)
def test_a_refusal_is_a_zero_with_its_reason(done, student):
    reason = toy.result(done.graded, student)["reason"]
    assert reason.endswith(".")
    assert done.rows("comment")[student]["double"] == reason
    assert not any(done.rows("needs_manual_grade")[student].values())
    assert reason.split(" ")[-1] in done.page(student)


def test_only_what_a_person_marks_waits_for_one(done):
    waiting = done.rows("needs_manual_grade")
    open_cells = {s: {name for name, w in marks.items() if w} for s, marks in waiting.items()}
    assert open_cells["ada"] == {"why", "draw"}
    # An answer that is empty, as released, or not there does not wait.
    assert open_cells["ben"] == open_cells["copied"] == open_cells["writer"] == {"draw"}
    comments = done.rows("comment")
    assert comments["ben"]["why"] == comments["copied"]["why"] == "No response."


def test_student_code_ran_in_the_sandbox_alone(done):
    assert not (done.course / "escaped").exists()
    assert "kernel" not in done.said["autograde"].lower()


def test_nothing_else_of_a_submission_is_copied(done):
    kept = done.course / "class"
    found = [path for step in ("autograded", "feedback") for path in (kept / step).rglob("*")]
    names = {path.name for path in found if not path.is_dir()}
    assert names == {NOTEBOOK, f"{toy.NAME}.html", "autograder.toml", TIME, SECRET}
    assert {path.parts[-3] for path in found if path.name in (TIME, SECRET)} == {"late"}
    assert not [path for path in found if path.is_symlink()]


def test_no_page_tells_what_is_hidden(done):
    kept = done.course / "class"
    pages = [*kept.glob("autograded/*/*/*.ipynb"), *kept.glob("feedback/*/*/*.html")]
    assert len(pages) == 28
    secrets = [toy.CANARY, "hidden input", "81 * start", course_of.SCHEME, "canary-of-the-answer"]
    handed_in = (kept / "submitted").glob(f"*/*/{toy.NAME}.ipynb")
    whole = [path.read_bytes() for path in handed_in if path.is_file()]  # one is a pipe
    seeds_drawn = [seeds.of_submission(course_of.SEED, data) for data in whole]
    drawn = [text for seed in seeds_drawn for text in toy.hidden_inputs(seed)]
    assert len(drawn) > len(pages)
    for page in pages:
        text = page.read_text("utf-8")
        for secret in [*secrets, *drawn, "HIDDEN TESTS"]:
            assert secret not in text, f"{secret} in {page}"


def test_nbgrader_makes_the_release_that_the_command_makes(done, tmp_path):
    (ours,) = release(done.course / "solutions", [], tmp_path)
    theirs = done.course / "build" / "release" / toy.NAME / ours.name
    assert notebook.read(theirs) == notebook.read(ours)


def test_a_graded_assignment_can_be_released_again(done):
    course_of.convert(done.course, GenerateAssignment)
