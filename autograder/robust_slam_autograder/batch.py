"""Grades a batch: one trusted process per submission, one result file each, one seed for all.

A batch that was stopped goes on where it stood: a submission whose text, tests
and seed have not changed keeps its result.
"""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import resource
import secrets
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import ForkServerProcess
from pathlib import Path
from typing import Any

from robust_slam_autograder import grading, notebook, results, submission
from robust_slam_autograder.assignment import CONFIG_NAME, Assignment
from robust_slam_autograder.errors import GraderFailure, Refused, WrongUse
from robust_slam_autograder.results import Result
from robust_slam_autograder.sandbox import Sandbox

RUN_NAME = ".run.json"
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
    """What ``.run.json`` keeps: the seed, and the fingerprint of each graded submission."""

    seed: int
    graded: dict[str, str]


@dataclass(frozen=True)
class Graded:
    """A result, and whether it was kept from an earlier run."""

    result: Result
    reused: bool


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
        return Run(secrets.randbits(63) if seed is None else seed, {})
    try:
        kept = json.loads(path.read_text(encoding="utf-8"))
        run = Run(int(kept["seed"]), {str(k): str(v) for k, v in kept["graded"].items()})
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise WrongUse(f"{path} cannot be read: delete it to begin a new batch.") from error
    return run if seed is None or seed == run.seed else Run(seed, {})


def grade(
    jobs: Sequence[Job],
    *,
    out: Path,
    seed: int | None,
    sandbox: Sandbox,
    workers: int,
    report: Callable[[Graded], None],
) -> list[Graded]:
    """Grade submissions, writing each result as it comes.

    Args:
        jobs: the submissions.
        out: folder of the result files and of ``.run.json``.
        seed: see ``open_run``.
        sandbox: where student code runs.
        workers: how many submissions at once.
        report: called after each submission.

    Returns:
        what became of each submission, in the order of ``jobs``.
    """
    run = open_run(out, seed)
    _save(out, run)
    prints = {job.key: _fingerprint(job, run.seed, sandbox) for job in jobs}
    done: dict[str, Graded] = {}

    def finish(job: Job, graded: Graded) -> None:
        if not graded.reused:
            results.write(out, graded.result)
            run.graded.pop(job.key, None)
            if graded.result.status != "failed":
                run.graded[job.key] = prints[job.key]
            _save(out, run)
        done[job.key] = graded
        report(graded)

    waiting = []
    for job in jobs:
        kept = _kept(out, job) if run.graded.get(job.key) == prints[job.key] else None
        if kept is None:
            waiting.append(job)
        else:
            finish(job, Graded(kept, reused=True))
    for job, result in _grade_all(waiting, run.seed, sandbox, workers):
        finish(job, Graded(result, reused=False))
    return [done[job.key] for job in jobs]


def _save(out: Path, run: Run) -> None:
    results.write_json(out / RUN_NAME, {"seed": run.seed, "graded": run.graded})


def _kept(out: Path, job: Job) -> Result | None:
    try:
        return results.read(results.path_of(out, job.student, job.assignment.name))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def _fingerprint(job: Job, seed: int, sandbox: Sandbox) -> str:
    """Digest of all that a result depends on."""
    digest = hashlib.sha256(f"{seed} {sandbox.name}".encode())
    config = job.tests.parent / CONFIG_NAME
    sources = [job.tests, *([config] if config.is_file() else [])]
    sources += sorted(Path(__file__).parent.glob("*.py"))
    for path in sources:
        digest.update(path.read_bytes())
    try:
        path, _ = locate(job)
        digest.update(path.name.encode() + notebook.read_bytes(path))
    except Refused as error:
        digest.update(str(error).encode())
    return digest.hexdigest()


def locate(job: Job) -> tuple[Path, tuple[str, ...]]:
    """The submission's notebook, with a note where it has an unusual name.

    Raises:
        Refused: there is none, or the path leads through a link.
    """
    if job.path.is_symlink():
        raise Refused(f"{job.path.name} is a link: hand in the notebook itself.")
    if job.path.is_dir():
        return submission.notebook_in(job.path, job.assignment.name)
    return job.path, ()


def _grade_all(
    jobs: Sequence[Job], seed: int, sandbox: Sandbox, workers: int
) -> Iterator[tuple[Job, Result]]:
    """Run up to ``workers`` submissions at once, each in a fresh process."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["numpy", "scipy.special", grading.__name__])
    queue = list(jobs)
    running: dict[Connection, tuple[Job, ForkServerProcess]] = {}
    try:
        while queue or running:
            while queue and len(running) < workers:
                job = queue.pop(0)
                receiver, sender = context.Pipe(duplex=False)
                process = context.Process(target=_work, args=(sender, job, seed, sandbox))
                process.start()
                sender.close()
                running[receiver] = (job, process)
            yield from _collect(running)
    finally:
        for receiver, (_, process) in running.items():
            process.kill()
            receiver.close()


def _collect(
    running: dict[Connection, tuple[Job, ForkServerProcess]],
) -> Iterator[tuple[Job, Result]]:
    longest = max(job.assignment.config.limits.notebook_seconds for job, _ in running.values())
    ready: Sequence[Any] = wait(list(running), timeout=longest + GRACE_SECONDS)
    for receiver in ready or list(running):
        job, process = running.pop(receiver)
        try:
            result = receiver.recv() if ready else _failed(job, "took longer than its limits")
        except EOFError:
            process.join()
            result = _failed(job, f"ended with exit status {process.exitcode}")
        process.kill()
        process.join()
        receiver.close()
        yield job, result


def _failed(job: Job, what: str) -> Result:
    reason = f"The grader {what} on this submission."
    return _without_grade("failed", reason, job)


def _work(sender: Connection, job: Job, seed: int, sandbox: Sandbox) -> None:
    """The trusted process of one submission."""
    resource.setrlimit(resource.RLIMIT_AS, (TRUSTED_MEMORY, TRUSTED_MEMORY))
    sender.send(grade_one(job, seed, sandbox))
    sender.close()


def grade_one(job: Job, seed: int, sandbox: Sandbox) -> Result:
    """Read and grade one submission; a refusal or a failure of the grader is a result too."""
    try:
        path, notes = locate(job)
        code = submission.collect(notebook.read(path), job.assignment)
        code = submission.with_notes(code, notes)
        return grading.grade(job.assignment, code, student=job.student, seed=seed, sandbox=sandbox)
    except Refused as error:
        return _without_grade("refused", str(error), job)
    except (GraderFailure, MemoryError) as error:
        return _without_grade("failed", str(error) or "The grader ran out of memory.", job)


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
