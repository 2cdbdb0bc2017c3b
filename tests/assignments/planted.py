"""A small source tree of one exercise, to plant weak cases in."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import nbformat.v4

NAME = "planted"
SETUP = "import numpy as np"


def plant(tree: Path, exercise: str, solution: str, cases: Mapping[str, str]) -> None:
    """Write the assignment ``planted``; the cases are test cells by name, one point each."""
    cells = [_cell(SETUP, "setup"), _cell(solution, exercise, solution=True, locked=False)]
    for name, source in cases.items():
        cells.append(_cell(source, f"{exercise}-{name}", grade=True, points=1))
    path = tree / NAME / f"{NAME}.ipynb"
    path.parent.mkdir(parents=True)
    nbformat.write(nbformat.v4.new_notebook(cells=cells), path)


def _cell(source: str, grade_id: str, **fields: object) -> nbformat.NotebookNode:
    marks = {"grade": False, "solution": False, "locked": True, "schema_version": 3, **fields}
    metadata = {"nbgrader": {"grade_id": grade_id, **marks}}
    return nbformat.v4.new_code_cell(source, metadata=metadata)
