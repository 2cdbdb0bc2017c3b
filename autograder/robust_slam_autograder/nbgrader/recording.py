"""Brings a gradebook up to date with the results of a batch."""

from __future__ import annotations

from collections.abc import Sequence

from robust_slam_autograder.grading import batch
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.nbgrader import database
from robust_slam_autograder.nbgrader.database import Location


def record_new(
    location: Location, journal: Journal, jobs: Sequence[Job], marks: Sequence[Result]
) -> None:
    """Write into the gradebook what it does not have yet of these results.

    Raises:
        GraderFailure: it cannot be written.
    """
    due = batch.unrecorded(jobs, marks, journal, database.recorded(location))
    if not due:
        return
    from robust_slam_autograder.nbgrader import gradebook  # nbgrader takes a second to import

    used = {job.assignment.name: job.assignment for job in jobs}
    gradebook.record(location, list(used.values()), list(due.values()), journal.graded)
