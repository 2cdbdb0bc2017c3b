"""A small assignment and submissions of it, made for the grader's own tests."""

import functools
import json
import tempfile
from pathlib import Path
from typing import Any

from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading.passes import Pass, Report
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.reading import notebook as notebook_module
from robust_slam_autograder.reading.assignment import Assignment, Config, from_cells
from robust_slam_autograder.reading.submission import Code, collect
from robust_slam_autograder.sandbox import Launch, Running, Sandbox

from . import kernel

Value = dict[str, Any]
"""A notebook, a cell or a result, as JSON holds it."""
NAME = "07-toy"
CANARY = "CANARY-TEST-TEXT"
MOST = 20
PACKAGES = ("numpy",)
"""What students import: less than the default, so that every sandbox is ready sooner."""

SETUP = """\
import os

import numpy as np

rng = np.random.default_rng(int(os.environ.get("ROBUST_SLAM_SEED", 0)))
"""

DOUBLE = '''\
def double(x):
    """Twice x, for a number or an array."""
    ### BEGIN SOLUTION
    return 2 * np.asarray(x)
    ### END SOLUTION
'''

APPLY = '''\
def apply(f, x, times):
    """f(f(...f(x))), and the values on the way."""
    ### BEGIN SOLUTION
    history = [x]
    for _ in range(times):
        history.append(f(history[-1]))
    return history[-1], history
    ### END SOLUTION
'''

DOUBLE_VISIBLE = 'assert double(3) == 6, "double(3) is 6: add the number to itself"\n'

DOUBLE_RANDOM = """\
assert np.shape(double([1, 2])) == (2,)
### BEGIN HIDDEN TESTS
# hint: Try negative numbers.
# CANARY-TEST-TEXT
x = rng.normal(size=5)
got = np.asarray(double(x))
assert got.shape == (5,), f"hidden input {x}"
assert np.allclose(got, x + x, rtol=1e-9, atol=0)
### END HIDDEN TESTS
"""

APPLY_HAND = """\
last, history = apply(lambda value: value + 1, 0, 3)
assert last == 3
assert list(history) == [0, 1, 2, 3]
"""

APPLY_HIDDEN = """\
### BEGIN HIDDEN TESTS
# hint: Call f once per time, each time with the value before.
# CANARY-TEST-TEXT
start = float(rng.integers(2, 9))
last, history = apply(lambda value: 3 * value, start, 4)
assert last == 81 * start and len(history) == 5, f"hidden start {start}"
### END HIDDEN TESTS
"""


RIGHT = "def double(x):\n    return 2 * np.asarray(x)\n"
GUESS = "def double(x):\n    return 6\n"
LOOP = "def double(x):\n    while True: pass\n"
EXIT = "import os\ndef double(x):\n    os._exit(0)\n"


class Broken:
    name = "broken"

    def problem(self) -> str:
        return "it is not installed"

    def start(self, launch: Launch) -> Running:
        raise AssertionError("a back end that does not work was started")


def cell(source: str, grade_id: str | None = None, **fields: Any) -> Value:
    """A code cell in nbformat 4.5, with nbgrader's metadata where it has a grade id."""
    metadata: Value = {}
    if grade_id is not None:
        defaults = {"grade": False, "solution": False, "locked": False, "task": False}
        metadata["nbgrader"] = {"grade_id": grade_id, "schema_version": 3, **defaults, **fields}
    return {
        "cell_type": "code",
        "id": grade_id or "own",
        "metadata": metadata,
        "execution_count": None,
        "outputs": [],
        "source": source,
    }


def notebook(cells: list[Value]) -> Value:
    python = {"display_name": "Python 3", "language": "python", "name": "python3"}
    metadata = {"kernelspec": python}
    return {"nbformat": 4, "nbformat_minor": 5, "metadata": metadata, "cells": cells}


def test_cell(source: str, grade_id: str, points: int) -> Value:
    """A locked test cell."""
    return cell(source, grade_id, grade=True, locked=True, points=points)


