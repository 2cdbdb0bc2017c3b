"""Marks by hand: points that a person adds or takes for an exercise, with the reason.

They are in the gradebook and nowhere else, because formgrader writes there and the exports read
there: kept in a file, they would have to agree with what somebody enters in formgrader. Points
are the extra credit of the exercise's first case, so that they stay beside whatever a later run
finds. The reason is a line of the comment on its solution, whose other lines are left alone.
"""

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading.entered_by_hand import Entered, Entry
from robust_slam_autograder.grading.results import tidy
from robust_slam_autograder.markup import one_line
from robust_slam_autograder.nbgrader import database
from robust_slam_autograder.nbgrader.database import Location
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.assignment import Assignment

MOST_WORDS = 2000
"""Letters of a reason."""
_LINE = "Points by hand ({}): {}"
_READ = re.compile(r"Points by hand \((.*?)\): (.*)")
_FROM = (
    " JOIN base_cell AS cell ON cell.id = mine.cell_id"
    " JOIN submitted_notebook AS book ON book.id = mine.notebook_id"
    " JOIN submitted_assignment AS submitted ON submitted.id = book.assignment_id"
    " JOIN assignment ON assignment.id = submitted.assignment_id"
    " WHERE assignment.name = :assignment"
)
_POINTS = (
    "SELECT submitted.student_id, cell.name, mine.auto_score, mine.manual_score,"
    f" mine.extra_credit FROM grade AS mine{_FROM}"
)
_COMMENTS = (
    "SELECT submitted.student_id, cell.name, mine.manual_comment"
    f" FROM comment AS mine{_FROM} AND mine.manual_comment IS NOT NULL"
)


def read(location: Location, assignment: Assignment) -> Entered:
    """Read what people entered in an assignment; nothing where there is no gradebook.

    Raises:
        GraderFailure: it cannot be read.
    """
    owners = _exercises(assignment)
    alone = {
        cell.grade_id or "": cell.points for cell in assignment.marked if submission.by_hand(cell)
    }
    points: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
    marked = set()
    named = {"assignment": assignment.name}
    for student, cell, auto, manual, extra in database.rows(location, _POINTS, **named):
        by_tests = 0 if cell in alone or auto is None else auto
        given = (auto if manual is None else manual) or 0
        points[student][owners.get(cell, cell)] += given + (extra or 0) - by_tests
        if (auto, manual) != (None, None):
            marked.add((student, cell))
    words: dict[str, dict[str, list[str]]] = defaultdict(lambda: defaultdict(list))
    for student, cell, comment in database.rows(location, _COMMENTS, **named):
        for name, line in _lines(comment, _first_of(assignment, cell)):
            words[student][name].append(line)

    def entries(student: str) -> Iterator[Entry]:
        for name in dict.fromkeys([*assignment.exercises, *alone, *words[student]]):
            most, said = alone.get(name, 0), "\n".join(words[student][name])
            given = points[student][name]
            if name in alone or said or not math.isclose(given, 0, abs_tol=1e-9):
                waits = name in alone and (student, name) not in marked
                yield Entry(name, tidy(given), said, tidy(most), waits)

    known = list(points)
    return Entered({student: tuple(entries(student)) for student in known}, tuple(entries("")))


def _exercises(assignment: Assignment) -> dict[str, str]:
    """Return by grade id the exercise that a case belongs to."""
    return {case.grade_id: case.exercise for case in assignment.cases}


def _first_of(assignment: Assignment, cell: str) -> str:
    """Return the exercise whose answer stands in a cell; the cell itself where none does."""
    mine = (name for name in assignment.exercises if assignment.owner(name) == cell)
    return next(mine, cell)


def _lines(comment: str, owner: str) -> Iterator[tuple[str, str]]:
    """Yield a comment's lines with the exercise that each is about."""
    for line in filter(str.strip, comment.splitlines()):
        found = _READ.fullmatch(line)
        yield (found[1], found[2]) if found else (owner, line)


@dataclass(frozen=True)
class Change:
    """What became of one exercise's points."""

    by_tests: float
    before: float
    """By hand, as after."""
    after: float
    max_score: float
    total: float
    """Of the submission, in the gradebook."""
    total_max: float


