"""A list is as good as an array; and what is no answer passes no case with hidden checks."""

import contextlib
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from solutions.classes import answers
from tests.assignments import reference

SEED, OTHER_SEED = 1, 2
Function = Callable[..., Any]

pytestmark = [pytest.mark.long, pytest.mark.rest]


def in_parts(change: Callable[[Any], Any], value: Any) -> Any:
    """A value with the same change in each part of a tuple."""
    return tuple(map(change, value)) if isinstance(value, tuple) else change(value)


def as_list(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: as_list(item) for key, item in value.items()}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value


def is_number(value: Any) -> bool:
    return isinstance(value, float | np.floating) or (
        isinstance(value, np.ndarray | list) and np.asarray(value).dtype.kind == "f"
    )


def not_a_number(value: Any) -> Any:
    return np.asarray(value) * np.nan if is_number(value) else value


def one_dimension_more(value: Any) -> Any:
    return np.asarray(value)[None] if is_number(value) else value


def always_the_first(function: Function) -> Function:
    """A function that was right once, and answers the same ever after."""
    kept: list[Any] = []

    def remembers(*args: Any, **kwargs: Any) -> Any:
        kept[:] = kept or [function(*args, **kwargs)]
        return kept[0]

    return remembers


def its_input(function: Function) -> Function:
    return lambda *args, **kwargs: args[0]


def passes(name: str, case: reference.Case, wrap: Callable[[Function], Function]) -> bool:
    """Whether a case passes with other functions, which have been through it with another seed."""
    solutions = reference.load(name)
    replaced = {name: wrap(function) for name, function in solutions.functions.items()}
    with contextlib.suppress(Exception):
        solutions.run(case, OTHER_SEED, replaced)
    try:
        solutions.run(case, SEED, replaced)
    except Exception:  # a test fails by raising, whatever it raises
        return False
    return True


@pytest.mark.parametrize("name", answers.assignments())
def test_a_list_is_as_good_as_an_array(name):
    def listing(function: Function) -> Function:
        return lambda *args, **kwargs: in_parts(as_list, function(*args, **kwargs))

    cases = reference.load(name).assignment.cases
    assert not [case.grade_id for case in cases if not passes(name, case, listing)]


@pytest.mark.parametrize("wrap", [always_the_first, its_input])
@pytest.mark.parametrize("name", answers.assignments())
def test_an_answer_by_heart_passes_no_hidden_check(name, wrap):
    cases = [case for case in reference.load(name).assignment.cases if case.has_hidden]
    assert not [case.grade_id for case in cases if passes(name, case, wrap)]


@pytest.mark.parametrize("change", [not_a_number, one_dimension_more])
@pytest.mark.parametrize("name", answers.assignments())
def test_nan_and_another_shape_pass_no_hidden_check(name, change):
    changed: list[str] = []

    def changing(function: Function) -> Function:
        def changes(*args: Any, **kwargs: Any) -> Any:
            value = function(*args, **kwargs)
            parts = value if isinstance(value, tuple) else (value,)
            if not any(map(is_number, parts)) or any(isinstance(part, dict) for part in parts):
                return value  # a truth or a word; or more than one case looks at
            changed.append(function.__name__)
            return in_parts(change, value)

        return changes

    for case in (one for one in reference.load(name).assignment.cases if one.has_hidden):
        changed.clear()
        assert not passes(name, case, changing) or not changed, case.grade_id
