"""Grades a batch: one trusted process per submission, one result file each, one seed for all.

A batch that was stopped goes on where it stood: a submission whose text, tests
and seed have not changed keeps its result.
"""

from __future__ import annotations

import contextlib
import fcntl
import functools
import hashlib
import os
import sys
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol

import robust_slam_autograder
from robust_slam_autograder.errors import GraderFailure, Refused, WrongUse
from robust_slam_autograder.executor import trusted
from robust_slam_autograder.executor.budget import WALL_FACTOR
from robust_slam_autograder.executor.trusted import Broken
from robust_slam_autograder.grading import marking, results
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.grading.results import Result, Status
from robust_slam_autograder.reading import answers, notebook, submission
from robust_slam_autograder.reading.assignment import CONFIG_NAME, Assignment
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reading.source import imported_modules, needed
from robust_slam_autograder.sandbox import Sandbox, packages

LOCK_NAME = ".lock"
PRELOAD = ("numpy", "scipy.special", __name__)
GRACE_SECONDS = 60.0
"""What a submission may take beyond its own limit before its trusted process is ended."""


@dataclass(frozen=True)
class Handed:
    """What a submission holds, read once: where it is does not matter any more."""

    name: str = ""
    """The notebook's, with its ending."""
    data: bytes = b""
    notes: tuple[str, ...] = ()
    """Sentences on what was found in an unusual place."""
    refusal: str = ""
    """Why it could not be read; empty where it could."""

    def cells(self) -> tuple[Cell, ...]:
        """Return the notebook's cells.

        Raises:
            Refused: it could not be read, or is no notebook.
        """
        if self.refusal:
            raise Refused(self.refusal)
        return notebook.parse(self.data, notebook.shown(self.name))


@dataclass(frozen=True)
class Job:
    """One submission to grade."""

    student: str
    assignment: Assignment
    tests: Path
    """The instructor's notebook."""
    path: Path
    """The submission's notebook, or its folder ``submitted/<student>/<assignment>/``."""
    handed: Handed | None = None
    """What was read there already; None where it is read when its turn comes."""

    @property
    def key(self) -> str:
        """Name of the submission in the batch."""
        return f"{self.student}/{self.assignment.name}"


@dataclass(frozen=True)
class Task:
    """A submission as it was read, and the digest of all that its result depends on."""

    job: Job
    handed: Handed
    fingerprint: str


@dataclass(frozen=True)
class Terms:
    """What is the same for every submission of a batch."""

    seed: int
    wall: Sandbox
    """Where student code runs."""
    preload: tuple[str, ...]
    """Modules that trusted processes need."""


class Graders(Protocol):
    """Who grades: processes of this machine, or the workers of a cluster."""

    def grade(
        self, tasks: Iterable[Task], terms: Terms, *, at_once: int
    ) -> Iterator[tuple[Task, Result | Broken]]:
        """Grade tasks, taken one by one, and give the answers as they come.

        Args:
            tasks: the submissions.
            terms: what they are graded with.
            at_once: how many; with 1 each is graded alone on its machine.
        """


class Processes:
    """Grades in trusted processes of this machine."""

    def grade(
        self, tasks: Iterable[Task], terms: Terms, *, at_once: int
    ) -> Iterator[tuple[Task, Result | Broken]]:
        """Grade each task in a process of its own."""
        return trusted.run_each(
            tasks,
            functools.partial(grade_task, seed=terms.seed, wall=terms.wall),
            at_once=at_once,
            seconds=patience,
            preload=terms.preload,
        )


@dataclass(frozen=True)
class Graded:
    """What became of one submission; its result stays on the disk until it is asked for."""

    path: Path
    """The result's file."""
    status: Status
    reused: bool
    """Whether it was kept from an earlier run."""

    def load(self) -> Result:
        """Read the result from its file."""
        return results.read(self.path)


