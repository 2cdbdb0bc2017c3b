"""What formgrader lists: graded notebooks, in the folder where nbgrader keeps its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import nbformat

from robust_slam_autograder.grading import durable, tasks
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.nbgrader import gradebook, graded_notebook, own_files
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.reading import timestamp
from robust_slam_autograder.sandbox import Sandbox


def show(
    location: Location, graded: Mapping[Path, tuple[Job, Result]], journal: Journal, wall: Sandbox
) -> None:
    """Write the notebooks of results that the gradebook has, and when they were handed in.

    A notebook comes last: where one is, the rest of it is there too. A submission that has
    changed since it was graded is left for the next run: a person would mark another text.

    Args:
        location: the gradebook.
        graded: submissions with their results, by the path of the graded notebook.
        journal: the batch's.
        wall: where student code ran.

    Raises:
        GraderFailure: a file or the gradebook cannot be written.
    """
    times = {
        (job.assignment.name, job.student): own_files.time_of(job.path)
        for job, _ in graded.values()
    }
    gradebook.stamp(location, times)
    prints = tasks.Fingerprints(journal.seed, wall, journal.town)
    for path, (job, result) in graded.items():
        task = prints.task(job)
        if task.fingerprint != journal.graded.get(job.key):
            continue
        beside = path.with_name(timestamp.NAME)
        stated = own_files.plain(job.path).get(timestamp.NAME)
        with durable.explained(beside):
            beside.unlink(missing_ok=True)
        if stated is not None:
            durable.write(beside, stated.decode(errors="replace"))
        made = graded_notebook.build(job.assignment, task.handed, result)
        durable.write(path, nbformat.writes(made))  # type: ignore[no-untyped-call]
