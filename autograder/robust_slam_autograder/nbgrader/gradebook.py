"""nbgrader's gradebook: whatever else writes, nothing is lost, and what a person entered stays."""

import contextlib
import logging
import warnings
from collections.abc import Collection, Iterator, Mapping, Sequence
from datetime import datetime
from typing import Any

from nbgrader.api import (
    Comment,
    Grade,
    Gradebook,
    GradeCell,
    InvalidEntry,
    SolutionCell,
    SourceCell,
    SubmittedNotebook,
    TaskCell,
)
from nbgrader.utils import compute_checksum
from sqlalchemy import delete, insert, text
from sqlalchemy.exc import SAWarning, SQLAlchemyError

from robust_slam_autograder.grading.results import Result, by_grade_id, signature
from robust_slam_autograder.markup import visible
from robust_slam_autograder.nbgrader import database, marked_cells
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.assignment import Assignment

TOGETHER = 50
"""Submissions that one transaction takes: others wait for its end."""
_LOG = logging.getLogger("tornado.application")
"""Where nbgrader writes tracebacks, with names, of what ``database.explained`` says."""
NO_ANSWER = "No response."
"""nbgrader's own words for a free-text cell that was left as it was."""


def record(
    location: Location,
    assignments: Sequence[Assignment],
    marks: Sequence[Result],
    fingerprints: Mapping[str, str] | None = None,
) -> None:
    """Write results into a gradebook, making assignments and students that are new to it.

    What a person entered (scores, extra credit, comments) stays. As in nbgrader, a cell that
    has a manual score is put up for review; so is extra credit of an exercise whose points by
    the tests change. Several programs may record at once.

    Args:
        location: the gradebook, created if it does not exist.
        assignments: every assignment that a result belongs to.
        marks: results; of a refused one every case earns 0, as does a free-text cell that was
            left as it was released.
        fingerprints: by ``student/assignment`` what a result follows from: with them
            ``database.recorded`` tells a result that is there from another.

    Raises:
        GraderFailure: it is no gradebook, or cannot be written.
    """
    known = {assignment.name: assignment for assignment in assignments}
    database.make(location)
    with opened(location) as gradebook:
        for first in range(0, len(marks), TOGETHER):
            some = marks[first : first + TOGETHER]
            with one_transaction(gradebook):
                # Another grader may have other tests: what these marks are for is said with them.
                for name in dict.fromkeys(result.assignment for result in some):
                    _declare(gradebook, known[name])
                for result in some:
                    key = f"{result.student}/{result.assignment}"
                    notebook = _record_one(gradebook, known[result.assignment], result)
                    _sign(gradebook, notebook, result, (fingerprints or {}).get(key))


def declare(location: Location, assignment: Assignment) -> None:
    """Make the assignment and its cells in a gradebook as the instructor's notebook has them.

    Raises:
        GraderFailure: it is no gradebook, or cannot be written.
    """
    database.make(location)
    with opened(location) as gradebook, one_transaction(gradebook):
        _declare(gradebook, assignment)


def stamp(location: Location, times: Mapping[tuple[str, str], datetime | None]) -> None:
    """Note when submissions were handed in, by assignment and student: UTC without a zone.

    Formgrader lists a submission as graded where this is what its ``timestamp.txt`` says.

    Raises:
        GraderFailure: it is no gradebook, or cannot be written.
    """
    with opened(location) as gradebook, one_transaction(gradebook):
        for (assignment, student), time in times.items():
            gradebook.find_submission(assignment, student).timestamp = time


@contextlib.contextmanager
def opened(location: Location) -> Iterator[Gradebook]:
    """Open a gradebook that is there.

    Raises:
        GraderFailure: it is no gradebook, or cannot be written.
    """
    with database.explained(location), warnings.catch_warnings():
        warnings.simplefilter("ignore", SAWarning)  # nbgrader's own
        _LOG.disabled = True
        try:
            with Gradebook(database.patient(location)) as gradebook:
                yield gradebook
        except InvalidEntry as error:  # an error of the database's that nbgrader has renamed
            raise SQLAlchemyError(*error.args) from None
        finally:
            _LOG.disabled = False


@contextlib.contextmanager
def one_transaction(gradebook: Gradebook) -> Iterator[None]:
    """Write alone, and all or nothing: nbgrader's own commits, one for each row, end nothing."""
    with gradebook.engine.connect() as connection, connection.begin():
        connection.execute(text(database.LOCKS[gradebook.engine.dialect.name]))
        gradebook.db.remove()
        options = {"join_transaction_mode": "rollback_only", "expire_on_commit": False}
        gradebook.db.configure(bind=connection, **options)
        yield
        gradebook.db.commit()


def _declare(gradebook: Gradebook, assignment: Assignment) -> None:
    """Keep in step with nbgrader's own ``SaveCells``, which refuses a notebook that differs."""
    gradebook.update_or_create_assignment(assignment.name)
    notebook = gradebook.update_or_create_notebook(assignment.notebook, assignment.name)
    wanted = _wanted_cells(assignment)
    present = {(type(row), row.name): row for row in _cells(notebook)}
    for key in present.keys() - wanted.keys():
        _forget(gradebook, present[key])
    for (table, name), fields in wanted.items():
        row = present.get((table, name)) or table(name=name, notebook_id=notebook.id)
        for field, value in fields.items():
            setattr(row, field, value)
        gradebook.db.add(row)
    gradebook.db.commit()
    gradebook.db.expire_all()  # lists of cells that have been read do not follow


def _cells(notebook: Any) -> list[Any]:  # noqa: ANN401
    tables = (notebook.grade_cells, notebook.solution_cells, notebook.task_cells)
    return [row for rows in (*tables, notebook.source_cells) for row in rows]


