"""The assignments' pictures: the reference lies on the truth, a wrong answer leaves it."""

import inspect
import json
from collections.abc import Callable
from functools import cache
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam_course import exercises

from solutions.classes import answers
from tests.assignments import reference
from tests.course import drawn

DRAWN = Path(__file__).with_name("drawn.json")
MODULES = {name: name[3:].replace("-", "_") for name in answers.assignments()}
"""By assignment the module that draws its pictures."""
ROUGH = {"solve_sdp": 1e-3, "round_solution": 1e-3, "robust_solve": 1e-4, "pipeline": 1e-4}
"""What an iterative solver computes, and how far it may differ."""


def pictures(module: str) -> dict[str, Callable[..., Figure | None]]:
    """The pictures of one assignment, without those of public data."""
    made = vars(import_module(f"robust_slam_course.exercises.{module}"))
    return {
        name: draw
        for name, draw in made.items()
        if hasattr(draw, "__wrapped__") and name != "public_graph" and not name.startswith("_")
    }


ALL = [(assignment, name) for assignment in MODULES for name in pictures(MODULES[assignment])]


@cache
def arguments(assignment: str, name: str) -> list[Callable[..., Any]]:
    """The reference's functions that a picture takes: its own, and those named beside it."""
    functions = reference.load(assignment).functions
    assert name in functions, f"{MODULES[assignment]}.{name} draws no exercise: delete it"
    if name.startswith("rho_"):
        kernel = name.removeprefix("rho_")
        names = (name, f"psi_{kernel}", f"w_{kernel}")
        return [functions[one] for one in names if one in functions]
    return [functions[name], functions["switched_cost"]] if name == "switch" else [functions[name]]


def picture(assignment: str, name: str, *students: Callable[..., Any]) -> Figure:
    figure = pictures(MODULES[assignment])[name](*students)
    assert isinstance(figure, Figure)
    return figure


@cache
def right(assignment: str, name: str) -> Figure:
    """A picture of the reference, drawn once."""
    return picture(assignment, name, *arguments(assignment, name))


@pytest.mark.parametrize(("assignment", "name"), ALL)
def test_the_reference_is_drawn_as_it_was(assignment, name):
    drawn.check(right(assignment, name), name, DRAWN, ROUGH.get(name, 1e-5))


def test_the_reference_lies_on_the_truth_wherever_that_is_a_curve():
    pairs = 0
    for assignment, name in ALL:
        for ax in right(assignment, name).axes:
            for truth, yours in pairwise(line for line in ax.lines if len(line.get_xdata()) > 1):
                if truth.get_linewidth() == 6 != yours.get_linewidth():
                    x, y = yours.get_xydata().T
                    known = np.interp(x, *truth.get_data())
                    both = np.isfinite(known) & np.isfinite(y)
                    pairs += np.allclose(y[both], known[both], 0.0, 1e-4)
    assert pairs >= 70


WRONG = {
    "the cost without its 2": ("total_cost", lambda right: lambda *a: 0.5 * right(*a)),
    "equations that are anchored": (
        "normal_equations",
        lambda right: lambda *a: (right(*a)[0] + np.diag([1.0, 0.0, 0.0]), right(*a)[1]),
    ),
    "poses that are counted": ("solve_anchored", lambda right: lambda n, *edges: np.arange(n)),
    "strain on one side": ("strained_edges", lambda right: lambda u, tol: np.asarray(u) > tol),
    "influence to the right": ("influence", lambda right: lambda rho, u: rho(u + 1) - rho(u)),
    "one word for all": ("classify", lambda right: lambda psi: "bounded"),
    "lines for curves": ("rho_huber", lambda right: lambda u, c: u * 0.7),
    "a turn that is found": ("convex_until", lambda right: lambda rho, lo, hi: 0.75),
    "no turn": ("convex_until", lambda right: lambda rho, lo, hi: np.inf),
    "a threshold without its root": ("threshold", lambda right: lambda p, d: right(p, d) ** 2),
    "a step elsewhere": ("irls_step", lambda right: lambda *a: (0.28, right(*a)[1])),
    "the root of the variance": ("weighted_variance", lambda right: lambda *a: right(*a) ** 0.5),
    "inliers alone": ("max_mixture_mode", lambda right: lambda r, *a: 0 * r),
    "pairs that never agree": (
        "pairwise_consistent",
        lambda right: lambda *arrays: np.eye(len(arrays[2])),
    ),
    "two members": ("largest_consistent_set", lambda right: lambda A: [0, 1]),
    "one verdict for all": ("verdict", lambda right: lambda Q, R, tol: "certified"),
    "the largest error": ("ate", lambda right: lambda one, two: float(np.abs(one - two).max())),
}
"""By what is wrong: the function, and what stands in its place."""


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_answer_is_drawn_as_it_was_and_leaves_the_truth(case):
    name, wrong = WRONG[case]
    (assignment,) = [assignment for assignment, one in ALL if one == name]
    students = [wrong(right) for right in arguments(assignment, name)]
    figure = picture(assignment, name, *students)
    drawn.check(figure, case, DRAWN)
    known = json.loads(DRAWN.read_text("utf-8"))
    assert known[case] != known[name]


CANNOT = {
    "one_lie": [None, [[]], "x", {}],
    "m_estimators": [None, [[]], "x"],
    "four_costs": [None, [[]], "x"],
    "irls": [None, ([], []), "x"],
    "non_convexity": ["no number"],
    "switches_and_consistency": [None, [[1.0], [2.0, 3.0]]],
    "certificates": [None, "maybe"],
}
"""By module what a student's function returns in place of an answer; of others None."""
WRITTEN = {"classify", "judge"}
"""Whatever these two are given is written in the picture, a wrong word too."""


@pytest.mark.parametrize(("assignment", "name"), ALL)
def test_what_cannot_be_drawn_gets_a_sentence(assignment, name, capsys):
    draw = pictures(MODULES[assignment])[name]
    found = [] if name in WRITTEN else CANNOT.get(MODULES[assignment], [None])
    unfinished = Mock(side_effect=NotImplementedError)
    for student in (unfinished, *(lambda *a, found=one, **k: found for one in found)):
        assert draw(*[student] * (len(inspect.signature(draw).parameters) - 1)) is None
        assert capsys.readouterr().out == f"{exercises.NOT_YET}\n"
