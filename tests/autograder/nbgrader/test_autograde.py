"""nbgrader's own commands grade with this package, and formgrader's work is kept."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest
from nbgrader.api import Gradebook
from robust_slam_autograder.grading import journal
from robust_slam_autograder.sandbox import BACK_ENDS

from tests import kernel
from tests.autograder import toy
from tests.autograder.nbgrader import course as course_of

pytestmark = pytest.mark.sandbox

WRONG = toy.DOUBLE.replace("2 *", "3 *")
LOOP = "def double(x):\n    while True: pass\n"
REFUSED = ("broken", "link", "nothing", "old", "pipe")


def writer(path: Path) -> str:
    """A right answer that writes a file where it can."""
    attempt = f"open({str(path)!r}, 'w').write('out')"
    return (
        "import contextlib\ndef double(x):\n    with contextlib.suppress(OSError):\n"
        f"        {attempt}\n    return 2 * np.asarray(x)\n"
    )


def hand_everything_in(course: Path) -> None:
    """Honest, broken and hostile submissions."""
    secret = course / "solutions" / toy.NAME / f"{toy.NAME}.ipynb"
    course_of.hand_in(course, "ada", course_of.answer())
    course_of.hand_in(course, "ben", course_of.answer("", double=WRONG))
    copied = course_of.answer(course_of.RELEASED_WHY)
    copied["cells"] += [copied["cells"][1], copied["cells"][2], copied["cells"][2]]
    course_of.hand_in(course, "copied", copied)
    course_of.hand_in(course, "loop", toy.answer(LOOP))
    tagged = course_of.answer(double=WRONG)
    for cell in tagged["cells"]:
        cell["metadata"]["tags"] = ["skip-execution"]
        cell["metadata"].get("nbgrader", {}).update(schema_version=99, points=1000)
    course_of.hand_in(course, "tagged", tagged)
    course_of.hand_in(course, "writer", toy.answer(writer(course / "escaped")))
    folder = course_of.hand_in(course, "misnamed", course_of.answer())
    (folder / f"{toy.NAME}.ipynb").rename(folder / "homework (1).ipynb")
    folder = course_of.hand_in(course, "broken", toy.answer())
    (folder / f"{toy.NAME}.ipynb").write_text('{"cells": [')
    course_of.hand_in(course, "old", {"nbformat": 99, "cells": []})
    folder = course_of.hand_in(course, "link", toy.answer())
    (folder / f"{toy.NAME}.ipynb").unlink()
    (folder / f"{toy.NAME}.ipynb").symlink_to(secret)
    (folder / "endless.txt").symlink_to("/dev/zero")
    (folder / ".solution.txt").symlink_to(secret)
    folder = course_of.hand_in(course, "pipe", toy.answer())
    (folder / f"{toy.NAME}.ipynb").unlink()
    os.mkfifo(folder / f"{toy.NAME}.ipynb")
    os.mkfifo(folder / "data.txt")
    os.mkfifo(folder / "timestamp.txt")
    folder = course_of.hand_in(course, "late", course_of.answer())
    (folder / "timestamp.txt").write_text("2026-03-01 12:00:00 UTC")
    (folder / "submission_secret.txt").write_text("fetches feedback")
    folder = course_of.hand_in(course, "undated", course_of.answer())
    (folder / "timestamp.txt").symlink_to("/dev/zero")
    pasted = "Mine: ![image.png](attachment:image.png)"
    course_of.hand_in(course, "pasted", course_of.answer(pasted))
    long = course_of.answer("\\begin{a}" * 60_000, double=toy.DOUBLE + "#" + "." * 10**6)
    course_of.hand_in(course, "long", long)
    folder = course_of.hand_in(course, "nothing", toy.answer())
    (folder / f"{toy.NAME}.ipynb").rename(folder / "notebook.txt")


@dataclass
class Done:
    """A course that nbgrader's commands went over, and the command line beside it."""

    course: Path
    wall: str
    said: dict[str, str]
    by_command_line: Path


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory, wall_name: str) -> Done:
    kernel.working(wall_name)
    course = course_of.make(tmp_path_factory.mktemp("course"))
    hand_everything_in(course)
    journal.open_run(course / "class" / "graded", course_of.SEED)
    wall = f"--SafeExporter.sandbox={wall_name}"
    said = {}
    for arguments in (
        ("generate_assignment", toy.NAME),
        ("autograde", toy.NAME, wall),
        ("generate_feedback", toy.NAME),
        ("export", "--to", "marks.csv"),
    ):
        ended = course_of.nbgrader(course, *arguments)
        assert ended.returncode == 0, ended.stderr
        said[arguments[0]] = ended.stderr
    paths = sorted((course / "class" / "submitted").glob("*/*"))
    where = ("--out", "alone", "--seed", course_of.SEED, "--sandbox", wall_name)
    ended = course_of.autograder(course, "grade", *paths, *where)
    assert ended.returncode == 0, ended.stderr
    return Done(course, wall_name, said, course / "alone")


def without_time(path: Path) -> dict[str, Any]:
    value: dict[str, Any] = json.loads(path.read_text("utf-8"))
    return value | {"seconds": 0}


def test_results_are_the_command_lines(done: Done) -> None:
    ours = sorted(done.by_command_line.glob("*/*.json"))
    assert len(ours) == 16
    for path in ours:
        theirs = done.course / "class" / "graded" / path.relative_to(done.by_command_line)
        assert without_time(theirs) == without_time(path)
    wall = toy.result(done.course / "class" / "graded", "ada")["sandbox"]
    assert wall == BACK_ENDS[done.wall].name


