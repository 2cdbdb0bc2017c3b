"""``autograder check``: a student runs the visible tests of a notebook."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from robust_slam_autograder import sandbox
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.grading import marking
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reports import summary, terminal


def add(commands: Any) -> None:  # noqa: ANN401
    """Declare the command."""
    parser = commands.add_parser("check", help="run the visible tests of your own notebook")
    parser.add_argument("notebook", type=Path, metavar="NOTEBOOK")
    parser.add_argument(
        "--release", type=Path, metavar="DIR", help="take the tests from the release in DIR"
    )
    parser.add_argument(
        "--markdown", type=Path, metavar="FILE", help="also write what passed, as Markdown"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Check it; exit status 1 where a test does not pass."""
    if options.markdown is not None:
        places.refuse_unwritable("--markdown", options.markdown)
    path = Path(os.path.abspath(options.notebook))
    if not os.path.lexists(path):
        raise WrongUse(f"{options.notebook} does not exist: name the notebook to check.")
    if path.is_dir():
        raise WrongUse(f"{options.notebook} is a folder: name the notebook in it.")
    try:
        cells = notebook.read(path)
    except Refused as error:
        raise WrongUse(str(error)) from error
    if options.release is None:
        tests, whose = _own_tests(cells, path), "in it"
    else:
        original = _released(options.release, path)
        tests, whose = assignments.load(original), f"of {original}"
    print(f"Checking {options.notebook}: the visible cases {whose}.")
    code = submission.collect(cells, tests)
    lines = _Lines(tests)
    result = marking.check(
        tests, code, sandbox=sandbox.choose(unsandboxed=True), report=lines.write
    )
    lines.write_rest(result)
    hidden = tests.hidden_cases
    if options.markdown is not None:
        text = summary.check_as_markdown(result, hidden)
        options.markdown.write_text(text, encoding="utf-8")
    print(terminal.check_end(result, hidden))
    return 0 if result.score == result.max_score else 1


class _Lines:
    """A line for each exercise as it ends; on a terminal also the name of the one that runs."""

    def __init__(self, tests: Assignment) -> None:
        self._hidden = tests.hidden_cases
        self._left = list(tests.exercises)
        self._out = sys.stdout  # while tests run, what they print goes nowhere
        self._say_next()

    def write(self, exercise: ExerciseResult) -> None:
        self._left.remove(exercise.name)
        print(terminal.check_line(exercise, self._hidden), file=self._out, flush=True)
        self._say_next()

    def write_rest(self, result: Result) -> None:
        """Exercises that never ran, for example because the time was up."""
        for exercise in result.exercises:
            if exercise.name in self._left:
                self.write(exercise)

    def _say_next(self) -> None:
        if self._left and self._out.isatty():
            print(f"… {self._left[0]}", end="\r", file=self._out, flush=True)


def _own_tests(cells: Sequence[Cell], path: Path) -> Assignment:
    config = assignments.load_config(path.parent / assignments.CONFIG_NAME)
    return assignments.from_cells(
        _first_of_each(cells), name=path.parent.name, notebook=path.stem, config=config
    )


def _first_of_each(cells: Sequence[Cell]) -> list[Cell]:
    """Leave out the copies that a student made of a cell; in a source tree they are an error."""
    seen: set[str] = set()
    kept = []
    for cell in cells:
        if cell.grade_id is None or cell.grade_id not in seen:
            kept.append(cell)
        seen |= {cell.grade_id} if cell.grade_id else set()
    return kept


def _released(folder: Path, path: Path) -> Path:
    if not folder.is_dir():
        raise WrongUse(f"There is no folder {folder}: --release DIR names the release's.")
    for name in (path.stem, path.parent.name):
        if (folder / name).is_dir():
            return assignments.notebook_path(folder / name)
    raise WrongUse(f"{folder} has no release for {path.name}: name the notebook as it was.")
