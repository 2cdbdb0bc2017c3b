"""Whatever a front end does to a cell: an exercise passes its check as its visible cases do."""

import functools
import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder import self_check
from robust_slam_autograder.grading.passes import Pass
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.reading import assignment as assignments

from autograder.tests import toy
from solutions.classes import answers
from tests.assignments.mutation.bare_fork import BareFork

pytestmark = pytest.mark.long
Cell = dict[str, Any]
Cells = list[Cell]


def grade_id(cell: Cell) -> str:
    return str(cell["metadata"].get("nbgrader", {}).get("grade_id", ""))


def place(cells: Cells, name: str) -> int:
    return [grade_id(cell) for cell in cells].index(name)


def checks_of(cells: Cells, name: str) -> Cells:
    return [cell for cell in cells if grade_id(cell).startswith(f"{name}-")]


def text(cell: Cell) -> str:
    return "".join(cell["source"])


def split(cells: Cells, name: str, *, keeps: bool = True) -> None:
    """Cut a cell in two before its last function; some front ends copy the metadata."""
    at = place(cells, name)
    head, mark, tail = text(cells[at]).rpartition("\ndef ")
    if mark:
        other = deepcopy(cells[at]) | ({} if keeps else {"metadata": {}})
        cells[at]["source"], other["source"] = head, f"def {tail}"
        cells.insert(at + 1, other)


def merge(cells: Cells, first: int, second: int, kept: int) -> None:
    """Put two cells into one, with the metadata of one of them."""
    cells[kept]["source"] = f"{text(cells[first])}\n\n{text(cells[second])}"
    del cells[second if kept == first else first]


def merge_with_test(cells: Cells, name: str, *, is_test: bool) -> None:
    at, other = place(cells, name), cells.index(checks_of(cells, name)[0])
    merge(cells, at, other, other if is_test else at)


def merge_above(cells: Cells, name: str) -> None:
    """Merge it into the last check of the exercise before."""
    at = place(cells, name)
    above = [n for n, cell in enumerate(cells[:at]) if "-" in grade_id(cell)]
    if above:
        merge(cells, above[-1], at, above[-1])


def type_into_test(cells: Cells, name: str) -> None:
    """Leave the stub, and write the answer below the first check."""
    answer, test = cells[place(cells, name)], checks_of(cells, name)[0]
    test["source"] = f"{text(test)}\n\n{text(answer)}"
    answer["source"] = f"def {name}(*args, **kwargs):\n    raise NotImplementedError"


def change(cells: Cells, **fields: object) -> None:
    for cell in cells:
        cell.update(fields)


def answer_of(cells: Cells, name: str) -> Cells:
    return [cells[place(cells, name)]]


def lose(cells: Cells, lost: Cells) -> None:
    cells[:] = [cell for cell in cells if cell not in lost]


def edit_checks(cells: Cells, name: str) -> None:
    for cell in checks_of(cells, name):
        cell["source"] = f"x = {name}\n{text(cell)}\nprint(x)"


