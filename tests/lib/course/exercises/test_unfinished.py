"""A function that is unfinished or returns what cannot be drawn gets a sentence, no picture."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from importlib import import_module

import pytest
from robust_slam_course.exercises import NOT_YET


def unfinished(*args: object, **kwargs: object) -> object:
    raise NotImplementedError


def returns(answer: object) -> Callable[..., object]:
    return lambda *args, **kwargs: answer


TRIED = {
    "one_lie": [None, [[]], "x", {}],
    "m_estimators": [None, [[]], "x"],
    "four_costs": [None, [[]], "x"],
    "irls": [None, ([], []), "x"],
    "non_convexity": ["no number"],
    "gnc": [None],
    "switches_and_consistency": [None, [[1.0], [2.0, 3.0]]],
    "certificates": [None, "maybe"],
    "showcase": [None],
    "capstone": [None],
}
"""By module what a student's function returns in place of an answer."""
PICTURES = [
    (module, name, len(inspect.signature(function).parameters))
    for module in TRIED
    for name, function in vars(import_module(f"robust_slam_course.exercises.{module}")).items()
    if hasattr(function, "__wrapped__") and name not in ("public_graph", "_beside_gtsam")
]
DRAWN = {("m_estimators", "classify"), ("capstone", "judge")}
"""Whatever these two are given is written in the picture, a wrong word too."""


@pytest.mark.parametrize(("module", "name", "count"), PICTURES)
def test_what_cannot_be_drawn_gets_a_sentence(module, name, count, capsys) -> None:
    draw = getattr(import_module(f"robust_slam_course.exercises.{module}"), name)
    answers = [] if (module, name) in DRAWN else [returns(answer) for answer in TRIED[module]]
    for student in (unfinished, *answers):
        assert draw(*[student] * count) is None
        assert capsys.readouterr().out == f"{NOT_YET}\n"
