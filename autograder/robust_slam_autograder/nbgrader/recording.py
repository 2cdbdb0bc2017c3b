"""Brings a gradebook, and what formgrader lists, up to date with the results of a batch."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.grading import batch
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.nbgrader import database
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.sandbox import Sandbox


def record_new(
    location: Location,
    journal: Journal,
    jobs: Sequence[Job],
    marks: Sequence[Result],
    wall: Sandbox,
) -> None:
    """Write into the gradebook what it does not have yet of these results.

    Where the results are a class's, their graded notebooks are written too. One that is to be
    replaced is removed first, so that after a kill none is there that belongs to an older mark.

    Raises:
        GraderFailure: it cannot be written.
    """
    due = batch.unrecorded(jobs, marks, journal, database.recorded(location))
    folder = layout.shown_beside(journal.out)
    shown = {
        _notebook(folder, job): (job, result)
        for job, result in zip(jobs, marks, strict=True)
        if folder is not None and result.status != "failed"
    }
    stale = {path: pair for path, pair in shown.items() if pair[0].key in due or not path.exists()}
    if not due and not stale:
        return
    from robust_slam_autograder.nbgrader import formgrader, gradebook  # these take a second

    for path in stale:
        path.unlink(missing_ok=True)
    used = {job.assignment.name: job.assignment for job in jobs}
    gradebook.record(location, list(used.values()), list(due.values()), journal.graded)
    formgrader.show(location, stale, journal, wall)


def _notebook(folder: Path, job: Job) -> Path:
    return folder / job.student / job.assignment.name / f"{job.assignment.notebook}.ipynb"
