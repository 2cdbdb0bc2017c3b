"""Every right answer gets full marks, every wrong one loses at its own exercise."""

from dataclasses import replace
from functools import cache
from itertools import zip_longest

import pytest
from robust_slam_autograder.grading import messages
from robust_slam_autograder.grading.results import ExerciseResult
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.labelled import Answer
from robust_slam_autograder.reading.source import imported_modules
from robust_slam_autograder.sandbox import Sandbox, choose

from autograder.tests import kernel, toy
from solutions.classes import answers
from tests.assignments.mutation.bare_fork import BareFork

pytestmark = pytest.mark.long

SEEDS = (1, 20_260_101, 987_654_321, *range(101, 118))
"""All of them in ``make soak``, else the first: more would take longer than all other tests."""


def pytest_generate_tests(metafunc):
    if "seed" in metafunc.fixturenames:
        soak = kernel.is_soak(metafunc.config)
        metafunc.parametrize("seed", SEEDS if soak else SEEDS[:1])


@cache
def load(name: str) -> Assignment:
    """An assignment; what any answer imports is there before it runs."""
    found = answers.load(name)
    modules = {each for one in answers.answers(name) for each in imported_modules(one.source)}
    return replace(found, libraries=tuple(sorted({*modules, *found.libraries})))


def rounds(name: str, *, right: bool) -> list[tuple[Answer, ...]]:
    """Submissions that each hold one answer to every exercise, as long as there are any."""
    by_exercise: dict[str, list[Answer]] = {}
    for answer in answers.answers(name):
        if answer.is_right == right:
            by_exercise.setdefault(answer.exercise, []).append(answer)
    columns = zip_longest(*by_exercise.values())
    return [tuple(answer for answer in column if answer is not None) for column in columns]


def cases(*, right: bool) -> list[object]:
    return [
        pytest.param(name, column, id=f"{name}-{number}")
        for name in answers.assignments()
        for number, column in enumerate(rounds(name, right=right))
    ]


def grade(
    name: str, column: tuple[Answer, ...], seed: int, sandbox: Sandbox
) -> dict[str, ExerciseResult]:
    """Grade the exercises that are answered; the others hold the instructor's solutions."""
    sources = {answer.exercise: answer.source for answer in column}
    made = answers.with_answers(answers.source_notebook(name), sources)
    code = toy.submission(made, load(name))
    tests = tuple(case for case in load(name).cases if case.exercise in sources)
    asked = replace(load(name), cases=tests)
    result = toy.both_passes(asked, code, seed, sandbox)
    return {exercise.name: exercise for exercise in result.exercises}


@pytest.mark.sandbox
@pytest.mark.parametrize(("name", "column"), cases(right=True))
def test_right_answers_get_full_marks(name, column, seed, wall_name):
    """The first of an assignment waits for what any of its answers import, such as scipy.stats."""
    marks = grade(name, column, seed, choose(wall_name))
    for answer in column:
        exercise = marks[answer.exercise]
        lost = [(case.name, case.message) for case in exercise.cases if case.earned < case.points]
        assert not lost, f"{answer.name} for {answer.exercise}"


@pytest.mark.sandbox
@pytest.mark.parametrize(("name", "column"), cases(right=False))
def test_wrong_answers_lose_where_they_say(name, column, seed, wall_name):
    # That a wall changes no mark is asked once for an assignment; without one it is quicker.
    walled = column == rounds(name, right=False)[0]
    marks = grade(name, column, seed, choose(wall_name) if walled else BareFork())
    hints = {c.grade_id: c.hint or messages.NO_HINT for c in load(name).cases if c.has_hidden}
    for answer in column:
        lost = {
            f"{answer.exercise}-{case.name}": case
            for case in marks[answer.exercise].cases
            if case.earned < case.points
        }
        assert answer.caught_by in lost, f"{answer.name} for {answer.exercise}: lost {list(lost)}"
        # One that was lost in its hidden region has the hint alone for a message.
        stopped = [each for each, case in lost.items() if case.message != hints.get(each)]
        if answer.is_visible:
            assert answer.caught_by in stopped, f"{answer.name} passes the visible checks"
        else:
            told = f"{answer.name} for {answer.exercise} is stopped by a visible check: write"
            assert not stopped, f"{told} stopped_by = {stopped[0]!r} in place of caught_by"


@pytest.mark.sandbox
@pytest.mark.parametrize("name", answers.assignments())
def test_a_release_scores_nothing_and_the_solutions_all(name, released, wall_name):
    most = sum(case.points for case in load(name).cases)
    untouched, solved = answers.source_notebook(name, released), answers.solved(name, released)
    for made, score in ((untouched, 0), (solved, most)):
        code = toy.submission(made, load(name))
        assert toy.both_passes(load(name), code, SEEDS[0], choose(wall_name)).score == score
