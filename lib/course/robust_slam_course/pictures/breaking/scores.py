"""A class's scores, replayed, as a table: whatever students hand in."""

import csv
import os
import re
import stat
from collections.abc import Iterable, Sequence
from pathlib import Path

from robust_slam_course.pictures.breaking import rules

HEAD = ("town", "solver", "result", "outliers", "offset in m", "map bent by m")
FOOLED = "fooled"
_LONGEST = 200
"""Of a student's line or file that is read, in characters."""
_LINE = re.compile(r'\s*(?:"((?:[^"]|"")*)"|([^,;\t]*))[,;\t]\s*(.*)')
"""A student, in quotes where the name has a mark in it, and the score."""
_FORMULA = re.compile(r"(^|[;\t])(?=[\s\"]*[-=+@＝＋－＠])")
"""Where a cell begins that spreadsheets compute, whatever mark they part cells by."""
_LINKS = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)


def replayed(attack: rules.Attack) -> tuple[str, ...]:
    """Return what becomes of the solver, a cell for each of ``HEAD``."""
    bent, (count, offset) = rules.bent(attack), attack.rank
    result = FOOLED if bent > rules.BOUND else f"not {FOOLED}"
    return attack.town, attack.solver, result, str(count), f"{offset:.2f}", f"{bent:.4f}"


def write(given: Path, to: Path, *, names: bool) -> str:
    """Write the table: scores that were replayed, the best first, and then what was refused.

    Args:
        given: a CSV with a line for each student, or a folder with a file for each.
        to: the table.
        names: tells the students.

    Returns:
        A line that says what was done.

    Raises:
        OSError: a path cannot be read or written.
        ValueError: ``given`` is a link or no text, or ``to`` would overwrite it.
    """
    found = _given(given)
    if to.exists() and to.samefile(given):
        raise ValueError(f"--to {to} holds the scores themselves: name another file.")
    table, refused = [], []
    for student, score in found:
        try:
            attack = rules.attack(score)
        except ValueError as error:
            refused.append([student, score, str(error)])
        else:
            told = replayed(attack)
            table.append((told[:3], attack.rank, [student, score, "", *told]))
    rows = [row for *_, row in sorted(table, key=lambda one: one[:2])]
    head = ["student", "score", "refused", *HEAD]
    _write(to, [row[not names :] for row in (head, *rows, *refused)])
    return f"{len(rows)} scores were replayed, and {len(refused)} refused: {to}"


def _given(path: Path) -> list[tuple[str, str]]:
    """Return the students with their scores; a file that is a link or no plain one has none."""
    if path.is_dir():
        files = (one for one in sorted(path.iterdir()) if one.is_symlink() or not one.is_dir())
        return [(one.stem, _beginning(one).strip()) for one in files]
    if path.is_symlink():
        raise ValueError(f"{path} is a link: name the file that it leads to.")
    data = path.read_bytes()
    try:
        text = data.decode("utf-16" if data[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError as error:
        raise ValueError(f"{path} is not UTF-8: save it as CSV UTF-8.") from error
    lines = [line[:_LONGEST] for line in text.splitlines() if line.strip()]
    found = [_parted(line) for line in lines if not re.fullmatch(r"sep=.", line)]
    return found[1:] if found and found[0][1].lower() == "score" else found


def _parted(line: str) -> tuple[str, str]:
    found = _LINE.match(line)
    if found is None:
        return line, ""
    quoted, plain, score = found.groups()
    student = plain if quoted is None else quoted.replace('""', '"')
    return student, score.strip().strip('"')


def _beginning(path: Path) -> str:
    """Return the first characters of a plain file that has no other name."""
    try:
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | _LINKS)) as file:
            about = os.fstat(file.fileno())
            if stat.S_ISREG(about.st_mode) and about.st_nlink == 1:
                return file.read(_LONGEST).decode("utf-8-sig", errors="replace")
    except OSError:
        pass
    return "(a link, or no plain file)"


def _cell(text: str) -> str:
    """Return a student's text in one short line that no spreadsheet computes."""
    plain = "".join(letter if letter.isprintable() else "?" for letter in text)
    return _FORMULA.sub(r"\1'", plain[:80])


def _write(path: Path, rows: Iterable[Sequence[str]]) -> None:
    """Write the table at once: a full disk leaves the one before, and no text is computed."""
    path.parent.mkdir(exist_ok=True)
    new = path.with_name(f"{path.name}.new")
    with open(new, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")  # noqa: TID251
        writer.writerows([_cell(each) for each in row] for row in rows)
    new.replace(path)