@contextlib.contextmanager
def locked(out: Path) -> Iterator[None]:
    """Lock the results' folder against a second batch; a killed batch releases it.

    Raises:
        WrongUse: another batch is at work there, or nothing can be written there.
    """
    try:
        out.mkdir(parents=True, exist_ok=True)
        descriptor = os.open(out / LOCK_NAME, os.O_WRONLY | os.O_CREAT, 0o644)
    except OSError as error:
        raise WrongUse(
            f"Nothing can be written to {out} ({error.strerror}): "
            "make it a writable folder, or choose another with --out."
        ) from error
    with open(descriptor, "w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise WrongUse(f"Another batch is at work in {out}: wait for its end.") from error
        yield


def grade(
    jobs: Sequence[Job],
    *,
    out: Path,
    run: Journal,
    wall: Sandbox,
    workers: int,
    report: Callable[[Graded], None],
    graders: Graders | None = None,
) -> list[Graded]:
    """Grade submissions, writing each result as it comes.

    Args:
        jobs: the submissions.
        out: folder of the result files.
        run: the batch, from ``journal.open_journal``; it is kept up to date.
        wall: where student code runs.
        workers: how many submissions at once.
        report: called after each submission.
        graders: who grades; by default processes of this machine.

    Returns:
        what became of each submission, in the order of ``jobs``.

    Raises:
        GraderFailure: a result cannot be written; those before it are kept.
    """
    prints = Fingerprints(run.seed, wall)
    done: dict[str, Graded] = {}
    waiting = []
    for job in jobs:
        kept = _kept(out, job, run, prints.of)
        if kept is None:
            waiting.append(job)
        else:
            done[job.key] = kept
            report(kept)
    terms = Terms(run.seed, wall, tuple(preload(waiting)))
    at_once = min(workers, len(waiting))
    with closing(_grade_all(waiting, prints, graders or Processes(), terms, at_once)) as graded:
        for task, result in graded:
            run.forget(task.job.key)
            path = results.write(out, result)
            if result.status != "failed":
                run.remember(task.job.key, task.fingerprint)
            done[task.job.key] = Graded(path, result.status, reused=False)
            report(done[task.job.key])
    return [done[job.key] for job in jobs]


def _kept(out: Path, job: Job, run: Journal, fingerprint: Callable[[Job], str]) -> Graded | None:
    """The result that a submission has already, where nothing that it depends on has changed."""
    if job.key not in run.graded or run.graded[job.key] != fingerprint(job):
        return None
    path = results.path_of(out, job.student, job.assignment.name)
    try:
        return Graded(path, results.read(path).status, reused=True)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


class Fingerprints:
    """Digests of all that a submission's result depends on."""

    def __init__(self, seed: int, wall: Sandbox) -> None:
        self._common = f"{seed} {wall.name} {code_digest()}"
        self._tests: dict[Path, bytes] = {}

    def of(self, job: Job) -> str:
        """The digest of one submission, as it is on the disk now."""
        return self.task(job).fingerprint

    def task(self, job: Job) -> Task:
        """Read a submission, and take the digest of what was read."""
        handed = read(job)
        return Task(job, handed, self._digest(job, handed))

    def _digest(self, job: Job, handed: Handed) -> str:
        if job.tests not in self._tests:
            self._tests[job.tests] = self._digest_of_tests(job.tests)
        digest = hashlib.sha256(self._tests[job.tests])
        digest.update(handed.refusal.encode())
        digest.update(handed.name.encode(errors="surrogateescape") + handed.data)
        return digest.hexdigest()

    def _digest_of_tests(self, tests: Path) -> bytes:
        digest = hashlib.sha256(self._common.encode())
        config = tests.parent / CONFIG_NAME
        for path in [tests, *([config] if config.is_file() else [])]:
            digest.update(path.read_bytes())
        return digest.digest()


@functools.cache
def code_digest() -> str:
    """Digest of the interpreter and of all code that tests and grader may import."""
    # Their folders are named for name and version; to read the metadata takes far longer.
    folders = [Path(entry) for entry in sys.path if entry and not _in_a_package(Path(entry))]
    installed = sorted({path.name for folder in folders for path in folder.glob("*.dist-info")})
    digest = hashlib.sha256(repr([sys.version, installed]).encode())
    for folder in dict.fromkeys(
        [Path(robust_slam_autograder.__file__).parent, *packages.packages_in_place()]
    ):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _in_a_package(folder: Path) -> bool:
    """Whether it is in an installed package: setuptools, once imported, enters its own."""
    return any(parent.name in ("site-packages", "dist-packages") for parent in folder.parents)


def locate(job: Job) -> tuple[Path, tuple[str, ...]]:
    """The submission's notebook, with a note where it has an unusual name.

    Raises:
        Refused: there is none, or the path leads through a link.
    """
    for given in (job.path.parent.name, job.path.stem):
        if job.student == submission.stand_in(given):
            raise Refused(f"{notebook.shown(given)!r} is no name for a student: rename it.")
    try:
        return _located(job)
    except OSError as error:
        name = notebook.shown(job.path.name)
        raise Refused(f"{name} cannot be read ({error.strerror}): make it readable.") from error


def _located(job: Job) -> tuple[Path, tuple[str, ...]]:
    if job.path.is_symlink():
        raise Refused(f"{notebook.shown(job.path.name)} is a link: hand in the notebook itself.")
    if not job.path.is_dir():
        return job.path, ()
    if job.path.parent.is_symlink():
        raise Refused(f"The student's folder {notebook.shown(job.student)} is a link.")
    return submission.notebook_in(job.path, job.assignment.notebook)


def read(job: Job) -> Handed:
    """Read what is handed in, or say why it cannot be."""
    if job.handed is not None:
        return job.handed
    try:
        path, notes = locate(job)
        return Handed(path.name, notebook.read_bytes(path), notes)
    except Refused as error:
        return Handed(refusal=str(error))


def _grade_all(
    jobs: Iterable[Job], prints: Fingerprints, graders: Graders, terms: Terms, at_once: int
) -> Generator[tuple[Task, Result], None, None]:
    """Grade up to ``at_once`` submissions at once, and then, alone, those that ran into a limit.

    A busy machine may be why they did, and a mark must not depend on the neighbours. Each is
    read when its turn comes, so that few are in memory.
    """
    doubtful = []
    for task, result in _results(graders.grade(map(prints.task, jobs), terms, at_once=at_once)):
        if at_once > 1 and _ran_into_a_limit(result):
            doubtful.append(task.job)
        else:
            yield task, result
    yield from _results(graders.grade(map(prints.task, doubtful), terms, at_once=1))


def _ran_into_a_limit(result: Result) -> bool:
    stopped = any(exercise.status in ("timeout", "died") for exercise in result.exercises)
    return stopped or result.status == "failed"


def _results(
    answers: Iterator[tuple[Task, Result | Broken]],
) -> Iterator[tuple[Task, Result]]:
    for task, answer in answers:
        if isinstance(answer, Broken):
            reason = f"The grader {answer.how} on this submission."
            yield task, _without_grade("failed", reason, task.job)
        else:
            yield task, answer


def preload(jobs: Sequence[Job]) -> list[str]:
    """Modules that trusted processes want for these submissions."""
    used = {job.assignment.name: job.assignment for job in jobs}
    return [*PRELOAD, *(name for assignment in used.values() for name in _imported(assignment))]


def _imported(assignment: Assignment) -> Iterator[str]:
    """Modules that tests import, and the cells that they rely on."""
    whole = [piece.source for piece in assignment.setup if not piece.own]
    whole += [*assignment.imports, *(case.full for case in assignment.cases)]
    own = [piece.source for piece in assignment.setup if piece.own]
    for source in [*whole, needed(own, whole)]:
        yield from imported_modules(source)


def patience(task: Task) -> float:
    """Seconds after which a submission's trusted process is ended."""
    return task.job.assignment.config.limits.notebook_seconds * WALL_FACTOR + GRACE_SECONDS


def grade_task(task: Task, *, seed: int, wall: Sandbox) -> Result:
    """Grade one submission; a refusal or a failure is a result too."""
    job, handed = task.job, task.handed
    try:
        cells = handed.cells()
        code = submission.with_notes(submission.collect(cells, job.assignment), handed.notes)
        marked = marking.grade(job.assignment, code, student=job.student, seed=seed, sandbox=wall)
        return replace(marked, texts=answers.texts(job.assignment, cells))
    except Refused as error:
        return _without_grade("refused", str(error), job)
    except GraderFailure as error:
        return _without_grade("failed", str(error), job)
    except Exception as error:  # a batch goes on after anything
        # Where, and not its words: they may hold hidden inputs, and this may be a public log.
        traceback.print_tb(error.__traceback__)
        what = f"The grader failed on this submission ({type(error).__name__})."
        return _without_grade("failed", what, job)


def _without_grade(status: results.Status, reason: str, job: Job) -> Result:
    return results.without_grade(
        status,
        reason,
        student=job.student,
        assignment=job.assignment.name,
        max_score=job.assignment.max_score,
    )


def counts(graded: Sequence[Graded]) -> Mapping[str, int]:
    """How many submissions were graded, refused, failed and kept."""
    found = {"graded": 0, "refused": 0, "failed": 0, "kept": 0}
    for item in graded:
        found[item.status] += 1
        found["kept"] += item.reused
    return found


def unrecorded(
    jobs: Sequence[Job], marks: Sequence[Result], run: Journal, recorded: Mapping[str, str]
) -> dict[str, Result]:
    """By key the results that the gradebook does not have yet, failures of the grader apart.

    The same text, tests and seed need not earn the same twice: a student's code may throw dice.
    """
    pairs = ((job.key, result) for job, result in zip(jobs, marks, strict=True))
    return {
        key: result
        for key, result in pairs
        if result.status != "failed"
        and recorded.get(key) != results.signature(result, run.graded[key])
    }
