"""A student's own check: the visible tests of a notebook, with a line for each exercise.

``check`` is the command ``autograder check`` for the cell of a notebook.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_slam_autograder import sandbox
from robust_slam_autograder.errors import AutograderError, Refused, WrongUse
from robust_slam_autograder.grading import marking
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.markup import log_line
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reports import clicks, terminal


def check(notebook: str) -> None:
    """Run the visible tests of a saved notebook, and print what ``autograder check`` prints.

    Below it are hints for what did not pass, each behind a click.

    Args:
        notebook: its path, for example "05-gnc.ipynb" in the working folder.
    """
    try:
        result, _ = run(Path(notebook))
        config = assignments.load_config(_beside(Path(notebook)) / assignments.CONFIG_NAME)
        _show(clicks.html(result, config.hints))
    except AutograderError as error:
        print(f"autograder: {log_line(str(error))}", file=sys.stderr)


def _show(page: str) -> None:
    """Show a piece of a page below the cell, where there is one."""
    if page and "IPython" in sys.modules:
        from IPython.core.getipython import get_ipython
        from IPython.display import HTML, display

        if get_ipython() is not None:
            display(HTML(page))  # type: ignore[no-untyped-call]


def run(
    given: Path, release: Path | None = None, hints: int = 0
) -> tuple[Result, Mapping[str, int] | None]:
    """Run the visible tests of a notebook, and print a line for each exercise as it ends.

    Args:
        given: the notebook.
        release: a folder with releases to take the tests from, in place of the notebook's own.
        hints: how many to print for each exercise that does not pass.

    Returns:
        what they found, and per exercise how many hidden cases there are, where that is known.

    Raises:
        WrongUse: there is no such notebook or release, or it cannot be read.
        GraderFailure: the set-up cells do not work.
    """
    path = Path(os.path.abspath(given))
    if not os.path.lexists(path):
        raise WrongUse(f"{given} does not exist: name the notebook to check.")
    if path.is_dir():
        raise WrongUse(f"{given} is a folder: name the notebook in it.")
    try:
        cells = notebook.read(path)
    except Refused as error:
        raise WrongUse(str(error)) from error
    if release is None:
        tests, whose = _own_tests(cells, path), "in it"
        known = tables.read(_beside(path) / tables.FILE)
    else:
        original = _released(release, path)
        tests, whose = assignments.load(original), f"of {original}"
        known = tables.read(original.parent / tables.FILE)
    print(f"Checking {given}: the visible cases {whose}.")
    code = submission.collect(cells, tests)
    lines = _Lines(tests, hints)
    mine = marking.Whose("", tests, code, town=None)
    wall = sandbox.choose(unsandboxed=True)

    def label(exercise: str, shape: Shape) -> str:
        return tables.sentence(known.get(exercise, {}), shape.keys())

    result = marking.look(mine, sandbox=wall, report=lines.write, label=label).result
    print(terminal.check_end(result, tests.hidden_cases))
    return result, tests.hidden_cases


class _Lines:
    """A line for each exercise as it ends; on a terminal also the name of the one that runs."""

    def __init__(self, tests: Assignment, hints: int) -> None:
        self._hidden = tests.hidden_cases
        self._config, self._hints = tests.config, hints
        self._left = list(tests.exercises)
        self._out = sys.stdout  # while tests run, what they print goes nowhere
        self._say_next()

    def write(self, exercise: ExerciseResult) -> None:
        self._left.remove(exercise.name)
        place = self._config.place(exercise.name)
        hints = self._config.hints.get(exercise.name, ())[: self._hints]
        line = terminal.check_line(exercise, self._hidden, place, hints)
        print(line, file=self._out, flush=True)
        self._say_next()

    def _say_next(self) -> None:
        if self._left and self._out.isatty():
            print(f"… {self._left[0]}", end="\r", file=self._out, flush=True)


def _own_tests(cells: Sequence[Cell], path: Path) -> Assignment:
    config = assignments.load_config(_beside(path) / assignments.CONFIG_NAME)
    return assignments.from_cells(
        _first_of_each(cells), name=path.parent.name, notebook=path.stem, config=config
    )


def _beside(path: Path) -> Path:
    """Return the folder of a notebook's settings.

    In the browser notebooks are side by side, and each has a folder of its own for them.
    """
    places = (path.parent, path.parent / path.stem)
    return next((one for one in places if (one / assignments.CONFIG_NAME).is_file()), places[0])


def _first_of_each(cells: Sequence[Cell]) -> list[Cell]:
    """Leave out the copies that a student made of a cell; in a source tree they are an error."""
    first = {cell.grade_id: cell for cell in reversed(cells)}
    return [cell for cell in cells if not cell.grade_id or first[cell.grade_id] is cell]


def _released(folder: Path, path: Path) -> Path:
    if not folder.is_dir():
        raise WrongUse(f"There is no folder {folder}: --release DIR names the release's.")
    for name in (path.stem, path.parent.name):
        if (folder / name).is_dir():
            return assignments.notebook_path(folder / name)
    raise WrongUse(f"{folder} has no release for {path.name}: name the notebook as it was.")
