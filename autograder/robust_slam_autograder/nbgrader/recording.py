"""Brings a gradebook, and what formgrader lists, up to date with the results of a batch."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.grading import batch, durable, submissions
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.nbgrader import database
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.reading import timestamp
from robust_slam_autograder.sandbox import Sandbox


def record_new(
    location: Location,
    journal: Journal,
    jobs: Sequence[Submission],
    marks: Sequence[Result],
    sandbox: Sandbox,
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
    from robust_slam_autograder.nbgrader import gradebook  # it takes a second to import

    for path in stale:
        path.unlink(missing_ok=True)
    used = {job.assignment.name: job.assignment for job in jobs}
    gradebook.record(location, list(used.values()), list(due.values()), journal.graded)
    _show(location, stale, journal, sandbox)


def _show(
    location: Location,
    graded: Mapping[Path, tuple[Submission, Result]],
    journal: Journal,
    sandbox: Sandbox,
) -> None:
    """Write the notebooks of results that the gradebook has, and when they were handed in.

    A notebook comes last: where one is, the rest of it is there too. A submission that has
    changed since it was graded is left for the next run: a person would mark another text.
    """
    import nbformat  # these take a second

    from robust_slam_autograder.nbgrader import gradebook, graded_notebook, own_files

    times = {
        (job.assignment.name, job.student): own_files.time_of(job.path)
        for job, _ in graded.values()
    }
    gradebook.stamp(location, times)
    prints = submissions.Fingerprints(journal.seed, sandbox, journal.town)
    for path, (job, result) in graded.items():
        now = prints.read(job)
        if now.fingerprint != journal.graded.get(job.key):
            continue
        beside = path.with_name(timestamp.NAME)
        stated = own_files.plain(job.path).get(timestamp.NAME)
        with durable.explained(beside):
            beside.unlink(missing_ok=True)
        if stated is not None:
            durable.write(beside, stated.decode(errors="replace"))
        made = graded_notebook.build(now, result)
        durable.write(path, nbformat.writes(made))  # type: ignore[no-untyped-call]


def _notebook(folder: Path, job: Submission) -> Path:
    return folder / job.student / job.assignment.name / f"{job.assignment.notebook}.ipynb"