def source_notebook(**sources: str) -> Value:
    """The instructor's notebook, two exercises of ten points, with these sources by grade id."""
    value = notebook(
        [
            cell(SETUP, "setup", locked=True),
            cell(DOUBLE, "double", solution=True),
            test_cell(DOUBLE_VISIBLE, "double-by-hand", 4),
            test_cell(DOUBLE_RANDOM, "double-random", 6),
            cell(APPLY, "apply", solution=True),
            test_cell(APPLY_HAND, "apply-by-hand", 5),
            test_cell(APPLY_HIDDEN, "apply-twice", 5),
        ]
    )
    for each in value["cells"]:
        each["source"] = sources.pop(each["id"].replace("-", "_"), each["source"])
    assert not sources, f"there are no cells {list(sources)}"
    return value


def write(path: Path, value: Value) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(value), encoding="utf-8")
    return path


def make_tree(folder: Path, config: str = "", value: Value | None = None) -> Path:
    """An nbgrader source tree that holds this one assignment, if need be with another notebook."""
    tree = folder / "solutions"
    write(tree / NAME / f"{NAME}.ipynb", value or source_notebook())
    default = "" if "packages = " in config else f"packages = {json.dumps(PACKAGES)}\n"
    (tree / NAME / "autograder.toml").write_text(default + config, encoding="utf-8")
    return tree


@functools.cache
def described() -> str:
    """The ``autograder.toml`` of a release, which says what a student's own check runs."""
    from robust_slam_autograder.publishing.student_release import release  # takes a second

    with tempfile.TemporaryDirectory() as folder:
        (path,) = release(make_tree(Path(folder)), [], Path(folder, "release"))
        return path.with_name("autograder.toml").read_text(encoding="utf-8")


def answer(double: str = DOUBLE, apply: str = APPLY, *more: Value) -> Value:
    """A submission that holds these sources in its two solution cells, and more cells after."""
    return notebook(
        [
            cell(SETUP, "setup", locked=True),
            cell(double, "double", solution=True),
            test_cell(DOUBLE_VISIBLE, "double-by-hand", 4),
            cell(apply, "apply", solution=True),
            *more,
        ]
    )


def hand_in(folder: Path, student: str, value: Value) -> Path:
    """Write a submission to ``<folder>/<student>/<assignment>/`` and give that folder."""
    return write(folder / student / NAME / f"{NAME}.ipynb", value).parent


def result(out: Path, student: str) -> Value:
    return json.loads((out / student / f"{NAME}.json").read_text("utf-8"))


def hidden_inputs(seed: int) -> list[str]:
    """What the hidden tests draw from a batch's seed, as texts to look for."""
    x = seeds.case_generator(seed, "double-random").normal(size=5)
    return [repr(float(value))[:10] for value in x]


def assignment(
    config: Config | None = None, *, double_random: str | None = None, value: Value | None = None
) -> Assignment:
    """The toy assignment as the grader reads it, if need be changed."""
    value = value or source_notebook()
    if double_random is not None:
        value["cells"][3]["source"] = double_random
    cells = notebook_module.parse(json.dumps(value).encode(), "toy.ipynb")
    return from_cells(cells, Path(f"{NAME}/{NAME}.ipynb"), config or Config(packages=PACKAGES))


def submission(value: Value, tests: Assignment) -> Code:
    return collect(notebook_module.parse(json.dumps(value).encode(), "toy.ipynb"), tests)


def graded(
    value: Value, tests: Assignment | None = None, *, seed: int = 3, wall: Sandbox | None = None
) -> Result:
    """What a submission earns, by default behind the quickest wall."""
    tests = tests or assignment()
    return both_passes(tests, submission(value, tests), seed, wall or kernel.quickest())


def both_passes(tests: Assignment, code: Code, seed: int, wall: Sandbox) -> Result:
    """What the visible pass and then the hidden one come to."""
    seen = Pass("a", tests, code, wall).look()
    last = seen if seen.is_whole else Pass("a", tests, code, wall).finish(seen, seed)
    return last.result


def quickly() -> list[str]:
    """The option of a command that grades behind the quickest wall."""
    wall = kernel.quickest()
    return ["--unsandboxed"] if wall.name == "none" else ["--sandbox", wall.name]


def checked(value: Value, tests: Assignment | None = None, report: Report | None = None) -> Result:
    """What a student's own check says of a submission."""
    tests = tests or assignment()
    code = submission(value, tests)
    return Pass("", tests, code, kernel.quickest()).look(report).result
