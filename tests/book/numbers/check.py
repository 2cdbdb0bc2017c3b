"""Name the sentences of a page that no longer hold: ``python -m tests.book.numbers.check 02``.

Each page with code has a table beside this module. Its rows are grouped by the cell after which
they are evaluated, and lead from what the text says, one or more numbers or a phrase, to an
expression over the names that the page's cells have defined by then: one value for all numbers,
one for each, or for a phrase whether it is true. ``names.x`` is a further name that rows need, and
``given`` lists numbers that are data, chosen or of other texts. Every other decimal, fraction and
number of three digits needs a row.
"""

import contextlib
import io
import re
import sys
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import pyplot as plt

from chapters._ext import names as kept_names
from chapters._ext import notebooks
from tests.book.numbers import beside
from tests.book.prose import CHAPTERS, COUNTED, Chapter, numbers_of, rounds_to

TABLES = {path.stem: path for path in sorted(Path(__file__).parent.glob("*.toml"))}
SENTENCE = re.compile(r"(?<=[.:?!|])\s+|\n\n|\n(?=[|*-])")


@dataclass(frozen=True)
class Row:
    """What a text says, the expression that gives it, and its value on the executed page."""

    says: str
    expression: str
    value: np.ndarray


def computed(name: str, data: Mapping[str, str] | None = None) -> list[Row]:
    """Return the rows of a page's table, with the values that the page's cells give.

    They are those of the run that the book shows; with other data the page runs again, here.

    Args:
        name: The page, as its notebook is called.
        data: Pieces of its code, and what takes their place.

    Raises:
        KeyError: The table names a cell that the page does not have.
    """
    after = dict(_table(name)["after"])
    rows: list[Row] = []
    further: dict[str, Any] = {}
    seen = shown(name) if data is None else ((cell, names) for cell, names, _ in run(name, data))
    for cell, names in seen if after else ():
        table = dict(after.pop(cell, {}))
        scope = vars(beside) | names | further
        for each, expression in table.pop("names", {}).items():
            scope[each] = further[each] = _value(expression, scope)
        for says, expression in table.items():
            rows.append(Row(says, expression, np.asarray(_value(expression, scope))))
    if after:
        raise KeyError(f"{TABLES[name].name} names cells that {name} does not have: {[*after]}")
    return rows


def shown(name: str) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the id of each cell with code and the names after it, as the book was made of them.

    A page that has changed since then runs first, as it does for the book.
    """
    page = Chapter(name)
    folder = notebooks.run_here([page.path])
    return zip(page.programs, kept_names.kept(folder, page.programs.values()), strict=True)


def run(
    name: str, data: Mapping[str, str], last: str | None = None
) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Execute a page up to its last cell, or up to another one.

    Yields:
        Each cell's id, the names that are defined after it, and what it prints.
    """
    names: dict[str, Any] = {}
    with mpl.rc_context(), contextlib.chdir(CHAPTERS):
        mpl.use("agg")
        for cell, source in Chapter(name).code.items():
            for old, new in data.items():
                source = source.replace(old, new)
            printed = io.StringIO()
            with contextlib.redirect_stdout(printed):
                exec(compile(source, f"{name}:{cell}", "exec"), names)
            plt.close("all")
            yield cell, names, printed.getvalue()
            if cell == last:
                return


def complaints(name: str, text: str, rows: list[Row]) -> list[str]:
    """Return what a page says and does not compute, a sentence each."""
    given = _table(name)["given"].split()
    known = {*given, *(number for row in rows for number in COUNTED.findall(row.says))}
    unknown = sorted(set(COUNTED.findall(text)) - known)
    return [
        *(f"{number} has no row: {_sentences(text, number)}" for number in unknown),
        *(f"{number} is given, and not on the page" for number in given if number not in text),
        *(complaint for row in rows for complaint in _wrong(row, text)),
    ]


def _value(expression: str, scope: dict[str, Any]) -> Any:
    return eval(f"({expression})", scope)  # in brackets, so that it may have several lines


def _table(name: str) -> dict[str, Any]:
    return tomllib.loads(TABLES[name].read_text("utf-8"))


def _wrong(row: Row, text: str) -> Iterator[str]:
    """Yield what is wrong with a row: numbers that are others now, a phrase that is not there."""
    numbers = numbers_of(row.says)
    parts = numbers if numbers == row.says.split() else [row.says]
    yield from (f"not on the page: {part!r}" for part in parts if not _exactly(part).search(text))
    if row.value.dtype == bool:
        if not row.value.all():
            yield f"no longer true: {_sentences(text, row.says)} ({row.expression})"
        return
    values = np.full(len(numbers), row.value) if row.value.ndim == 0 else row.value
    if len(values) != len(numbers) or not numbers:
        yield f"{row.says!r} has {len(numbers)} numbers, {row.expression} gives {len(values)}"
    for number, value in zip(numbers, values, strict=False):
        if not rounds_to(float(value), number):
            sentences = _sentences(text, number if len(parts) > 1 else row.says)
            yield f"{number} is {value:.9g} now: {sentences}"


def _sentences(text: str, part: str) -> str:
    """Return the sentences of the text with a number or phrase."""
    return " … ".join(s.strip() for s in SENTENCE.split(text) if _exactly(part).search(s))


def _exactly(part: str) -> re.Pattern[str]:
    return re.compile(rf"(?<![\w.]){re.escape(part)}(?!\w|\.\d)")


def main(wanted: list[str]) -> int:
    """Print the complaints about the pages whose names begin so; return 1 if there are any."""
    unknown = [each for each in wanted if not any(name.startswith(each) for name in TABLES)]
    if unknown:
        known = ", ".join(TABLES)
        print(f"No page begins with {unknown}. The pages are {known}.", file=sys.stderr)
        return 2
    are_wrong = False
    for name in (name for name in TABLES if name.startswith(tuple(wanted) or "")):
        found = complaints(name, Chapter(name).text, computed(name))
        are_wrong |= bool(found)
        said = "\n".join(found) or "Every number is what the page computes."
        print(said, f"({name})", flush=True)
    return int(are_wrong)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
