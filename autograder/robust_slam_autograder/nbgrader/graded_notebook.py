"""The notebook that formgrader and nbgrader's feedback show for a graded submission.

The student's own text under the instructor's metadata; each test cell as students have it, with
an output that says how it went. Nothing in it was run in a kernel, and no output and no metadata
of the submission's is taken over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from nbformat.notebooknode import NotebookNode
from nbformat.v4 import new_notebook, new_output

from robust_slam_autograder.grading.results import CaseResult, Result, tidy
from robust_slam_autograder.grading.verdicts import sign, verdict
from robust_slam_autograder.markup import prose, visible
from robust_slam_autograder.nbgrader import marked_cells
from robust_slam_autograder.reading import answers
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.notebook import Cell

NOT_FOUND = "# Nothing was found for this cell."
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def build(assignment: Assignment, cells: Sequence[Cell], result: Result) -> NotebookNode:
    """Make the notebook.

    Args:
        assignment: the instructor's notebook.
        cells: the submission's; none where it could not be read.
        result: its result.
    """
    made = _Cells(assignment, result)
    owners = answers.owners(assignment, cells)
    shown: list[tuple[str | None, NotebookNode]] = []
    for number, cell in enumerate(cells):
        owner = owners.get(number)
        own = marked_cells.plain(cell.kind, cell.source)
        shown.append((owner, made.marked(owner, cell.source) if owner else own))
    before = None
    for marked in assignment.marked:
        grade_id = marked.grade_id or ""
        if grade_id not in owners.values():
            _insert_after(shown, before, (grade_id, made.marked(grade_id, None)))
        before = grade_id
    book = new_notebook(  # type: ignore[no-untyped-call]
        cells=[_heading(result), *(cell for _, cell in shown)], metadata={"kernelspec": KERNEL}
    )
    for number, cell in enumerate(book.cells):
        cell["id"] = f"cell-{number}"  # the same notebook for the same result
    checked: NotebookNode = book
    return checked


def _insert_after(
    shown: list[tuple[str | None, NotebookNode]],
    before: str | None,
    cell: tuple[str | None, NotebookNode],
) -> None:
    """Put a cell that the submission lacks behind the one that it follows in the release."""
    names = [grade_id for grade_id, _ in shown]
    shown.insert(0 if before is None else names.index(before) + 1, cell)


def _heading(result: Result) -> NotebookNode:
    note = f"\n\n{prose(result.reason)}" if result.reason else ""
    return marked_cells.plain("markdown", f"**{prose(verdict(result))}**{note}")


class _Cells:
    """Makes the marked cells of one submission."""

    def __init__(self, assignment: Assignment, result: Result) -> None:
        self._marked = {cell.grade_id: cell for cell in assignment.marked}
        self._given = marked_cells.given(assignment.marked)
        self._outcomes = _outcomes(assignment, result)

    def marked(self, grade_id: str, source: str | None) -> NotebookNode:
        """Make a cell under the instructor's metadata, with the student's text where it counts."""
        cell = self._marked[grade_id]
        missing = NOT_FOUND if cell.kind == "code" else NOT_FOUND.lstrip("# ")
        text = missing if source is None else source
        made = marked_cells.node(cell, text if cell.solution else self._given[grade_id].source)
        if grade_id in self._outcomes:
            output = new_output(  # type: ignore[no-untyped-call]
                "stream", name="stdout", text=self._outcomes[grade_id]
            )
            made["outputs"] = [output]
        return made


def _outcomes(assignment: Assignment, result: Result) -> Mapping[str, str]:
    """Return by grade id how each case went, in words for the student."""
    found = {
        (exercise.name, case.name): case
        for exercise in result.exercises
        for case in exercise.cases
    }
    return {
        case.grade_id: _outcome(found.get((case.exercise, case.name)), case.points)
        for case in assignment.cases
    }


def _outcome(case: CaseResult | None, points: float) -> str:
    if case is None:
        return f"✗ not run: 0 of {tidy(points)} points\n"
    word = sign("passed" if case.passed else "failed")
    message = f"{visible(case.message)}\n" if case.message else ""
    return f"{word}: {case.earned} of {case.points} points\n{message}"