def _wanted_cells(assignment: Assignment) -> dict[tuple[type, str], dict[str, Any]]:
    """Return nbgrader's rows for an assignment's cells, by table and grade id."""
    kept = marked_cells.kept(assignment.marked)
    wanted: dict[tuple[type, str], dict[str, Any]] = {}
    for cell in assignment.marked:
        name = cell.grade_id or ""
        graded = {"max_score": cell.points, "cell_type": cell.kind}
        source = {
            "cell_type": cell.kind,
            "locked": not cell.solution and (cell.grade or cell.locked),
            "source": kept[name].source,
            "checksum": compute_checksum(kept[name]),
        }
        kinds = {GradeCell: cell.grade, SolutionCell: cell.solution, TaskCell: cell.task}
        for table, holds in kinds.items():
            if holds:
                wanted[table, name] = {} if table is SolutionCell else graded
        if cell.locked or any(kinds.values()):
            wanted[SourceCell, name] = source
    return wanted


def _forget(gradebook: Gradebook, cell: Any) -> None:  # noqa: ANN401
    """Remove a cell that the instructor has deleted, with its marks and comments."""
    for row in (*(getattr(cell, "grades", None) or ()), *(getattr(cell, "comments", None) or ())):
        gradebook.db.delete(row)
    gradebook.db.delete(cell)


def _record_one(gradebook: Gradebook, assignment: Assignment, result: Result) -> Any:  # noqa: ANN401
    unanswered = _unanswered(assignment, result)
    gradebook.update_or_create_student(result.student)
    notebook = _submitted(gradebook, assignment, result.student)
    scores = _scores(assignment, result, unanswered)
    owner = {case.grade_id: case.exercise for case in assignment.cases}
    moved = {owner.get(row.name) for row in notebook.grades if row.auto_score != scores[row.name]}
    for row in notebook.grades:
        row.auto_score = scores[row.name]
        waits = row.auto_score is None or row.manual_score is not None
        # Points that were added to others than these: somebody should look at them again.
        again = row.needs_manual_grade or owner.get(row.name) in moved
        row.needs_manual_grade = waits or bool(row.extra_credit and again)
    comments = _comments(assignment, result, unanswered)
    for row in notebook.comments:
        row.auto_comment = comments.get(row.name)
    gradebook.db.commit()
    return notebook


def _sign(gradebook: Gradebook, notebook: Any, result: Result, fingerprint: str | None) -> None:  # noqa: ANN401
    """Note which result it is; without its fingerprint the marks count as unknown."""
    submission, table = notebook.assignment_id, database.RECORDED
    gradebook.db.execute(delete(table).where(table.c.submission_id == submission))
    if fingerprint is not None:
        row = {"submission_id": submission, "fingerprint": signature(result, fingerprint)}
        gradebook.db.execute(insert(table).values(row))


def _submitted(gradebook: Gradebook, assignment: Assignment, student: str) -> Any:  # noqa: ANN401
    """Find a student's notebook, and give it a row for every mark and comment."""
    submission = gradebook.update_or_create_submission(assignment.name, student)
    notebook = gradebook.find_notebook(assignment.notebook, assignment.name)
    submitted = next((n for n in submission.notebooks if n.notebook_id == notebook.id), None)
    if submitted is None:  # the notebook has got another name since
        submitted = SubmittedNotebook(notebook=notebook, assignment=submission)
    graded = {row.cell_id for row in submitted.grades}
    said = {row.cell_id for row in submitted.comments}
    tasks = notebook.task_cells
    for cell in (*notebook.grade_cells, *tasks):
        if cell.id not in graded:
            submitted.grades.append(Grade(cell_id=cell.id))
    for cell in (*notebook.solution_cells, *tasks):
        if cell.id not in said:
            submitted.comments.append(Comment(cell_id=cell.id))
    gradebook.db.commit()
    return submitted


def _unanswered(assignment: Assignment, result: Result) -> list[str]:
    """Return grade ids of free-text cells that hold nothing, or what was released."""
    texts = result.texts
    if not texts:
        return []
    given = marked_cells.given(assignment.marked)
    blank = submission.digest("")
    wanted = [name for name in texts if name in given]
    return [
        name for name in wanted if texts[name] in (blank, submission.digest(given[name].source))
    ]


def _scores(
    assignment: Assignment, result: Result, unanswered: Collection[str]
) -> Mapping[str, float | None]:
    """Return what is earned by grade id; None where a person must say."""
    scores: dict[str, float | None] = dict.fromkeys(
        (case.grade_id for case in assignment.cases), 0
    )
    scores |= {name: case.earned for name, case in by_grade_id(result, assignment).items()}
    for cell in filter(submission.by_hand, assignment.marked):
        name = cell.grade_id or ""
        lost = result.status == "refused" or name in unanswered
        scores[name] = 0 if lost else None
    return scores


def _comments(
    assignment: Assignment, result: Result, unanswered: Collection[str]
) -> Mapping[str, str]:
    """Return what is said by the grade id of the cell that it is said at."""
    places = [cell.grade_id or "" for cell in assignment.marked if cell.solution or cell.task]
    if result.status == "refused":
        return {name: visible(result.reason) for name in places[:1]}
    said: dict[str, list[str]] = {name: [NO_ANSWER] for name in places if name in unanswered}
    for exercise in result.exercises:
        if exercise.message:
            owner = assignment.owner(exercise.name)
            said.setdefault(owner, []).append(visible(exercise.message))
    return {name: "\n\n".join(dict.fromkeys(words)) for name, words in said.items()}
