"""A student's own data: as hard for everybody, and the same at every grading."""

from typing import Any

import numpy as np
import pytest
from robust_slam_autograder import self_check
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading.journal import open_journal
from robust_slam_autograder.reading.assignment import Case
from robust_slam_autograder.reading.labelled import Answer

from autograder.tests import kernel
from autograder.tests.fuzz.running import Hang, no_hang
from solutions.classes import answers
from tests.assignments import reference

pytestmark = pytest.mark.rest

SECRET = "5e" * 32
WITH_TOWN = ("05-gnc", "08-showcase", "09-capstone")
DATA = {"05-gnc": "readings", "08-showcase": "walk", "09-capstone": "walk"}


def pytest_generate_tests(metafunc):
    if "answer" in metafunc.fixturenames:
        found = [
            pytest.param(name, answer, id=f"{name}-{answer.exercise}-{answer.name}")
            for name in WITH_TOWN
            for answer in answers.answers(name)
            if cases(name, answer.exercise)
        ]
        metafunc.parametrize(("name", "answer"), found)


def cases(name: str, exercise: str) -> list[Case]:
    """The cases of an exercise that use the student's own data."""
    every = reference.load(name).assignment.cases
    return [case for case in every if case.exercise == exercise and case.has_town]


def students(count: int) -> list[int]:
    return [seeds.SHARED_TOWN, *(seeds.town_of(SECRET, f"student {n}") for n in range(count - 1))]


def passed(name: str, answer: Answer, town: int) -> list[str]:
    """The cases with own data that an answer passes."""
    solutions = reference.load(name)
    names: dict[str, Any] = dict(solutions.names)
    with reference.quiet():
        exec(answer.source, names)
    found = []
    for case in cases(name, answer.exercise):
        try:
            with no_hang():  # as the grader does, however busy the machine is
                solutions.run(case, 1, {**names, "TOWN": town})
            found.append(case.grade_id)
        except (Exception, Hang):  # a test fails by raising, whatever it raises
            continue
    return found


@pytest.mark.long
def test_an_answer_has_the_same_mark_whatever_the_number(name, answer, request):
    numbers = students(100 if kernel.is_soak(request.config) else 4)
    marks = {tuple(passed(name, answer, town)) for town in numbers}
    assert len(marks) == 1
    if answer.is_right:
        assert marks == {tuple(case.grade_id for case in cases(name, answer.exercise))}


@pytest.mark.parametrize("name", WITH_TOWN)
def test_the_number_decides_the_data(name):
    draw = reference.load(name).names[DATA[name]]

    def numbers(town: int) -> bytes:
        made = draw(town)
        return bytes(made if isinstance(made, np.ndarray) else made[0].measurement)

    one, other = students(3)[1:]
    assert numbers(one) == numbers(one) != numbers(other)


def test_a_batch_keeps_its_numbers_whatever_its_seed(tmp_path):
    journal = open_journal(tmp_path, None)
    assert journal.town("ada") == seeds.SHARED_TOWN
    journal.give_towns()
    numbers = [journal.town(name) for name in ("ada", "Zoë", "Zoe\u0308")]
    assert numbers[0] != numbers[1] == numbers[2]
    assert [open_journal(tmp_path, seed).town("ada") for seed in (None, 7)] == numbers[:1] * 2


LOSES_MINE = """
_right = gnc


def gnc(z, *rest, **more):
    assert not np.array_equal(z, readings(482913)), "my own readings"
    return _right(z, *rest, **more)
"""


@pytest.mark.parametrize(
    ("first", "loses", "note"),
    [("TOWN = 0", 0, 0), ("TOWN = 482913", 1, 0), ("TOWN = '482913'", 0, 1), ("", 0, 1)],
)
def test_a_check_draws_the_data_from_the_number_that_was_typed(
    released, tmp_path, capsys, first, loses, note
):
    solution = answers.solutions("05-gnc")["gnc"] + LOSES_MINE
    value = answers.with_answers(answers.solved("05-gnc", released), {"gnc": solution})
    for cell in value["cells"]:
        if "".join(cell["source"]).endswith("TOWN = 0"):
            cell["source"] = first
    self_check.run(answers.write(tmp_path / "mine.ipynb", value), released / "05-gnc")
    said = capsys.readouterr().out
    assert ("my own readings" in said, self_check.NO_TOWN in said) == (loses, note)
