"""Which of a submission's cells stand for the instructor's, and what was written by hand."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.notebook import Cell


def by_hand(cell: Cell) -> bool:
    """Tell whether a person marks the cell: a free-text answer, or a task."""
    return cell.task or (cell.grade and (cell.solution or cell.kind != "code"))


def owners(assignment: Assignment, cells: Sequence[Cell]) -> dict[int, str]:
    """Find which of the instructor's cells a submission's cells (by position) stand for.

    Of copied cells it is the last one, whose definitions hold in the end.
    """
    known = {cell.grade_id for cell in assignment.marked}
    last = {cell.grade_id: number for number, cell in enumerate(cells) if cell.grade_id in known}
    last |= {
        grade_id: n for n, grade_id in sorted(submission.owners(cells, assignment)[0].items())
    }
    return {number: grade_id for grade_id, number in last.items() if grade_id is not None}


def digest(text: str) -> str:
    """Return what tells a free-text answer from another, blanks around it aside."""
    return hashlib.sha256(text.strip().encode(errors="surrogatepass")).hexdigest()


def texts(assignment: Assignment, cells: Sequence[Cell]) -> dict[str, str]:
    """Return by grade id the digest of what stands in each free-text cell; of none, of nothing."""
    wanted = [cell.grade_id or "" for cell in assignment.marked if by_hand(cell) and not cell.task]
    found = {owner: cells[number].source for number, owner in owners(assignment, cells).items()}
    return {name: digest(found.get(name, "")) for name in wanted}
