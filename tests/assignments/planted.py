"""A small source tree of one exercise, to plant weak cases in."""

from collections.abc import Mapping
from pathlib import Path

from autograder.tests import toy

NAME = "planted"


def plant(tree: Path, exercise: str, solution: str, cases: Mapping[str, str]) -> None:
    """Write the assignment ``planted``; the cases are test cells by name, one point each."""
    cells = [toy.cell("import numpy as np", "setup", locked=True)]
    cells.append(toy.cell(solution, exercise, solution=True))
    cells += [toy.test_cell(source, f"{exercise}-{name}", 1) for name, source in cases.items()]
    toy.write(tree / NAME / f"{NAME}.ipynb", toy.notebook(cells))
