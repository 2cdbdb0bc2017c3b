"""The whole suite: every assignment, every back end, as root and as an ordinary user.

``python -m tests.autograder.hostile.soak`` grades all submissions and ends with a table.
Started as root it does so once more as an ordinary user.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.sandbox import BACK_ENDS

from tests import as_user
from tests.autograder import toy
from tests.autograder.hostile import batch, catalogue
from tests.autograder.hostile.batch import Report

ROOT = Path(__file__).resolve().parents[3]
SEED = 20_261_121
LIMITS = "call_seconds = 3\ncell_seconds = 6\nnotebook_seconds = 90\n"
TOY_SETTINGS = 'withheld = ["xml.dom"]\n'
COLUMNS = ("inflated", "leaks", "harmed", "stopped", "under_graded", "spilled", "odd")


@dataclass(frozen=True)
class Row:
    """One batch of the soak."""

    user: str
    back_end: str
    assignment: str
    report: Report


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the soak; exit status 1 where anything is wrong or a back end works for nobody."""
    parser = argparse.ArgumentParser(prog="python -m tests.autograder.hostile.soak")
    parser.add_argument("--assignment", action="append", metavar="NAME", help="default: all")
    parser.add_argument(
        "--back-end", action="append", choices=list(BACK_ENDS), help="default: all"
    )
    parser.add_argument("--victim", metavar="ID", help="the solution cell to attack")
    parser.add_argument("--as", dest="who", choices=["me", "ordinary", "both"], default="both")
    parser.add_argument("--rows", type=Path, help="write the rows to this file as JSON")
    options = parser.parse_args(arguments)
    rows = _soak(options) if options.who != "ordinary" else []
    if os.getuid() == 0 and options.who != "me":
        rows += _as_ordinary_user(options)
    if options.rows:
        options.rows.write_text(json.dumps([dataclasses.asdict(row) for row in rows]), "utf-8")
    print(table(rows))
    untried = set(options.back_end or BACK_ENDS) - {row.back_end for row in rows}
    for wall in sorted(untried):
        print(f"✗ {wall} was not tried at all: it works for nobody here")
    bad = any(getattr(row.report, column) for row in rows for column in COLUMNS)
    return 1 if bad or untried else 0


def _soak(options: argparse.Namespace) -> list[Row]:
    """Every batch of the present user, with each back end that works for them."""
    rows = []
    for wall in options.back_end or BACK_ENDS:
        problem = BACK_ENDS[wall].problem()
        if problem is not None:
            print(f"{_user()}, {wall}: left out, {problem}", flush=True)
            continue
        for name in options.assignment or [toy.NAME, *course_assignments()]:
            print(f"{_user()}, {wall}, {name} …", flush=True)
            rows.append(Row(_user(), wall, name, soak_one(name, wall, options.victim)))
            _say(rows[-1])
    return rows


def _user() -> str:
    return "root" if os.getuid() == 0 else "ordinary user"


def course_assignments() -> list[str]:
    """The course's own assignments."""
    return sorted(path.parent.name for path in (ROOT / "solutions").glob("*/*.ipynb"))


def soak_one(name: str, wall: str, victim: str | None = None, limits: str = LIMITS) -> Report:
    """Grade all submissions of one assignment, the toy or the course's, in one batch."""
    with tempfile.TemporaryDirectory(prefix="soak-", ignore_cleanup_errors=True) as folder:
        root = Path(folder)
        is_toy = name == toy.NAME
        tree = toy.make_tree(root / "tree", TOY_SETTINGS) if is_toy else ROOT / "solutions"
        (root / "course").mkdir()
        course = batch.make(root / "course", tree, name, limits, victim)
        entries = catalogue.entries()
        batch.write(course, entries)
        return batch.run(course, entries, wall=wall, seed=SEED)


def _say(row: Row) -> None:
    for column in COLUMNS:
        for sentence in getattr(row.report, column):
            print(f"  ✗ {column}: {sentence}", flush=True)


def table(rows: Sequence[Row]) -> str:
    """Counts per batch, one line each."""
    heads = ("user", "back end", "assignment", "submissions", *COLUMNS)
    lines = [heads]
    for row in rows:
        counts = [len(getattr(row.report, column)) for column in COLUMNS]
        numbers = map(str, [row.report.submissions, *counts])
        lines.append((row.user, row.back_end, row.assignment, *numbers))
    widths = [max(len(line[column]) for line in lines) for column in range(len(heads))]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    )


def _as_ordinary_user(options: argparse.Namespace) -> list[Row]:
    """Run the same once more as a user who owns nothing but a folder.

    Raises:
        SystemExit: it did not come to its end.
    """
    with tempfile.TemporaryDirectory(prefix="soak-user-") as folder:
        Path(folder).chmod(0o755)
        own = Path(folder, "own")
        own.mkdir()
        os.chown(own, as_user.ORDINARY, as_user.ORDINARY)
        written = own / "rows.json"
        command = [sys.executable, "-m", "tests.autograder.hostile.soak", "--as", "me"]
        command += ["--rows", str(written), *_chosen(options)]
        values = {"HOME": str(own), "TMPDIR": str(own), "PATH": "/usr/bin:/bin"}
        values |= {"OPENBLAS_NUM_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
        wrapped = as_user.command(command, as_user.ORDINARY)
        status = subprocess.run(wrapped, cwd=ROOT, env=values).returncode
        if not written.is_file():
            raise SystemExit(f"The soak as an ordinary user ended with exit status {status}.")
        rows = json.loads(written.read_text("utf-8"))
    return [Row(**{**row, "report": Report(**row["report"])}) for row in rows]


def _chosen(options: argparse.Namespace) -> list[str]:
    """The options that choose what is graded, once more."""
    words = [word for name in options.assignment or [] for word in ("--assignment", name)]
    words += [word for name in options.back_end or [] for word in ("--back-end", name)]
    return words + (["--victim", options.victim] if options.victim else [])


if __name__ == "__main__":
    sys.exit(main())