@pytest.mark.parametrize("what", ["auto_score", "needs_manual_grade", "max_score", "comment"])
def test_the_gradebook_is_the_command_lines(done: Done, what: str) -> None:
    theirs = course_of.rows(course_of.database(done.course), what)
    assert len(theirs) == 16
    assert theirs == course_of.rows(done.by_command_line / "gradebook.db", what)


def test_marks_are_right(done: Done) -> None:
    scores = course_of.rows(course_of.database(done.course), "score")
    assert {student: sum(marks.values()) for student, marks in scores.items()} == {
        **dict.fromkeys(("ada", "copied", "misnamed", "writer", "late", "undated"), 20),
        **dict.fromkeys(("pasted", "long"), 20),
        **dict.fromkeys(("ben", "tagged", "loop"), 10),
        **dict.fromkeys(REFUSED, 0),
    }
    with Gradebook(f"sqlite:///{course_of.database(done.course)}") as book:
        assert book.find_assignment(toy.NAME).max_score == 25


def test_export_writes_them(done: Done) -> None:
    lines = (done.course / "marks.csv").read_text().splitlines()
    names = lines[0].split(",")
    found = [dict(zip(names, line.split(","), strict=True)) for line in lines[1:]]
    assert {row["student_id"]: (row["score"], row["max_score"]) for row in found}["ben"] == (
        "10.0",
        "25.0",
    )
    assert len(found) == 16


@pytest.mark.parametrize("student", REFUSED)
def test_a_refusal_is_a_zero_with_its_reason(done: Done, student: str) -> None:
    reason = toy.result(done.course / "class" / "graded", student)["reason"]
    assert reason.endswith(".")
    comments = course_of.rows(course_of.database(done.course), "comment")[student]
    assert comments["double"] == reason
    waiting = course_of.rows(course_of.database(done.course), "needs_manual_grade")[student]
    assert not any(waiting.values())
    page = done.course / "class" / "feedback" / student / toy.NAME / f"{toy.NAME}.html"
    assert reason.split(" ")[-1] in page.read_text("utf-8")


def test_failed_cases_speak_to_the_student(done: Done) -> None:
    comments = course_of.rows(course_of.database(done.course), "comment")
    assert comments["ben"]["double"] == (
        "double(3) is 6: add the number to itself\nHere, double(3) returned 9; expected 6."
    )
    assert comments["ada"]["double"] is None
    assert "ran longer than it may" in comments["loop"]["double"]


def test_only_what_a_person_marks_waits_for_one(done: Done) -> None:
    waiting = course_of.rows(course_of.database(done.course), "needs_manual_grade")
    open_cells = {s: {name for name, w in marks.items() if w} for s, marks in waiting.items()}
    assert open_cells["ada"] == {"why", "draw"}
    # An answer that is empty, as released, or not there waits for nobody.
    assert open_cells["ben"] == open_cells["copied"] == open_cells["writer"] == {"draw"}
    comments = course_of.rows(course_of.database(done.course), "comment")
    assert comments["ben"]["why"] == comments["copied"]["why"] == "No response."


def test_student_code_ran_behind_the_wall_alone(done: Done) -> None:
    assert not (done.course / "escaped").exists()
    assert "kernel" not in done.said["autograde"].lower()


def test_a_time_is_taken_from_a_plain_file_alone(done: Done) -> None:
    with Gradebook(f"sqlite:///{course_of.database(done.course)}") as book:
        times = {s.student.id: s.timestamp for s in book.assignment_submissions(toy.NAME)}
    assert times["late"] == datetime(2026, 3, 1, 12)
    assert times["undated"] is times["pipe"] is None


def test_nothing_else_of_a_submission_is_copied(done: Done) -> None:
    kept = done.course / "class"
    found = [path for step in ("autograded", "feedback") for path in (kept / step).rglob("*")]
    names = {path.name for path in found if not path.is_dir()}
    own = {"timestamp.txt", "submission_secret.txt"}  # nbgrader's, to release feedback by
    assert names == {f"{toy.NAME}.ipynb", f"{toy.NAME}.html", "autograder.toml", *own}
    assert {path.parts[-3] for path in found if path.name in own} == {"late"}
    assert not [path for path in found if path.is_symlink()]


def test_no_page_tells_what_is_hidden(done: Done) -> None:
    kept = done.course / "class"
    pages = [*kept.glob("autograded/*/*/*.ipynb"), *kept.glob("feedback/*/*/*.html")]
    assert len(pages) == 32
    secrets = [toy.CANARY, "hidden input", "81 * start", course_of.SCHEME, "canary-of-the-answer"]
    for page in pages:
        text = page.read_text("utf-8")
        for secret in [*secrets, *toy.hidden_inputs(course_of.SEED), "HIDDEN TESTS"]:
            assert secret not in text, f"{secret} in {page}"


def test_feedback_says_how_each_case_went(done: Done) -> None:
    page = done.course / "class" / "feedback" / "ben" / toy.NAME / f"{toy.NAME}.html"
    text = page.read_text("utf-8")
    assert "✗ failed: 0 of 6 points\nTry negative numbers." in text
    assert "✓ passed: 5 of 5 points" in text
    assert "Score: 10.0 / 25.0" in text


def test_pasted_pictures_and_long_texts_have_their_pages(done: Done) -> None:
    pages = {
        student: (
            done.course / "class" / "feedback" / student / toy.NAME / f"{toy.NAME}.html"
        ).read_text("utf-8")
        for student in ("pasted", "long")
    }
    assert "Mine: (picture left out: image.png)" in pages["pasted"]
    assert "\\begin{a}" * 60_000 in pages["long"] and "." * 10**6 in pages["long"]


def test_a_graded_assignment_can_be_released_again(done: Done) -> None:
    ended = course_of.nbgrader(done.course, "generate_assignment", toy.NAME, "--force")
    assert ended.returncode == 0, ended.stderr
