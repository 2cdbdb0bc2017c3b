"""Grading again what was graded before: whose marks change, by how much, and why.

The new results are in a folder of their own, ``<out>/.regrade``, with a journal of their
own, until they are applied: to look is not to change, and a look that was stopped goes on.
"""

import os
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.grading import batch, results, submissions
from robust_slam_autograder.grading.batch import Graded, How
from robust_slam_autograder.grading.journal import RUN_NAME, Journal, open_journal
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.sandbox import Sandbox

FOLDER_NAME = ".regrade"


@dataclass(frozen=True)
class ExerciseChange:
    """One exercise whose points change; None where it was not there."""

    name: str
    before: ExerciseResult | None
    after: ExerciseResult | None


@dataclass(frozen=True)
class Regraded:
    """One submission, as it was graded and as it is now."""

    before: Result
    after: Result
    is_newer: bool
    """Whether the notebook has been written since it was graded: then not only tests changed."""

    @property
    def is_changed(self) -> bool:
        """Tell whether its points or its status are others."""
        return bool(self.exercises) or _worth(self.before) != _worth(self.after)

    @property
    def exercises(self) -> tuple[ExerciseChange, ...]:
        """Return exercises whose points change."""
        old = {exercise.name: exercise for exercise in self.before.exercises}
        new = {exercise.name: exercise for exercise in self.after.exercises}
        pairs = (ExerciseChange(n, old.get(n), new.get(n)) for n in dict.fromkeys([*old, *new]))
        return tuple(pair for pair in pairs if _points(pair.before) != _points(pair.after))


def _worth(result: Result) -> tuple[float, float, str]:
    return result.score, result.max_score, result.status


def _points(exercise: ExerciseResult | None) -> tuple[float, float] | None:
    return None if exercise is None else (exercise.score, exercise.max_score)


@dataclass(frozen=True)
class Plan:
    """Which submissions of an assignment there are to grade again."""

    jobs: tuple[Submission, ...]
    left_out: tuple[str, ...]
    """Students who have a result and no submission where it was looked for."""


def plan(tree: Path, name: str, *, out: Path, submitted: Path) -> Plan:
    """Find the submissions, ``<submitted>/<student>/<name>/``, that have a result already.

    Raises:
        WrongUse: nothing of this assignment has been graded, the batch's seed is lost, or
            none of the submissions is there.
    """
    assignments.find_names(tree, [name])
    students = sorted(path.parent.name for path in results.files_of(out, name))
    if not students:
        raise WrongUse(f"{out} holds no result of {name}: grade it first, or say --out DIR.")
    if not (out / RUN_NAME).is_file():
        raise WrongUse(
            f"{out / RUN_NAME} is gone, and with it the seed: other inputs would change "
            "marks too. Grade anew."
        )
    assignment = assignments.of(tree, name)
    # Not Path.is_dir, which raises where a folder cannot be entered.
    there = [one for one in students if os.path.isdir(submitted / one / name)]
    if not there:
        raise WrongUse(f"{submitted} has no submission of {name}: say --submitted DIR.")
    jobs = (Submission(one, assignment, submitted / one / name) for one in there)
    return Plan(tuple(jobs), tuple(one for one in students if one not in there))


def outdated(jobs: Sequence[Submission], journal: Journal, sandbox: Sandbox) -> list[Submission]:
    """Return submissions whose result does not follow from today's tests, text and grader."""
    read = submissions.Fingerprints(journal.seed, sandbox, journal.town).read
    return [job for job in jobs if journal.graded.get(job.key) != read(job).fingerprint]


@dataclass(frozen=True)
class Trial:
    """New results, beside the old ones."""

    jobs: tuple[Submission, ...]
    graded: tuple[Graded, ...]
    journal: Journal
    """The new results' own journal."""

    def results(self) -> list[tuple[Submission, Result]]:
        """Return each submission with its new result."""
        return [(job, item.load()) for job, item in zip(self.jobs, self.graded, strict=True)]


def attempt(
    jobs: Sequence[Submission], journal: Journal, how: How, report: Callable[[], None]
) -> Trial:
    """Grade submissions again with the batch's own seed, beside the results that there are.

    The batch's folder is locked; ``report`` is called after each.

    Raises:
        GraderFailure: a result cannot be written.
    """
    folder = journal.out / FOLDER_NAME
    folder.mkdir(exist_ok=True)
    own = open_journal(folder, journal.seed)
    graded = batch.grade(jobs, own, how, lambda done: report())
    return Trial(tuple(jobs), tuple(graded), own)


def compare(trial: Trial, out: Path) -> list[Regraded]:
    """Pair old and new results; where the grader failed now, the old one stays.

    Raises:
        WrongUse: an old result cannot be read.
    """
    return [
        Regraded(
            results.read_checked(results.path_of(out, job.student, job.assignment.name)),
            after,
            _is_newer(job, out),
        )
        for job, after in trial.results()
        if after.status != "failed"
    ]


def _is_newer(job: Submission, out: Path) -> bool:
    try:
        path, _ = submissions.locate(job)
        graded = results.path_of(out, job.student, job.assignment.name)
        return path.stat().st_mtime_ns > graded.stat().st_mtime_ns
    except (Refused, OSError):
        return False


def apply(trial: Trial, journal: Journal) -> None:
    """Put the new results in the old ones' place; those on which the grader failed stay.

    Raises:
        GraderFailure: a result cannot be written; the same command again goes on from there.
    """
    for job, result in trial.results():
        if result.status != "failed":
            journal.forget(job.key)
            results.write(journal.out, result)
            journal.remember(job.key, trial.journal.graded[job.key])


def standing(
    jobs: Sequence[Submission], journal: Journal
) -> tuple[list[Submission], list[Result]]:
    """Return submissions whose results hold, with these results."""
    held = [job for job in jobs if job.key in journal.graded]
    paths = [results.path_of(journal.out, job.student, job.assignment.name) for job in held]
    return held, [results.read_checked(path) for path in paths]


def unrecorded(
    jobs: Sequence[Submission], trial: Trial, journal: Journal, recorded: Mapping[str, str]
) -> list[tuple[Submission, Result]]:
    """Return results that hold and are not in the gradebook yet, for a run before was stopped."""
    again = {job.key for job in trial.jobs}
    held, marks = standing([job for job in jobs if job.key not in again], journal)
    due = batch.unrecorded(held, marks, journal, recorded)
    return [(job, due[job.key]) for job in held if job.key in due]


def clear(journal: Journal) -> None:
    """Remove the results that have been applied."""
    shutil.rmtree(journal.out / FOLDER_NAME)
