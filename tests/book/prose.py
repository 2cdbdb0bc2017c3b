"""What a page says, and the numbers in it."""

import re
from functools import cached_property
from pathlib import Path
from typing import Any

import nbformat

from tools.prose.text import read_by_people

CHAPTERS = Path(__file__).parents[2] / "chapters"
DECIMAL = re.compile(r"(?<![\w.])-?\d+\.\d+(?!\.?\d)")
COUNTED = re.compile(
    DECIMAL.pattern + r"|(?<![\w/.^{])-?\d+/\d+(?![\w/]|\.\d)|(?<![\w.,/{])\d{3,}(?![\w/]|\.\d)"
)
"""Decimals, fractions and whole numbers of three digits."""
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+|/\d+)?")


class Chapter:
    def __init__(self, name: str) -> None:
        self.path = CHAPTERS / f"{name}.ipynb"

    @cached_property
    def _notebook(self) -> nbformat.NotebookNode:
        return nbformat.read(self.path, as_version=4)

    @cached_property
    def cells(self) -> dict[str, str]:
        return {cell["id"]: cell.source for cell in self._notebook.cells}

    @property
    def programs(self) -> dict[str, str]:
        cells = (cell for cell in self._notebook.cells if cell.cell_type == "code")
        return {cell["id"]: cell.source for cell in cells}

    @property
    def code(self) -> dict[str, str]:
        """The source of each cell with code, but for those that show a live picture."""
        return {name: text for name, text in self.programs.items() if "pictures." not in text}

    @cached_property
    def text(self) -> str:
        """The markdown, captions, alternative texts and quizzes."""
        parts = (part for cell in self._notebook.cells for part in read_by_people(cell))
        return "\n".join(parts).replace("−", "-")

    def run(self, *cells: str, **names: Any) -> dict[str, Any]:
        """Execute cells; return the names that they define, beside the given ones."""
        for cell in cells:
            exec(self.cells[cell].replace("use_style()\n", ""), names)
        return names

    def questions(self) -> list[Any]:
        names = self.run(*(name for name, source in self.cells.items() if "Question(" in source))
        return [value for value in names.values() if isinstance(value, names["Question"])]


def decimals(text: str) -> set[str]:
    """Return every number with a decimal point in the text, as it is printed."""
    return set(DECIMAL.findall(text))


def numbers_of(text: str) -> list[str]:
    """Return every number in the text, fractions whole."""
    return NUMBER.findall(text)


def rounds_to(value: float, printed: str) -> bool:
    """Tell whether the value, rounded to as many decimals, is the printed number.

    A fraction is exact.
    """
    top, _, bottom = printed.partition("/")
    slack = 1e-9 if bottom else 0.5 * 10.0 ** -len(printed.partition(".")[2])
    return bool(abs(float(top) / float(bottom or 1) - value) <= slack * (1.0 + 1e-9))
