"""Grades a batch: one trusted process for each pass, one result file each, one secret for all.

A batch that was stopped goes on where it stood: a submission whose text, tests
and seed have not changed keeps its result.
"""

import contextlib
import fcntl
import functools
import os
import shutil
import traceback
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure, Refused, WrongUse
from robust_slam_autograder.executor import guarded, seeds, trusted
from robust_slam_autograder.executor.budget import WALL_FACTOR
from robust_slam_autograder.executor.trusted import Broken
from robust_slam_autograder.grading import between_passes, results
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.grading.passes import Pass, Run
from robust_slam_autograder.grading.results import Result, Status
from robust_slam_autograder.grading.submissions import Fingerprints, Outcome, Submission
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.source import imported_modules
from robust_slam_autograder.sandbox import Sandbox

LOCK_NAME = ".lock"
WAITING_NAME = ".visible"
PRELOAD = ("numpy", "scipy.special", __name__)
GRACE_SECONDS = 60.0
"""What a submission may take beyond its own limit before its trusted process is ended."""


@dataclass(frozen=True)
class Terms:
    """What is the same for every submission of a batch."""

    seed: int
    """The batch's secret: with a notebook's bytes it gives the seed of the hidden pass."""
    sandbox: Sandbox
    """Where student code runs."""
    preload: tuple[str, ...]
    """Modules that trusted processes need."""


Graders = Callable[
    [Terms, Iterable[Submission], int], Iterator[tuple[Submission, Outcome | Broken]]
]
"""Runs each task's next pass and gives the answers as they come; the tasks are taken one by one.
The number says how many run at once; with 1 each is graded alone on its machine."""


def processes(
    terms: Terms, tasks: Iterable[Submission], at_once: int
) -> Iterator[tuple[Submission, Outcome | Broken]]:
    """Run each task's next pass in a trusted process of its own on this machine."""
    return trusted.run_each(
        tasks,
        functools.partial(run_pass, seed=terms.seed, sandbox=terms.sandbox, run=guarded.guarded),
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


@dataclass(frozen=True)
class How:
    """How a batch is graded."""

    sandbox: Sandbox
    """Where student code runs."""
    naming: Callable[[Submission, Result], Result]
    """Names what the visible pass over a submission has found wrong."""
    graders: Graders = processes
    """Who grades; by default processes of this machine."""
    workers: int = 1
    """How many submissions at once."""


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
    jobs: Sequence[Submission],
    run: Journal,
    how: How,
    report: Callable[[Graded], None] = lambda graded: None,
) -> list[Graded]:
    """Grade submissions, writing each result as it comes.

    Args:
        jobs: the submissions.
        run: the batch, from ``journal.open_journal``; it is kept up to date.
        how: who grades, and where student code runs.
        report: called after each submission.

    Returns:
        what became of each submission, in the order of ``jobs``.

    Raises:
        GraderFailure: a result cannot be written; those before it are kept.
    """
    prints = Fingerprints(run.seed, how.sandbox, run.town)
    done: dict[str, Graded] = {}
    due = []
    for job in jobs:
        reused = _reused(job, run, prints)
        if reused is None:
            due.append(job)
        else:
            done[job.key] = reused
            report(reused)
    terms = Terms(run.seed, how.sandbox, tuple(preload(due)))
    at_once = min(how.workers, len(due))
    kept = run.out / WAITING_NAME
    next_pass = functools.partial(how.graders, terms)
    with closing(_grade_all(due, prints, kept, next_pass, at_once)) as graded:
        for one, found in graded:
            run.forget(one.key)
            path = results.write(run.out, how.naming(one, found.result))
            if found.result.status != "failed":
                run.remember(one.key, one.fingerprint)
            done[one.key] = Graded(path, found.result.status, reused=False)
            report(done[one.key])
    shutil.rmtree(kept, ignore_errors=True)
    return [done[job.key] for job in jobs]


def _reused(job: Submission, run: Journal, prints: Fingerprints) -> Graded | None:
    """Return a submission's result where nothing that it depends on has changed."""
    if job.key not in run.graded or run.graded[job.key] != prints.read(job).fingerprint:
        return None
    path = results.path_of(run.out, job.student, job.assignment.name)
    try:
        return Graded(path, results.read(path).status, reused=True)
    except (OSError, ValueError):
        return None


_RunPass = Callable[[Iterable[Submission], int], Iterator[tuple[Submission, Outcome | Broken]]]
"""Runs the next pass of submissions, so many at once."""


