"""Grades a batch: one trusted process per submission, one result file each, one seed for all.

A batch that was stopped goes on where it stood: a submission whose text, tests
and seed have not changed keeps its result.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import json
import multiprocessing
import resource
import secrets
import sys
import time
import traceback
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import distributions
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerProcess
from pathlib import Path

from robust_slam_autograder import grading, notebook, results, submission
from robust_slam_autograder.assignment import CONFIG_NAME, Assignment
from robust_slam_autograder.errors import GraderFailure, Refused, WrongUse
from robust_slam_autograder.results import Result
from robust_slam_autograder.sandbox import Sandbox, inside

RUN_NAME = ".run.json"
LOCK_NAME = ".lock"
TRUSTED_MEMORY = 8 * 1024**3
GRACE_SECONDS = 60.0
"""What a submission may take beyond its own limit before its trusted process is ended."""


@dataclass(frozen=True)
class Job:
    """One submission to grade."""

    student: str
    assignment: Assignment
    tests: Path
    """The instructor's notebook."""
    path: Path
    """The submission's notebook, or its folder ``submitted/<student>/<assignment>/``."""

    @property
    def key(self) -> str:
        """Name of the submission in the batch."""
        return f"{self.student}/{self.assignment.name}"


@dataclass
class Run:
    """What ``.run.json`` keeps: the seed, and fingerprints of submissions.

    Attributes:
        seed: the batch's secret.
        graded: of those that have a result file.
        recorded: of those whose marks are in the gradebook.
    """

    seed: int
    graded: dict[str, str] = field(default_factory=dict)
    recorded: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Graded:
    """A result, and whether it was kept from an earlier run."""

    result: Result
    reused: bool


@contextlib.contextmanager
def locked(out: Path) -> Iterator[None]:
    """Keep a second batch out of the same results' folder; a killed one holds nothing back.

    Raises:
        WrongUse: another batch is at work there.
    """
    out.mkdir(parents=True, exist_ok=True)
    with open(out / LOCK_NAME, "w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            raise WrongUse(f"Another batch is at work in {out}: wait for its end.") from error
        yield


def open_run(out: Path, seed: int | None) -> Run:
    """Read the batch's seed and fingerprints, or begin a batch.

    Args:
        out: the results' folder.
        seed: the seed to use; None keeps the batch's own, or draws a secret one.

    Raises:
        WrongUse: the folder's ``.run.json`` cannot be read.
    """
    path = out / RUN_NAME
    if not path.is_file():
        return Run(secrets.randbits(63) if seed is None else seed)
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        run = Run(int(kept["seed"]), dict(kept["graded"]), dict(kept.get("recorded", {})))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise WrongUse(f"{path} cannot be read: delete it to begin a new batch.") from error
    return run if seed is None or seed == run.seed else Run(seed)


def save_run(out: Path, run: Run) -> None:
    """Write ``.run.json``, for its owner's eyes only: it holds the seed."""
    value = {"seed": run.seed, "graded": run.graded, "recorded": run.recorded}
    results.write_json(out / RUN_NAME, value, mode=0o600)


def grade(
    jobs: Sequence[Job],
    *,
    out: Path,
    run: Run,
    wall: Sandbox,
    workers: int,
    report: Callable[[Graded], None],
) -> list[Graded]:
    """Grade submissions, writing each result as it comes.

    Args:
        jobs: the submissions.
        out: folder of the result files and of ``.run.json``.
        run: the batch, from ``open_run``; it is kept up to date.
        wall: where student code runs.
        workers: how many submissions at once.
        report: called after each submission.

    Returns:
        what became of each submission, in the order of ``jobs``.
    """
    save_run(out, run)
    prints = {job.key: _fingerprint(job, run.seed, wall) for job in jobs}
    done: dict[str, Graded] = {}
    waiting = []
    for job in jobs:
        kept = _kept(out, job) if run.graded.get(job.key) == prints[job.key] else None
        if kept is None:
            waiting.append(job)
        else:
            done[job.key] = Graded(kept, reused=True)
            report(done[job.key])
    for job, result in _grade_all(waiting, run.seed, wall, workers):
        results.write(out, result)
        run.graded.pop(job.key, None)
        if result.status != "failed":
            run.graded[job.key] = prints[job.key]
        save_run(out, run)
        done[job.key] = Graded(result, reused=False)
        report(done[job.key])
    return [done[job.key] for job in jobs]


def _kept(out: Path, job: Job) -> Result | None:
    try:
        return results.read(results.path_of(out, job.student, job.assignment.name))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def _fingerprint(job: Job, seed: int, wall: Sandbox) -> str:
    """Digest of all that a result depends on."""
    digest = hashlib.sha256(f"{seed} {wall.name} {_code_digest()}".encode())
    config = job.tests.parent / CONFIG_NAME
    for path in [job.tests, *([config] if config.is_file() else [])]:
        digest.update(path.read_bytes())
    try:
        path, _ = locate(job)
        digest.update(path.name.encode(errors="surrogateescape") + notebook.read_bytes(path))
    except Refused as error:
        digest.update(str(error).encode())
    return digest.hexdigest()


@cache
def _code_digest() -> str:
    """Digest of the interpreter and of all code that tests and grader may import."""
    installed = sorted(f"{package.name} {package.version}" for package in distributions())
    digest = hashlib.sha256(repr([sys.version, installed]).encode())
    for folder in dict.fromkeys([Path(__file__).parent, *inside.packages_in_place()]):
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def locate(job: Job) -> tuple[Path, tuple[str, ...]]:
    """The submission's notebook, with a note where it has an unusual name.

    Raises:
        Refused: there is none, or the path leads through a link.
    """
    if job.path.is_symlink():
        raise Refused(f"{notebook.shown(job.path.name)} is a link: hand in the notebook itself.")
    if not job.path.is_dir():
        return job.path, ()
    if job.path.parent.is_symlink():
        raise Refused(f"The student's folder {notebook.shown(job.student)} is a link.")
    return submission.notebook_in(job.path, job.assignment.notebook)


def _grade_all(
    jobs: Sequence[Job], seed: int, wall: Sandbox, workers: int
) -> Iterator[tuple[Job, Result]]:
    """Grade up to ``workers`` submissions at once, and then, alone, those that ran into a limit.

    A busy machine may be why they did, and a mark must not depend on the neighbours.
    """
    doubtful = []
    for job, result in _grade_together(jobs, seed, wall, workers):
        if workers > 1 and len(jobs) > 1 and _ran_into_a_limit(result):
            doubtful.append(job)
        else:
            yield job, result
    yield from _grade_together(doubtful, seed, wall, workers=1)


def _ran_into_a_limit(result: Result) -> bool:
    stopped = any(exercise.status in ("timeout", "died") for exercise in result.exercises)
    return stopped or result.status == "failed"


@dataclass(frozen=True)
class _Worker:
    job: Job
    process: ForkServerProcess
    end: float
    """When it must be done (``time.monotonic``)."""


def _grade_together(
    jobs: Sequence[Job], seed: int, wall: Sandbox, workers: int
) -> Iterator[tuple[Job, Result]]:
    """Run up to ``workers`` submissions at once, each in a fresh process."""
    queue = list(jobs)
    running: dict[Connection, _Worker] = {}
    try:
        while queue or running:
            while queue and len(running) < workers:
                receiver, worker = _start(queue.pop(0), seed, wall)
                running[receiver] = worker
            yield from _collect(running)
    finally:
        for receiver, worker in running.items():
            worker.process.kill()
            receiver.close()


def _start(job: Job, seed: int, wall: Sandbox) -> tuple[Connection, _Worker]:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["numpy", "scipy.special", grading.__name__])
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(sender, job, seed, wall))
    with _without_main():
        process.start()
    sender.close()
    limit = job.assignment.config.limits.notebook_seconds + GRACE_SECONDS
    return receiver, _Worker(job, process, time.monotonic() + limit)


