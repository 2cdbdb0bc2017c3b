"""Text that others wrote, made fit for a page, for Markdown, a terminal and a spreadsheet.

Names, exception texts and file names are a student's to choose. Here they lose
the power to do anything but be read.
"""

import csv
import io
import re
import unicodedata
from collections.abc import Iterable

_KEPT = "\n\t"
_ACTING = {"Zl", "Zp"}
"""Categories of characters that act and do not show, beside control characters and their like."""
_FORMULA = re.compile(r"""(^|[;\t\r\n])(?=[\s"]*[-=+@＝＋－＠]|[\t\r\n])""")
"""Where a cell begins that spreadsheets compute; some read the wide forms alike.

Where a spreadsheet takes another mark than the comma, a cell begins behind that mark, too.
"""
_GRADE = re.compile(r"-|-?\d+([.,]\d+)?")
"""What begins as a formula does, and is a number or a sign alone."""
_CI_COMMAND = re.compile(r"^::|##(?=\w*\[)")


def visible(text: str) -> str:
    r"""Write each character that acts or does not show as its code, as in ``\u202e``.

    Line breaks and tabs stay. Terminal escapes, changes of direction, characters of no
    width and halves of characters do not.
    """
    lines = text.replace("\r\n", "\n")
    return "".join(
        letter.encode("unicode_escape").decode("ascii") if _acts(letter) else letter
        for letter in lines
    )


def _acts(letter: str) -> bool:
    kind = unicodedata.category(letter)
    return letter not in _KEPT and (kind.startswith("C") or kind in _ACTING)


def one_line(text: str) -> str:
    """Text without line breaks, fit for a line of a table on a terminal or in a log."""
    return _disarmed(" ".join(visible(text).split()))


def log_line(text: str) -> str:
    """A path or a name for a message: line breaks and tabs are written as codes too."""
    return _disarmed(visible(text).replace("\n", "\\n").replace("\t", "\\t"))


def _disarmed(line: str) -> str:
    r"""A line that no CI service obeys: the mark that begins a command is written as its code.

    GitHub reads ``::error::`` at a line's start and ``##[error]`` anywhere, Azure
    ``##vso[…]``, TeamCity ``##teamcity[…]``.
    """
    return _CI_COMMAND.sub(lambda mark: f"\\x{ord(mark[0][0]):02x}{mark[0][1:]}", line)


def code(text: str) -> str:
    """A Markdown code span: no link, mention, markup or HTML of the text comes to life in it.

    Text of no letters gives nothing.
    """
    plain = one_line(text)
    if not plain:
        return ""
    # Longer than any in the text, and apart from one at either end.
    fence = "`" * (1 + max(map(len, re.findall("`+", plain)), default=0))
    space = " " if plain.startswith("`") or plain.endswith("`") else ""
    return f"{fence}{space}{plain}{space}{fence}"


def cell(text: str) -> str:
    """A code span for a cell of a Markdown table.

    Renderers do not agree on how a bar in a cell is escaped: it becomes a broken bar.
    """
    return code(text).replace("|", "¦")


def prose(text: str) -> str:
    """Markdown that shows an instructor's words as they are."""
    return re.sub(r"([\\`*_{}\[\]<>()#!|~&@:$])", r"\\\1", one_line(text))


def as_text(name: str) -> str:
    """Return a name as text that no spreadsheet computes: with an apostrophe where it would."""
    return _FORMULA.sub(r"\1'", name)


class Grade(str):
    """A cell that another system wrote as a grade: ``-`` and ``-3,5`` stay as they are."""


def as_cell(text: str) -> str:
    """Return what ``as_csv`` writes for a text."""
    if isinstance(text, Grade) and _GRADE.fullmatch(text):
        return text
    return as_text(visible(text))


def as_csv(rows: Iterable[Iterable[object]]) -> str:
    """Return a table as CSV, in which no text is computed; numbers and times stay.

    No other code of this package writes CSV, so that this cannot be forgotten.
    """
    file = io.StringIO(newline="")
    safe = ([as_cell(one) if isinstance(one, str) else one for one in row] for row in rows)
    csv.writer(file, lineterminator="\n").writerows(safe)
    return file.getvalue()
