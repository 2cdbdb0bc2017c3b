"""The instructor's marked cells in nbgrader's own form, before and after the release's cuts.

nbgrader's own steps cut solutions, hidden tests and marking schemes: what is cut here is what
``nbgrader generate_assignment`` cuts.
"""

from collections.abc import Mapping, Sequence

from nbformat.notebooknode import NotebookNode
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook
from nbgrader.preprocessors import ClearHiddenTests, ClearMarkScheme, ClearSolutions
from traitlets.config import Config

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.nbgrader.settings import STUB
from robust_slam_autograder.reading.notebook import Cell

SCHEMA_VERSION = 3
Nodes = Mapping[str, NotebookNode]
"""By grade id."""


def node(cell: Cell, source: str) -> NotebookNode:
    """Return an nbformat cell with the instructor's metadata and any text."""
    made = plain(cell.kind, source)
    made.metadata["nbgrader"] = _metadata(cell)
    return made


def plain(kind: str, source: str) -> NotebookNode:
    """Return an nbformat cell without metadata.

    Raw cells become code: a page that is made of a notebook would take them over unread.
    """
    make = new_markdown_cell if kind == "markdown" else new_code_cell
    made: NotebookNode = make(source)  # type: ignore[no-untyped-call]
    return made


def _metadata(cell: Cell) -> dict[str, object]:
    names = ("grade_id", "grade", "solution", "locked", "task")
    points = {"points": cell.points} if cell.grade or cell.task else {}
    fields = {name: getattr(cell, name) for name in names}
    return {**fields, "schema_version": SCHEMA_VERSION, **points}


def kept(marked: Sequence[Cell]) -> Nodes:
    """Return the cells as nbgrader's gradebook keeps them: without solutions, tests whole.

    Raises:
        GraderFailure: a solution's region is not closed.
    """
    return _through(marked, [ClearSolutions])


def given(marked: Sequence[Cell]) -> Nodes:
    """Return the cells as students have them.

    Raises:
        GraderFailure: a region to be cut is not closed.
    """
    return _through(marked, [ClearSolutions, ClearHiddenTests, ClearMarkScheme])


def _through(marked: Sequence[Cell], steps: Sequence[type]) -> Nodes:
    config = Config({"ClearSolutions": {"code_stub": {"python": STUB}}})
    cells = [node(cell, cell.source) for cell in marked]
    made = new_notebook(cells=cells)  # type: ignore[no-untyped-call]
    try:
        for step in steps:
            made, _ = step(config=config).preprocess(made, {})
    except RuntimeError as error:
        why = str(error).rstrip(".")
        raise GraderFailure(f"nbgrader cannot read the instructor's notebook: {why}.") from error
    return {cell.metadata.nbgrader["grade_id"]: cell for cell in made.cells}
