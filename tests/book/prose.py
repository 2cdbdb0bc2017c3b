"""The numbers that a chapter prints, for the tests that check them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import nbformat

CHAPTERS = Path(__file__).parents[2] / "chapters"
DECIMAL = re.compile(r"(?<![\w.])-?\d+\.\d+(?!\.?\d)")


def chapter_text(name: str) -> str:
    """Return the markdown, captions, alternative texts and quizzes of a chapter's notebook."""
    notebook = nbformat.read(CHAPTERS / name, as_version=4)
    return "\n".join(part for cell in notebook.cells for part in _read_by_people(cell))


def decimals(text: str) -> set[str]:
    """Return every number with a decimal point in the text, as it is printed."""
    return set(DECIMAL.findall(text.replace("−", "-")))


def rounds_to(value: float, printed: str) -> bool:
    """Tell whether the value, rounded to as many decimals, is the printed number."""
    half_a_unit = 0.5 * 10.0 ** -len(printed.split(".")[1])
    return abs(float(printed) - value) <= half_a_unit * (1.0 + 1e-9)


def unchecked(text: str, claims: Mapping[str, float], given: set[str]) -> set[str]:
    """Return the printed decimals that are neither claims nor given data."""
    return decimals(text) - set(claims) - given


def _read_by_people(cell: nbformat.NotebookNode) -> Iterator[str]:
    if cell.cell_type == "markdown" or "Question(" in cell.source:
        yield cell.source
    shown = cell.metadata.get("mystnb", {})
    yield shown.get("figure", {}).get("caption", "")
    yield shown.get("image", {}).get("alt", "")
