"""What a chapter prints, and the frame of the tests that compute its numbers once more."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import nbformat
import numpy as np

from tools.prose.text import read_by_people

CHAPTERS = Path(__file__).parents[2] / "chapters"
DECIMAL = re.compile(r"(?<![\w.])-?\d+\.\d+(?!\.?\d)")
NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?")
Formula = Callable[[Any], float | Sequence[float]]


class Chapter:
    """The notebook of a chapter."""

    def __init__(self, name: str) -> None:
        self.path = CHAPTERS / f"{name}.ipynb"

    @cached_property
    def _notebook(self) -> nbformat.NotebookNode:
        return nbformat.read(self.path, as_version=4)

    @cached_property
    def cells(self) -> dict[str, str]:
        """The source of each cell by its id."""
        return {cell["id"]: cell.source for cell in self._notebook.cells}

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
        """The questions of the chapter's quizzes."""
        names = self.run(*(name for name, source in self.cells.items() if "Question(" in source))
        return [value for value in names.values() if isinstance(value, names["Question"])]


class Numbers:
    """The tests of a chapter's table of formulas.

    A key of the table is one or more decimals, or a phrase of the page. A formula takes what the
    module's fixture ``page`` holds, and gives one value for all the
    numbers of its key, or one for each.
    """

    chapter: Chapter
    formulas: Mapping[str, Formula]
    given: str
    """Decimals that are data, chosen or of other texts, or have a test of their own."""

    def test_what_is_printed_is_computed(self, printed: str, page: Any) -> None:
        """The number or phrase is on the page, and its numbers are the computed ones rounded."""
        if all(map(DECIMAL.fullmatch, printed.split())):
            assert set(printed.split()) <= decimals(self.chapter.text)
        else:
            assert printed in self.chapter.text
        numbers, values = NUMBER.findall(printed), self.formulas[printed](page)
        if np.ndim(values) == 0:
            values = np.full(len(numbers), values)
        assert len(values) == len(numbers) > 0
        wrong = {
            number: float(value)
            for number, value in zip(numbers, values, strict=True)
            if not rounds_to(value, number)
        }
        assert not wrong

    def test_every_decimal_on_the_page_has_a_formula_or_is_given(self) -> None:
        given = set(self.given.split())
        known = decimals(" ".join(self.formulas)) | given
        assert decimals(self.chapter.text) - known == set()
        assert given - decimals(self.chapter.text) == set()


def decimals(text: str) -> set[str]:
    """Return every number with a decimal point in the text, as it is printed."""
    return set(DECIMAL.findall(text))


def rounds_to(value: float, printed: str) -> bool:
    """Tell whether the value, rounded to as many decimals, is the printed number."""
    half_a_unit = 0.5 * 10.0 ** -len(printed.partition(".")[2])
    return bool(abs(float(printed) - value) <= half_a_unit * (1.0 + 1e-9))
