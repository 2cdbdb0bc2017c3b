"""The side of plain nbgrader: batches in containers, and what became of every submission."""

from __future__ import annotations

import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from robust_slam_autograder.grading.marking import SEED_VARIABLE

from benchmarks.attacks import container, evidence
from benchmarks.attacks.container import File, Outcome
from benchmarks.attacks.evidence import Secrets, Seen
from benchmarks.attacks.record import Record
from tests.autograder import correct
from tests.autograder.hostile import verdict
from tests.autograder.hostile.entry import Entry, Place
from tests.autograder.hostile.target import Target

SIDE = "nbgrader"
CONFIG = """\
c = get_config()
c.CourseDirectory.source_directory = "solutions"
c.ExecutePreprocessor.timeout = {seconds}
"""
FIRST, LAST = "ada", "neighbour-0"
"""The correct neighbours: nbgrader grades them before and after all others."""
MARK = "mk-of-an-attack"
_CURRENT = re.compile(r"Creating/updating student with ID '(.*)': \{\}$", re.MULTILINE)
_MARKS = """\
select submitted_assignment.student_id, base_cell.name,
       coalesce(grade.manual_score, grade.auto_score, 0)
from grade
join base_cell on base_cell.id = grade.cell_id
join submitted_notebook on submitted_notebook.id = grade.notebook_id
join submitted_assignment on submitted_assignment.id = submitted_notebook.assignment_id
"""
Group = tuple[Entry, ...]


@dataclass(frozen=True)
class Plain:
    """A course for nbgrader, from which each batch gets a copy."""

    template: Path
    target: Target
    secrets: Secrets
    environment: Mapping[str, str]
    cell_seconds: float

    @property
    def stall_seconds(self) -> float:
        """How long nbgrader may say nothing: each cell that may hang takes its time."""
        return 60 + 1.5 * self.cell_seconds * (2 + len(self.target.victim_cases))


@dataclass(frozen=True)
class Settled:
    """What a batch has shown, and what must be graded once more."""

    records: dict[str, Record] = field(default_factory=dict)
    again: tuple[Group, ...] = ()


