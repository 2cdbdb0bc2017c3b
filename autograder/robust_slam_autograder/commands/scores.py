"""``autograder scores``: replay a class's scores of a game, as a table."""

import argparse
import csv
import io
import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.grading import durable
from robust_slam_autograder.lms import roster
from robust_slam_autograder.markup import as_csv, one_line
from robust_slam_autograder.reading.notebook import read_bytes, shown

_SCORE = re.compile(r"[\w:,+-]{1,60}", re.ASCII)
_LONGEST = 1000
"""Of a student's line or file that is read."""
_SECONDS = 60
_REPLAYED = (0, 1)
"""Exit codes of a command that has printed its line."""


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "scores", type=Path, metavar="PATH", help="a CSV of student,score, or a folder of files"
    )
    parser.add_argument(
        "--replay",
        default="robust-slam replay",
        metavar="COMMAND",
        help="replays the score behind it, and prints a head and a line of CSV, by which the "
        "table is sorted (%(default)s)",
    )
    parser.add_argument("--no-names", action="store_true", help="leave the students out")
    parser.add_argument("--to", type=Path, default=layout.CLASS / "scores.csv", metavar="FILE")


def run(options: argparse.Namespace) -> int:
    """Write the table: scores that were replayed, the best first, and then what was refused."""
    places.refuse_unwritable("--to", options.to, made=layout.CLASS)
    given = _given(options.scores)
    if options.to.exists() and options.to.samefile(options.scores):
        raise WrongUse(f"--to {options.to} holds the scores themselves: name another file.")
    command = _command(options.replay)
    table, refused, head = [], [], []
    for student, score in given:
        lines, error = _replayed(command, score)
        if error:
            refused.append([shown(one_line(text)) for text in (student, score, error)])
        else:
            head, told = lines
            table.append([shown(student), score, "", *told])
    table.sort(key=lambda row: [_sortable(cell) for cell in row[3:]])
    rows = [["student", "score", "refused", *head], *table, *refused]
    durable.write(options.to, as_csv(row[options.no_names :] for row in rows))
    print(f"{len(table)} scores were replayed, and {len(refused)} refused: {options.to}")
    return 0


def _given(path: Path) -> list[tuple[str, str]]:
    """Return the students with their scores; a file that is a link or no plain one has none."""
    if path.is_dir():
        files = (one for one in sorted(path.iterdir()) if one.is_symlink() or not one.is_dir())
        return [(one.stem, _text(one)) for one in files]
    if path.is_symlink():
        raise WrongUse(f"{path} is a link: name the file that it leads to.")
    delimiter, text = roster.parted(roster.read_text(path))
    # Line by line, so that a quote that one student opens does not swallow the next ones.
    lines = [line[:_LONGEST] for line in io.StringIO(text, newline=None) if line.strip()]
    rows = [next(csv.reader([line], delimiter=delimiter)) for line in lines]
    found = [(row[0], ",".join(row[1:]).strip()) for row in rows]
    return found[1:] if found and found[0][1].lower() == "score" else found


def _text(path: Path) -> str:
    try:
        if path.lstat().st_nlink > 1:
            return "(a file with another name elsewhere)"
        return read_bytes(path)[:_LONGEST].decode("utf-8-sig", errors="replace").strip()
    except Refused:
        return "(no plain file)"


def _command(text: str) -> list[str]:
    """Return the words of the command, which is on the path or beside this Python."""
    name, *words = shlex.split(text) or [""]
    beside = os.fspath(Path(sys.executable).parent)
    found = shutil.which(name, path=os.pathsep.join([beside, os.environ.get("PATH", "")]))
    if found is None:
        raise WrongUse(f"--replay {text}: there is no command {name}; install it or name another.")
    return [found, *words]


def _replayed(command: list[str], score: str) -> tuple[list[list[str]], str]:
    """Return what the command printed, head and line, or a reason why not."""
    if not _SCORE.fullmatch(score):
        return [], "no score"
    try:
        done = subprocess.run(
            [*command, "--", score], capture_output=True, text=True, timeout=_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        return [], f"the replay took more than {_SECONDS} s"
    lines = list(csv.reader(done.stdout.splitlines()))
    if done.returncode not in _REPLAYED or len(lines) != 2:
        return [], (done.stderr.strip().splitlines() or ["no answer"])[-1]
    return lines, ""


def _sortable(cell: str) -> tuple[int, float, str]:
    """Return a key that sorts numbers by their values, and before words."""
    try:
        return 0, float(cell), ""
    except ValueError:
        return 1, 0.0, cell