@contextlib.contextmanager
def _without_main() -> Iterator[None]:
    """Keep a new process from running the main script, whatever that is, once more."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _collect(running: dict[Connection, _Worker]) -> Iterator[tuple[Job, Result]]:
    """Wait for the next worker, or workers, to be done or to be late."""
    first = min(worker.end for worker in running.values())
    ready = wait(list(running), timeout=max(0.0, first - time.monotonic()))
    now = time.monotonic()
    for receiver, worker in list(running.items()):
        if receiver not in ready and worker.end > now:
            continue
        del running[receiver]
        result = _receive(receiver, worker) if receiver in ready else _late(worker.job)
        worker.process.kill()
        worker.process.join()
        receiver.close()
        yield worker.job, result


def _receive(receiver: Connection, worker: _Worker) -> Result:
    try:
        result: Result = receiver.recv()
    except (EOFError, OSError):
        worker.process.join()
        what = f"ended with exit status {worker.process.exitcode}"
        return _without_grade("failed", f"The grader {what} on this submission.", worker.job)
    return result


def _late(job: Job) -> Result:
    return _without_grade("failed", "The grader took longer than its limits here.", job)


def _work(sender: Connection, job: Job, seed: int, wall: Sandbox) -> None:
    """The trusted process of one submission."""
    resource.setrlimit(resource.RLIMIT_AS, (TRUSTED_MEMORY, TRUSTED_MEMORY))
    sender.send(grade_one(job, seed, wall))
    sender.close()


def grade_one(job: Job, seed: int, wall: Sandbox) -> Result:
    """Read and grade one submission; a refusal or a failure of the grader is a result too."""
    try:
        path, notes = locate(job)
        code = submission.collect(notebook.read(path), job.assignment)
        code = submission.with_notes(code, notes)
        return grading.grade(job.assignment, code, student=job.student, seed=seed, sandbox=wall)
    except Refused as error:
        return _without_grade("refused", str(error), job)
    except GraderFailure as error:
        return _without_grade("failed", str(error), job)
    except Exception as error:  # a batch goes on after anything
        traceback.print_exc()  # its words may hold hidden inputs: they are for the terminal only
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
        found[item.result.status] += 1
        found["kept"] += item.reused
    return found


def unrecorded(jobs: Sequence[Job], graded: Sequence[Graded], run: Run) -> list[Result]:
    """Results that the gradebook does not have yet; where the grader failed there is none."""
    pairs = zip(jobs, graded, strict=True)
    fresh = [
        (job, item) for job, item in pairs if run.recorded.get(job.key) != run.graded.get(job.key)
    ]
    return [item.result for _, item in fresh if item.result.status != "failed"]