def _grade_all(
    jobs: Iterable[Submission], prints: Fingerprints, kept: Path, run_pass: _RunPass, at_once: int
) -> Generator[tuple[Submission, Outcome], None, None]:
    """Grade submissions in two rounds: all visible passes first, and only then hidden ones.

    Every text that a student sees is made in the first round. So nothing that a hidden pass
    leaves behind on the machine can reach a text, be it of the same student or of another.
    """
    seen: list[Submission] = []

    def unseen() -> Iterator[Submission]:
        for job in jobs:
            one = prints.read(job)
            if between_passes.has_seen(kept, one):
                seen.append(job)
            else:
                yield one

    for one, found in _round(unseen(), kept, run_pass, at_once):
        if found.is_whole:
            yield one, found
        else:
            between_passes.put(kept, replace(one, seen=found))
            seen.append(replace(one, data=b""))
    again = (between_passes.get(kept, one) for one in seen)
    yield from _round(again, kept, run_pass, at_once)


def _round(
    given: Iterable[Submission], kept: Path, run_pass: _RunPass, at_once: int
) -> Iterator[tuple[Submission, Outcome]]:
    """Run a pass of some submissions at once, and then, alone, of those that ran into a limit.

    A busy machine may be why they did, and a mark must not depend on the neighbours.
    """
    again = []
    for one, found in _ended(run_pass(given, at_once)):
        if at_once > 1 and found.doubtful:
            between_passes.put(kept, one)
            again.append(replace(one, data=b""))
        else:
            yield one, found
    alone = (between_passes.get(kept, one) for one in again)
    yield from _ended(run_pass(alone, 1))


def _ended(
    answers: Iterable[tuple[Submission, Outcome | Broken]],
) -> Iterator[tuple[Submission, Outcome]]:
    for one, answer in answers:
        if isinstance(answer, Broken):
            answer = _without_grade("failed", f"The grader {answer.how} on this submission.", one)
        yield one, answer


def preload(jobs: Sequence[Submission]) -> list[str]:
    """Return modules that trusted processes want for these submissions."""
    used = {job.assignment.name: job.assignment for job in jobs}
    return [*PRELOAD, *(name for assignment in used.values() for name in _imported(assignment))]


def _imported(assignment: Assignment) -> Iterator[str]:
    """Return modules that tests import, and the locked cells that they rely on."""
    whole = [piece.source for piece in assignment.setup if not piece.own]
    whole += [*assignment.imports, *(case.full for case in assignment.cases)]
    for source in whole:
        yield from imported_modules(source)


def patience(one: Submission) -> float:
    """Return seconds after which a submission's trusted process is ended."""
    return one.assignment.config.limits.notebook_seconds * WALL_FACTOR + GRACE_SECONDS


def run_pass(one: Submission, *, seed: int, sandbox: Sandbox, run: Run = guarded.plain) -> Outcome:
    """Run a submission's next pass; a refusal or a failure is a result too.

    With its visible pass seen the hidden one is next; the seed is the batch's secret.
    """
    try:
        cells = one.cells()
        code = submission.collect(cells, one.assignment)
        if code.foreign:
            raise Refused(code.foreign)
        code = replace(code, notes=one.notes + code.notes)
        new = Pass(one.student, one.assignment, code, sandbox, one.town, run)
        seen, own = one.seen, seeds.of_submission(seed, one.data)
        found = new.look() if seen is None else new.finish(seen, own)
        texts = submission.texts(one.assignment, cells)
        return replace(found, result=replace(found.result, texts=texts))
    except Refused as error:
        return _without_grade("refused", str(error), one)
    except GraderFailure as error:
        return _without_grade("failed", str(error), one)
    except Exception as error:  # a batch goes on after anything
        # Where, and not its words: they may hold hidden inputs, and this may be a public log.
        traceback.print_tb(error.__traceback__)
        what = f"The grader failed on this submission ({type(error).__name__})."
        return _without_grade("failed", what, one)


def _without_grade(status: results.Status, reason: str, job: Submission) -> Outcome:
    result = results.without_grade(
        status,
        reason,
        student=job.student,
        assignment=job.assignment.name,
        max_score=job.assignment.max_score,
    )
    return Outcome(result, doubtful=status == "failed")


def counts(graded: Sequence[Graded]) -> Mapping[str, int]:
    """Say how many submissions were graded, refused, failed and kept."""
    found = {"graded": 0, "refused": 0, "failed": 0, "kept": 0}
    for item in graded:
        found[item.status] += 1
        found["kept"] += item.reused
    return found


def unrecorded(
    jobs: Sequence[Submission], marks: Sequence[Result], run: Journal, recorded: Mapping[str, str]
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
