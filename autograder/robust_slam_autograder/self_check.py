"""A student's own check: the visible tests of a notebook, with a line for each exercise.

``check`` is the command ``autograder check`` for the cell of a notebook.
"""

import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from robust_slam_autograder.errors import AutograderError, Refused, WrongUse
from robust_slam_autograder.grading.passes import Pass, Report
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.markup import log_line
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.misconceptions.tables import Table
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import TOWN, Assignment
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reports import clicks, terminal
from robust_slam_autograder.sandbox import choose

ALONE = (
    "{0} stands alone: its exercises and their checks are in the autograder.toml of its zip, and "
    "{1} has none for it. Unpack the zip in a new folder, and name that: "
    "autograder check {0} --release FOLDER."
)
SEVERAL = (
    "{0} does not say which assignment it is of, and {1} holds the releases of {2}: name the one, "
    "as in autograder check {0} --release {1}/{3}."
)
ALTERED = "Note: gone from the notebook or changed, but run as they were released: {}."
NO_TOWN = (
    f"Note: {TOWN} is no whole number in your notebook, so the checks use the data of everybody. "
    f"Type it as you were given it, as in {TOWN} = 482913."
)
_TOWN = re.compile(rf"^{TOWN}\s*=(?!=)([^\n;#(]*)(\(?)", re.MULTILINE)
HINTS = "For a hint on what did not pass, add --hints {}."


def check(notebook: str) -> None:
    """Run the visible tests of a saved notebook, and print what ``autograder check`` prints.

    Below it are hints for what did not pass, each behind a click. The notebook is named by its
    path, for example "05-gnc.ipynb" in the working folder.
    """
    try:
        result, tests = run(Path(notebook))
    except AutograderError as error:
        print(f"autograder: {log_line(str(error))}", file=sys.stderr)
        return
    page = clicks.html(result, tests.config.hints)
    if page and "IPython" in sys.modules:
        from IPython.core.getipython import get_ipython
        from IPython.display import HTML, display

        if get_ipython() is not None:
            display(HTML(page))


def run(
    given: Path, release: Path | None = None, hints: int | None = None
) -> tuple[Result, Assignment]:
    """Run the visible tests of a notebook, and print a line for each exercise as it ends.

    Args:
        given: the notebook.
        release: a release's folder, or one with releases, in place of what is beside the notebook.
        hints: how many to print for each exercise that does not pass; None says nothing of them.

    Returns:
        what they found, and the assignment as the release describes it.

    Raises:
        WrongUse: there is no such notebook or release, it cannot be read, or the notebook stands
            alone.
        GraderFailure: the set-up cells do not work.
    """
    path = Path(os.path.abspath(given))
    if not os.path.lexists(path):
        raise WrongUse(f"{given} does not exist: name the notebook to check.")
    if path.is_dir():
        raise WrongUse(f"{given} is a folder: name the notebook in it.")
    try:
        cells = notebook.read(path)
        folder, tests = _released(path, release)
        code = submission.collect(cells, tests)
        if code.foreign:
            raise Refused(code.foreign)
    except Refused as error:
        raise WrongUse(str(error)) from error
    print(f"Checking {given}: the visible cases of {tests.name}.")
    town, sandbox = _typed_town(cells, tests), choose(unsandboxed=True)
    tell = _teller(tests, tables.read(folder / tables.FILE), hints or 0)
    result = Pass("", tests, code, sandbox, town).look(tell).result
    if code.altered:
        print(ALTERED.format(", ".join(code.altered)))
    failed = [one.name for one in result.exercises if one.status != "passed"]
    more = max((len(tests.config.hints.get(one, ())) for one in failed), default=0)
    if hints is not None and hints < more:
        print(HINTS.format(hints + 1))
    print(terminal.check_end(result, tests.hidden_cases))
    return result, tests


def _teller(tests: Assignment, labels: Mapping[str, Table], hints: int) -> Report:
    """Return what prints a line for each exercise as it ends; a terminal shows what runs, too."""
    left, out = list(tests.exercises), sys.stdout  # what tests print goes nowhere

    def say_next() -> None:
        if left and out.isatty():
            print(f"… {left[0]}", end="\r", file=out, flush=True)

    def tell(exercise: ExerciseResult) -> None:
        name, config = exercise.name, tests.config
        exercise = tables.named(exercise, labels.get(name, {}))
        told = config.place(name), config.hints.get(name, ())[:hints]
        print(terminal.check_line(exercise, tests.hidden_cases, *told), file=out, flush=True)
        left.remove(name)
        say_next()

    say_next()
    return tell


def _typed_town(cells: Sequence[Cell], tests: Assignment) -> int | None:
    """Read the number that the student typed; without one say so, and take everybody's."""
    if not any(case.has_town for case in tests.cases):
        return None
    code = (cell.source for cell in cells if cell.kind == "code")
    # The set-up calls what makes it of itself, or of what the grader hands over.
    typed = [said for text in code for said, call in _TOWN.findall(text) if not call]
    if typed and re.fullmatch(r"\d+", typed[-1].strip(), re.ASCII):
        return int(typed[-1])
    print(NO_TOWN)
    return None


def _released(path: Path, release: Path | None) -> tuple[Path, Assignment]:
    """Find the folder that came with a notebook, and what it says of the assignment.

    It is the given one, else the notebook's own; or one in there that is named as the notebook
    begins, for in the browser notebooks are side by side, and copies have longer names.
    """
    if release is not None and not release.is_dir():
        raise WrongUse(f"There is no folder {release}: --release DIR names the release's.")
    top = release or path.parent
    beside = [one for one in sorted(top.glob("*/")) if path.stem.startswith(one.name)]
    for folder in (top, top / path.parent.name, *reversed(beside)):
        if (tests := assignments.released(folder)) is not None:
            return folder, tests
    there = [one.name for one in sorted(top.glob("*/")) if assignments.released(one) is not None]
    which = SEVERAL.format(path.name, top, ", ".join(there), *there[:1]) if there else ""
    raise WrongUse(which or ALONE.format(path.name, top))