def enter(
    location: Location,
    assignment: Assignment,
    *,
    student: str,
    exercise: str,
    points: float,
    reason: str,
) -> Change:
    """Add points to an exercise, or take some, in place of what was added there before.

    Args:
        location: the gradebook.
        assignment: as the instructor has it.
        student: who has been graded in it.
        exercise: one of its exercises.
        points: beside those of the tests; 0 takes a mark by hand back.
        reason: for the student; it may be empty where nothing is left to be explained.

    Raises:
        WrongUse: the student or the exercise is unknown, the reason is missing, the exercise
            would have more points than it is worth or fewer than none, or somebody entered a
            case's score in formgrader, which stands in place of the tests' points.
        GraderFailure: the gradebook cannot be written.
    """
    if exercise not in assignment.exercises:
        known = ", ".join(assignment.exercises)
        raise WrongUse(f"{assignment.name} has no exercise {exercise}; it has {known}.")
    reason = one_line(reason)
    if points and not reason:
        raise WrongUse("A mark by hand needs its reason, which the student reads: --reason TEXT.")
    if len(reason) > MOST_WORDS:
        raise WrongUse(f"The reason has {len(reason)} letters, and {MOST_WORDS} are enough.")
    database.refuse_missing(location)
    from nbgrader.api import MissingEntry  # nbgrader takes a second to import

    from robust_slam_autograder.nbgrader import gradebook

    with gradebook.opened(location) as book, gradebook.one_transaction(book):
        try:
            found = book.find_submission_notebook(assignment.notebook, assignment.name, student)
        except MissingEntry:
            raise WrongUse(_unknown(book, assignment.name, student)) from None
        owners = _exercises(assignment)
        rows = [row for row in found.grades if owners.get(row.name) == exercise]
        order = [case.grade_id for case in assignment.cases]
        rows.sort(key=lambda row: order.index(row.name))
        by_tests, most = _room(assignment, exercise, rows)
        if not 0 <= by_tests + points <= most:
            raise WrongUse(
                f"{exercise} of {student} has {tidy(by_tests)} of {tidy(most)} points by the "
                f"tests: {points:+g} would make {tidy(by_tests + points)}. Say from "
                f"{tidy(-by_tests):+} to {tidy(most - by_tests):+}."
            )
        before = sum(row.extra_credit or 0 for row in rows)
        for row in rows:
            row.extra_credit = None
            row.needs_manual_grade = False
        rows[0].extra_credit = points or None
        for comment in found.comments:
            if comment.name == assignment.owner(exercise):
                comment.manual_comment = _with_reason(comment.manual_comment, exercise, reason)
        book.db.commit()
        book.db.expire_all()
        whole = book.find_submission(assignment.name, student)
        return Change(by_tests, before, points, most, tidy(whole.score), tidy(whole.max_score))


def _unknown(book: Any, assignment: str, student: str) -> str:  # noqa: ANN401
    there = sorted(one.student_id for one in book.assignment_submissions(assignment))
    some = ", ".join(there[:10]) + (", …" if len(there) > 10 else "")
    return (
        f"The gradebook has no mark of {one_line(student)} in {assignment}: grade it first. "
        f"There are {some or 'none at all'}."
    )


def _room(assignment: Assignment, exercise: str, rows: Sequence[Any]) -> tuple[float, float]:
    """Return the points of an exercise by its tests, and the most that it is worth.

    Raises:
        WrongUse: a case has a score of a person's in place of the tests', or there is none.
    """
    if not rows:
        raise WrongUse(
            f"{exercise} was not there yet when this student was graded: grade again first."
        )
    for row in rows:
        if row.manual_score is not None:
            raise WrongUse(
                f"Somebody gave the case {row.name} {tidy(row.manual_score)} points in "
                "formgrader, in place of the tests': change them there, or empty that field first."
            )
    most = sum(case.points for case in assignment.cases if case.exercise == exercise)
    return sum(row.auto_score or 0 for row in rows), most


def _with_reason(comment: str | None, exercise: str, reason: str) -> str | None:
    """Return a comment with one reason for an exercise's points; without where it is empty."""
    kept = [
        line
        for line in (comment or "").splitlines()
        if not ((found := _READ.fullmatch(line)) and found[1] == exercise)
    ]
    lines = [*kept, *([_LINE.format(exercise, reason)] if reason else [])]
    return "\n".join(lines) or None
