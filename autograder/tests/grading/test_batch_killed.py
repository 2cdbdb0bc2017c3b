"""A batch that is killed again and again ends as one that never was."""

import json
import os
import sqlite3
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from .. import toy
from ..killing import kill, wait_until_empty

pytestmark = [pytest.mark.long, pytest.mark.rest]

SEED = 11
OWN_FILES = {".lock", ".run.json", ".run.log", "gradebook.db"}

ANSWERS = {
    "right": toy.DOUBLE,
    "guess": toy.GUESS,
    "loop": toy.LOOP,
    "exit": toy.EXIT,
    "child": "import os, sys\n"
    "wait = [sys.executable, '-c', 'import time; time.sleep(600)']\n"
    "os.posix_spawn(sys.executable, wait, {})\n" + toy.DOUBLE,
}
SHARES = dict.fromkeys(ANSWERS, 1) | {"right": 2}
SCORES = {"right": 20, "guess": 14, "loop": 10, "exit": 10, "child": 20, "half": 0, "nothing": 0}
SUBMISSIONS = 8


@pytest.fixture(scope="module")
def course(tmp_path_factory):
    """A course with submissions that end in each way."""
    root = tmp_path_factory.mktemp("course")
    toy.make_tree(root, "[limits]\ncall_seconds = 0.4\ncell_seconds = 2\n")
    submitted = root / "submitted"
    # Sorted by name the kinds are mixed.
    for kind, count in SHARES.items():
        for number in range(count):
            toy.hand_in(submitted, f"{number:02}-{kind}", toy.answer(ANSWERS[kind]))
    half = toy.hand_in(submitted, "00-half", {}) / f"{toy.NAME}.ipynb"
    half.write_text('{"nbformat": 4, "cells": [')
    (submitted / "01-nothing" / toy.NAME).mkdir(parents=True)
    assert len(list(submitted.iterdir())) == SUBMISSIONS
    return root


@pytest.fixture
def temporary():
    """The grader's own temporary folder; its path is short, for sockets lie in it."""
    with tempfile.TemporaryDirectory(prefix="t") as folder:
        Path(folder).chmod(0o711)
        yield Path(folder)


def start(course: Path, out: Path, temporary: Path, wall: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "robust_slam_autograder.cli"]
    command += ["--solutions", str(course / "solutions"), "grade"]
    command += [str(path) for path in sorted((course / "submitted").glob(f"*/{toy.NAME}"))]
    command += ["--out", str(out), "--jobs", "2", "--seed", str(SEED), "--sandbox", wall]
    pipes: Any = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    return subprocess.Popen(command, env=os.environ | {"TMPDIR": str(temporary)}, **pipes)


def finish(course: Path, out: Path, temporary: Path, wall: str) -> str:
    process = start(course, out, temporary, wall)
    said, complaint = process.communicate()
    assert process.returncode == 0, complaint
    return said


def results(out: Path) -> dict[str, Any]:
    """All result files by student, without the time that it took."""
    return {
        path.parent.name: json.loads(path.read_text("utf-8")) | {"seconds": 0}
        for path in out.glob(f"*/{toy.NAME}.json")
    }


def gradebook(out: Path) -> list[tuple[Any, ...]]:
    """Every row of a mark, with whose it is and for what."""
    query = """
        select student_id, base_cell.name, auto_score from grade
        join base_cell on grade.cell_id = base_cell.id
        join submitted_notebook on grade.notebook_id = submitted_notebook.id
        join submitted_assignment on submitted_notebook.assignment_id = submitted_assignment.id
        order by student_id, base_cell.name
    """
    with sqlite3.connect(out / "gradebook.db") as connection:
        assert len(list(connection.execute("select * from alembic_version"))) == 1
        return list(connection.execute(query))


@pytest.mark.sandbox
def test_a_batch_that_is_killed_ends_as_one_that_is_not(course, tmp_path, temporary, wall_name):
    """The class is graded four times, each time by a new process; two of these are killed."""
    whole, out, mark = tmp_path / "whole", tmp_path / "killed", str(temporary)
    finish(course, whole, temporary, wall_name)
    assert {student[3:]: result["score"] for student, result in results(whole).items()} == SCORES

    def kill_when(when: Callable[[], bool]) -> None:
        kill(start(course, out, temporary, wall_name), when, mark)

    kill_when(lambda: len(list(out.glob(f"*/{toy.NAME}.json"))) >= 3)
    found = results(out)
    assert found and all(found[student] == results(whole)[student] for student in found)
    assert not (out / "gradebook.db").exists()
    kill_when(lambda: (out / "gradebook.db").exists())

    assert "of them unchanged and reused" in finish(course, out, temporary, wall_name)
    assert results(out) == results(whole)
    assert gradebook(out) == gradebook(whole) and len(gradebook(out)) == SUBMISSIONS * 4
    files = {path.name for path in out.rglob("*") if path.is_file()}
    assert files == OWN_FILES | {f"{toy.NAME}.json"}
    wait_until_empty(temporary)