Change = Callable[[Cells, str], object]
BARE: dict[str, Any] = {"metadata": {}}
CHANGES: dict[str, Change] = {
    "split": split,
    "split, half without id": lambda cells, name: split(cells, name, keeps=False),
    "merged with its check": lambda cells, name: merge_with_test(cells, name, is_test=False),
    "merged into its check": lambda cells, name: merge_with_test(cells, name, is_test=True),
    "merged into the check above": merge_above,
    "merged with what is below": lambda cells, name: merge(
        cells, place(cells, name), place(cells, name) + 1, place(cells, name)
    ),
    "typed into a check": type_into_test,
    "copied": lambda cells, name: cells.insert(
        place(cells, name), *deepcopy(answer_of(cells, name))
    ),
    "copied to the end": lambda cells, name: cells.extend(deepcopy(answer_of(cells, name))),
    "moved to the end": lambda cells, name: cells.append(cells.pop(place(cells, name))),
    "moved to the start": lambda cells, name: cells.insert(0, cells.pop(place(cells, name))),
    "Markdown": lambda cells, name: change(answer_of(cells, name), cell_type="markdown"),
    "raw": lambda cells, name: change(answer_of(cells, name), cell_type="raw"),
    "without id": lambda cells, name: change(answer_of(cells, name), **BARE),
    "raw without id": lambda cells, name: change(answer_of(cells, name), cell_type="raw", **BARE),
    "with Windows' lines": lambda cells, name: change(
        answer_of(cells, name), source=text(cells[place(cells, name)]).replace("\n", "\r\n")
    ),
    "checks deleted": lambda cells, name: lose(cells, checks_of(cells, name)),
    "checks Markdown": lambda cells, name: change(checks_of(cells, name), cell_type="markdown"),
    "checks raw": lambda cells, name: change(checks_of(cells, name), cell_type="raw"),
    "checks without id": lambda cells, name: change(checks_of(cells, name), **BARE),
    "checks edited": edit_checks,
    "all metadata lost": lambda cells, name: change(cells, **BARE),
}
LOSES: dict[str, Change] = {
    "deleted": lambda cells, name: lose(cells, answer_of(cells, name)),
    "deleted with its checks": lambda cells, name: lose(
        cells, answer_of(cells, name) + checks_of(cells, name)
    ),
}
"""Changes after which an exercise has no answer any more."""


@functools.cache
def written(name: str, released: Path, wrong: int) -> str:
    """A notebook with right answers; where it is 1 or 2, every other one is wrong."""
    chosen = {}
    for number, exercise in enumerate(answers.load(name).exercises):
        is_right = wrong == 0 or number % 2 == wrong % 2
        mine = (one for one in answers.answers(name) if one.exercise == exercise)
        found = (one for one in mine if one.is_right == is_right)
        # One that a visible check stops, where there is one.
        chosen[exercise] = max(found, key=lambda one: one.is_visible).source
    return answers.text(answers.with_answers(answers.source_notebook(name, released), chosen))


def passed(result: Result) -> dict[str, bool]:
    return {exercise.name: exercise.status == "passed" for exercise in result.exercises}


@pytest.mark.parametrize("name", answers.assignments())
def test_both_pick_the_same_code_after_each_change_to_each_exercise(name, released):
    graded, described = answers.load(name), assignments.released(released / name)
    assert described is not None
    for field in ("setup", "solutions", "names", "exercises", "given", "blocks"):
        assert getattr(described, field) == getattr(graded, field)
    shown = [(case.grade_id, case.points, case.full.strip()) for case in described.cases]
    assert shown == [(case.grade_id, case.points, case.visible.strip()) for case in graded.cases]
    tried = 0
    for how in (CHANGES | LOSES).values():
        for exercise in graded.exercises:
            value = json.loads(written(name, released, 0))
            how(value["cells"], exercise)
            found = toy.submission(value, described)
            assert found == toy.submission(value, graded)
            assert bool(found.missing) == (how in LOSES.values())
            tried += 1
    assert tried == len(CHANGES | LOSES) * len(graded.exercises)


@pytest.mark.parametrize("wrong", [0, 1, 2])
@pytest.mark.parametrize("name", answers.assignments())
def test_check_passes_what_the_visible_cases_of_the_grade_pass(
    name, wrong, released, tmp_path, monkeypatch
):
    monkeypatch.setattr(self_check, "choose", lambda **options: BareFork())
    (tmp_path / "autograder.toml").write_bytes((released / name / "autograder.toml").read_bytes())
    graded = answers.load(name)

    def grade(value: dict[str, Any]) -> dict[str, bool]:
        code = toy.submission(value, graded)
        return passed(Pass("a", graded, code, BareFork()).look().result)

    value = json.loads(written(name, released, wrong))
    before = grade(value)
    changes = list(CHANGES)
    first = (answers.assignments().index(name) * 3 + wrong) * 7  # so that all have their turn
    for number, exercise in enumerate(reversed(graded.exercises)):
        CHANGES[changes[(first + number) % (len(changes) - 1)]](value["cells"], exercise)
    if wrong == 2:
        change(value["cells"], **BARE)
    result, _ = self_check.run(answers.write(tmp_path / f"{name}.ipynb", value))
    assert passed(result) == grade(value) == before
    assert wrong == 0 or not all(before.values())