def make(
    folder: Path, tree: Path, target: Target, secrets: Secrets, seed: int, seconds: int
) -> Plain:
    """Lay out a course with nbgrader's own command.

    Args:
        folder: where; it is not there yet.
        tree: the instructor's source tree.
        target: the assignment.
        secrets: what must not be told.
        seed: of the hidden inputs.
        seconds: for one cell.
    """
    shutil.copytree(tree / target.name, folder / "solutions" / target.name)
    (folder / "nbgrader_config.py").write_text(CONFIG.format(seconds=seconds))
    (folder / "outside").mkdir()
    (folder / "outside" / "notes.txt").write_text("a neighbour's notes")
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    command = [*_nbgrader("generate_assignment"), target.name]
    done = subprocess.run(
        command, cwd=folder, env=os.environ | {"PATH": path}, capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(f"nbgrader generate_assignment fails:\n{done.stderr[-2000:]}")
    environment = {SEED_VARIABLE: str(seed), "COURSE_TOKEN": secrets.token}
    return Plain(folder, target, secrets, environment, seconds)


def _nbgrader(verb: str) -> list[str]:
    return [sys.executable, "-m", "nbgrader", verb]


def groups(entries: Sequence[Entry], size: int) -> list[Group]:
    """Batches: what is likely to harm others stands alone, the rest together."""
    alone = [entry for entry in entries if entry.dangerous or entry.kind.startswith("others:")]
    rest = [entry for entry in entries if entry not in alone]
    together = [tuple(rest[n : n + size]) for n in range(0, len(rest), size)]
    return [*((entry,) for entry in alone), *together]


def grade(plain: Plain, group: Group, number: int) -> Settled:
    """Grade one batch between two neighbours."""
    with tempfile.TemporaryDirectory(prefix="nbgrader-", ignore_cleanup_errors=True) as folder:
        given = Path(folder)
        given.chmod(0o755)
        course = given / "course"
        _hand_in(plain, group, course)
        before = container.states(course)
        steps = [
            [*_nbgrader(verb), plain.target.name] for verb in ("autograde", "generate_feedback")
        ]
        outcome = container.run(
            given, steps, plain.environment, number=number, stall_seconds=plain.stall_seconds
        )
        return settle(plain, group, before, outcome)


def _hand_in(plain: Plain, group: Group, course: Path) -> None:
    shutil.copytree(plain.template, course)
    for student in (FIRST, LAST):
        correct.plain(plain.target, _place(course, student, plain.target))
    for entry in group:
        entry.write(plain.target, _place(course, student_of(entry), plain.target))


def _place(course: Path, student: str, target: Target) -> Place:
    return Place(course / "submitted" / student / target.name, container.COURSE, MARK)


def student_of(entry: Entry) -> str:
    """A folder's name that sorts between the neighbours'."""
    return f"m-{entry.name}"


def settle(
    plain: Plain, group: Group, before: Mapping[str, tuple[object, ...]], outcome: Outcome
) -> Settled:
    """Look at what became of a batch.

    Args:
        plain: the course.
        group: what was graded between the neighbours.
        before: the files that must not change.
        outcome: of the container.
    """
    marks = marks_of(outcome.files)
    hung = bool(outcome.hung) or not outcome.files
    stopped = "hung" if hung else "stopped" if marks and LAST not in marks else ""
    harmed = tuple(_harm(plain, group, marks, before, outcome, stopped))
    if len(group) == 1:
        return Settled({group[0].name: _record(plain, group[0], marks, outcome, harmed, stopped)})
    if harmed:
        return Settled(again=tuple((entry,) for entry in group))
    if not stopped:
        return Settled({e.name: _record(plain, e, marks, outcome) for e in group})
    return _without_the_culprit(plain, group, marks, outcome, stopped)


def _without_the_culprit(
    plain: Plain,
    group: Group,
    marks: Mapping[str, Mapping[str, float]] | None,
    outcome: Outcome,
    stopped: str,
) -> Settled:
    """Keep what was graded before a batch stopped; the others go on without the culprit."""
    order = sorted(group, key=student_of)
    names = _CURRENT.findall(outcome.log.read_text("utf-8", errors="replace"))
    at = next((n for n, e in enumerate(order) if names and student_of(e) == names[-1]), None)
    if at is None or 2 in outcome.hung:
        return Settled(again=tuple((entry,) for entry in group))
    records = {e.name: _record(plain, e, marks, outcome) for e in order[:at]}
    rest = tuple(order[at + 1 :])
    # Alone, the culprit shows whether it harms others too.
    return Settled(records, ((order[at],), *([rest] if rest else [])))


def marks_of(files: Mapping[str, File]) -> dict[str, dict[str, float]] | None:
    """Marks by student and grade id; None where the gradebook cannot be read."""
    if "gradebook.db" not in files:
        return None
    with tempfile.NamedTemporaryFile(suffix=".db") as copy:
        copy.write(files["gradebook.db"].data)
        copy.flush()
        found: dict[str, dict[str, float]] = {}
        try:
            with closing(sqlite3.connect(f"file:{copy.name}?mode=ro", uri=True)) as book:
                for student, cell, points in book.execute(_MARKS):
                    found.setdefault(student, {})[cell] = points
        except sqlite3.DatabaseError:
            return None
    return found


def _harm(
    plain: Plain,
    group: Group,
    marks: Mapping[str, Mapping[str, float]] | None,
    before: Mapping[str, tuple[object, ...]],
    outcome: Outcome,
    stopped: str,
) -> Iterator[str]:
    if not outcome.files:
        return
    if marks is None:
        yield "the gradebook cannot be read"
    neighbour = Entry("", "", "full", correct.plain)
    for student in (FIRST, LAST):
        mine = {"": (marks or {}).get(student, {})}
        lost = verdict.under_graded(neighbour, mine, plain.target)
        if marks is not None and lost and not (stopped and (student == LAST or not mine[""])):
            yield f"{student}{lost}"
    after = {path: file.state for path, file in outcome.files.items() if _is_watched(path)}
    own = f"submitted/{student_of(group[0])}/" if len(group) == 1 else None
    yield from (text for text in evidence.changes(before, after) if not own or own not in text)


def _is_watched(path: str) -> bool:
    return path.split("/")[0] in container.WATCHED


def _record(
    plain: Plain,
    entry: Entry,
    marks: Mapping[str, Mapping[str, float]] | None,
    outcome: Outcome,
    harmed: tuple[str, ...] = (),
    stopped: str = "",
) -> Record:
    student = student_of(entry)
    shown = evidence.found(_seen(outcome.files, student), plain.secrets)
    return Record((marks or {}).get(student, {}), shown, harmed, stopped)


def _seen(files: Mapping[str, File], student: str) -> Seen:
    """A student's feedback and the outputs of their graded notebook."""
    pages, told = [], []
    for path, file in files.items():
        folder, _, rest = path.partition("/")
        if not rest.startswith(f"{student}/"):
            continue
        if folder == "feedback" and path.endswith(".html"):
            pages.append(evidence.text_of_page(file.data))
        if folder == "autograded" and path.endswith(".ipynb"):
            every, own = evidence.outputs(file.data)
            pages.append(every)
            told.append(own)
    return Seen("\n".join(pages), "\n".join(told))


def seconds_for(plain: Plain, count: int, number: int) -> float:
    """Wall-clock seconds that nbgrader takes for so many right submissions, without feedback."""
    with tempfile.TemporaryDirectory(prefix="nbgrader-") as folder:
        given = Path(folder)
        given.chmod(0o755)
        _hand_in(plain, (), given / "course")
        for n in range(count - 2):
            correct.plain(plain.target, _place(given / "course", f"student-{n}", plain.target))
        began = time.monotonic()
        step = [*_nbgrader("autograde"), plain.target.name]
        outcome = container.run(
            given, [step], plain.environment, number=number, stall_seconds=plain.stall_seconds
        )
        seconds = time.monotonic() - began
        marks = marks_of(outcome.files) or {}
    if len(marks) != count:
        raise SystemExit(f"nbgrader graded {len(marks)} of {count} right submissions.")
    return seconds
