"""The side of this course's grader: one batch, and what became of every submission."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.attacks import evidence
from benchmarks.attacks.evidence import Secrets, Seen
from benchmarks.attacks.record import Record
from tests.autograder import correct
from tests.autograder.hostile import batch, catalogue, verdict
from tests.autograder.hostile.batch import Course
from tests.autograder.hostile.entry import Entry

SIDE = "autograder"
UNKNOWN = "(somebody)"
"""Harm in a batch of many has no known author: it counts, under this name."""
WRITERS = ("out", "feedback")


@dataclass(frozen=True)
class How:
    """Options of the batch."""

    tree: Path
    name: str
    seed: int
    secrets: Secrets
    cell_seconds: int
    jobs: int
    back_end: str | None

    @property
    def limits(self) -> str:
        """Lines of the settings: the time for a cell is nbgrader's."""
        seconds = self.cell_seconds
        whole = f"notebook_seconds = {20 * seconds}\n"
        return f"call_seconds = {seconds}\ncell_seconds = {seconds}\n{whole}"


def grade(how: How, entries: Sequence[Entry]) -> dict[str, Record]:
    """Grade all submissions beside their neighbours, and write the students' pages."""
    with tempfile.TemporaryDirectory(prefix="autograder-", ignore_cleanup_errors=True) as folder:
        course = batch.make(Path(folder), how.tree, how.name, how.limits)
        everybody = [*catalogue.neighbours(), *entries]
        batch.write(course, everybody)
        before = batch.snapshot(course.root)
        status = _run(how, course, everybody)
        found = _records(how, course, entries)
        harmed = evidence.changes(before, batch.snapshot(course.root))
        harmed += batch.left_behind(course.mark)
        harmed += _neighbours(course)
    if harmed or status:
        found[UNKNOWN] = Record({}, (), tuple(harmed), "stopped" if status else "")
    return found


def _run(how: How, course: Course, entries: Sequence[Entry]) -> int:
    """Exit status of the grader and of the pages' writer, the first that is not 0."""
    grader = [sys.executable, "-m", "robust_slam_autograder.cli"]
    grader += ["--solutions", str(course.root / "solutions")]
    paths = [str(course.folder(entry)) for entry in entries]
    options = ["--out", str(course.out), "--jobs", str(how.jobs), "--seed", str(how.seed)]
    options += ["--sandbox", how.back_end] if how.back_end else []
    environment = os.environ | {batch.TOKEN_VARIABLE: how.secrets.token}
    pages = [*grader, "feedback", "--out", str(course.out), "--to", str(course.pages)]
    for command in ([*grader, "grade", *paths, *options], pages):
        done = subprocess.run(command, cwd=course.root, env=environment, stdout=subprocess.DEVNULL)
        if done.returncode:
            return done.returncode
    return 0


def _records(how: How, course: Course, entries: Sequence[Entry]) -> dict[str, Record]:
    results = batch.results(course, entries)
    records = {}
    for entry in entries:
        value = results.get(entry.name)
        if value is None or value["status"] == "failed":
            records[entry.name] = Record({}, stopped="stopped")
            continue
        shown = evidence.found(_seen(course, entry), how.secrets)
        records[entry.name] = Record(batch.earned(value, course.target), shown)
    return records


def _seen(course: Course, entry: Entry) -> Seen:
    """A student's result and page: all words in them are the grader's or the submission's."""
    files = [path for folder in WRITERS for path in (course.root / folder / entry.name).rglob("*")]
    text = "\n".join(evidence.text_of_page(path.read_bytes()) for path in files if path.is_file())
    return Seen(text, text)


def _neighbours(course: Course) -> list[str]:
    plain = catalogue.neighbours()
    results = batch.results(course, plain)
    marks = {name: batch.earned(value, course.target) for name, value in results.items()}
    said = (verdict.under_graded(entry, marks, course.target) for entry in plain)
    return [sentence for sentence in said if sentence]


def seconds_for(how: How, count: int) -> float:
    """Wall-clock seconds for so many right submissions, one stream, both passes."""
    with tempfile.TemporaryDirectory(prefix="autograder-") as folder:
        course = batch.make(Path(folder), how.tree, how.name, how.limits)
        right = [Entry(f"student-{n}", "", "full", correct.plain) for n in range(count)]
        batch.write(course, right)
        grader = [sys.executable, "-m", "robust_slam_autograder.cli", "--solutions"]
        paths = [str(course.folder(entry)) for entry in right]
        options = ["--out", str(course.out), "--jobs", "1", "--seed", str(how.seed)]
        options += ["--sandbox", how.back_end] if how.back_end else []
        began = time.monotonic()
        command = [*grader, str(course.root / "solutions"), "grade", *paths, *options]
        subprocess.run(command, cwd=course.root, stdout=subprocess.DEVNULL, check=True)
        return time.monotonic() - began
