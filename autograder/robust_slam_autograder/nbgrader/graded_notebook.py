"""The notebook that formgrader and nbgrader's feedback show for a graded submission.

The student's own text under the instructor's metadata; each test cell as students have it, with
an output that says how it went. Nothing in it was run in a kernel, and no output and no metadata
of the submission's is taken over.
"""

from collections.abc import Mapping
from contextlib import suppress

from nbformat.notebooknode import NotebookNode
from nbformat.v4 import new_notebook, new_output

from robust_slam_autograder.errors import Refused
from robust_slam_autograder.grading.results import CaseResult, Result, by_grade_id, tidy
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.grading.verdicts import sign, verdict
from robust_slam_autograder.markup import prose, visible
from robust_slam_autograder.nbgrader import marked_cells
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.notebook import Cell

NOT_FOUND = "# Nothing was found for this cell."
KERNEL = {"display_name": "Python 3", "language": "python", "name": "python3"}


def build(handed: Submission, result: Result) -> NotebookNode:
    """Make the notebook of a submission's cells; it has none where it could not be read."""
    cells: tuple[Cell, ...] = ()
    assignment = handed.assignment
    with suppress(Refused):
        cells = handed.cells()
    known = {cell.grade_id: cell for cell in assignment.marked}
    given = marked_cells.given(assignment.marked)
    outcomes = _outcomes(assignment, result)

    def marked(grade_id: str, source: str | None) -> NotebookNode:
        """Make a cell under the instructor's metadata, with the student's text where it counts."""
        cell = known[grade_id]
        if source is None:
            source = NOT_FOUND if cell.kind == "code" else NOT_FOUND.lstrip("# ")
        made = marked_cells.node(cell, source if cell.solution else given[grade_id].source)
        if grade_id in outcomes:
            text = outcomes[grade_id]
            made["outputs"] = [new_output("stream", name="stdout", text=text)]  # type: ignore[no-untyped-call]
        return made

    owners = submission.stands_for(assignment, cells)
    shown: list[tuple[str | None, NotebookNode]] = []
    for number, cell in enumerate(cells):
        owner = owners.get(number)
        own = marked_cells.plain(cell.kind, cell.source)
        shown.append((owner, marked(owner, cell.source) if owner else own))
    place = 0  # of a cell that the submission lacks: behind the one that it follows in the release
    for grade_id in (cell.grade_id or "" for cell in assignment.marked):
        if grade_id not in owners.values():
            shown.insert(place, (grade_id, marked(grade_id, None)))
        place = [name for name, _ in shown].index(grade_id) + 1
    book: NotebookNode = new_notebook(  # type: ignore[no-untyped-call]
        cells=[_heading(result), *(cell for _, cell in shown)], metadata={"kernelspec": KERNEL}
    )
    for number, cell in enumerate(book.cells):
        cell["id"] = f"cell-{number}"  # the same notebook for the same result
    return book


def _heading(result: Result) -> NotebookNode:
    note = f"\n\n{prose(result.reason)}" if result.reason else ""
    return marked_cells.plain("markdown", f"**{prose(verdict(result))}**{note}")


def _outcomes(assignment: Assignment, result: Result) -> Mapping[str, str]:
    """Return by grade id how each case went, in words for the student."""
    found = by_grade_id(result, assignment)
    return {
        case.grade_id: _outcome(found.get(case.grade_id), case.points) for case in assignment.cases
    }


def _outcome(case: CaseResult | None, points: float) -> str:
    if case is None:
        return f"✗ not run: 0 of {tidy(points)} points\n"
    word = sign("passed" if case.passed else "failed")
    message = f"{visible(case.message)}\n" if case.message else ""
    return f"{word}: {case.earned} of {case.points} points\n{message}"
