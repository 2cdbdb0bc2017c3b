"""Slips that can be read off the values: the right function, with other arguments or results.

Each is tried on the instructor's own solution: what it returns for the square of an argument, or
twice what it returns. A student's values that are the same say so, whatever the code is.
"""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

Function = Callable[..., Any]
Change = Callable[[Any], Any]
Join = Callable[[Any, Any], Any]


@dataclass(frozen=True)
class Fact:
    """The right function, changed."""

    sentence: str
    """What goes on after "It looks as if"."""
    functions: Mapping[str, Function]
    """By name, those that are changed."""
    argument: str = ""
    """What it is about, where it is not about what comes back."""


def _float(value: Any) -> Any:  # noqa: ANN401
    if isinstance(value, bool | np.bool_ | str) or value is None or callable(value):
        raise TypeError("no number")
    array = np.asarray(value)
    if array.dtype.kind not in "iuf":
        raise TypeError("no numbers")
    return array.astype(float)


def _like(before: Any, after: Any) -> Any:  # noqa: ANN401
    """Return a value as integers again where it was, and still is: they may be indices."""
    whole = np.asarray(before).dtype.kind in "iu" and np.all(np.mod(after, 1) == 0)
    after = np.asarray(after).astype(int) if whole else after
    return after if np.ndim(after) else np.asarray(after).item()


_ARGUMENT: Mapping[str, Change] = {
    "{} were squared before it is used": np.square,
    "the square root of {} were taken, or a square of it is missing": lambda x: np.sqrt(np.abs(x)),
    "the sign of {} were dropped": np.abs,
    "{} had the other sign": np.negative,
    "one over {} stood in its place": lambda x: 1 / x,
    "{} were 1 everywhere, or left out": np.ones_like,
    "{} were 0, or ignored": np.zeros_like,
    "the fractions of {} were cut off": np.trunc,
    "the entries of {} were in another order": lambda x: x[::-1] if x.ndim else x,
    "{} were sorted": lambda x: np.sort(x, axis=0) if x.ndim else x,
    "each row of {} were sorted": lambda x: np.sort(x, axis=-1) if x.ndim >= 2 else x,
    "the columns of {} were in the reverse order": lambda x: x[..., ::-1] if x.ndim >= 2 else x,
    "{} were transposed": lambda x: np.swapaxes(x, -1, -2) if x.ndim >= 2 else x,
}
"""Sentences with an argument in the place of the braces."""

_RESULT: Mapping[str, Change] = {
    "{} is twice what it should be": lambda y: 2 * y,
    "{} is half of what it should be": lambda y: y / 2,
    "{} is four times what it should be": lambda y: 4 * y,
    "{} is a quarter of what it should be": lambda y: y / 4,
    "{} is the square of what it should be": np.square,
    "{} is the square root of what it should be": lambda y: np.sqrt(np.abs(y)),
    "{} has the wrong sign": np.negative,
    "{} is one over what it should be": lambda y: 1 / y,
    "{} is 1 minus what it should be": lambda y: 1 - y,
    "{} has lost its sign": np.abs,
    "{} is kept between 0 and 1": lambda y: np.clip(y, 0, 1),
    "{} is stopped at 0": lambda y: np.maximum(y, 0),
    "{} is never above 1": lambda y: np.minimum(y, 1.0),
    "{} is transposed": lambda y: np.swapaxes(y, -1, -2) if y.ndim >= 2 else y,
    "{} is the inverse of what it should be": lambda y: np.linalg.inv(y),
    "{} is in degrees": np.rad2deg,
    "{} is divided by its sum": lambda y: y / np.sum(y),
    "{} is divided by its largest entry": lambda y: y / np.max(np.abs(y)),
    "{} is scaled to length 1": lambda y: y / np.linalg.norm(y),
    "{} has its fractions cut off": np.trunc,
    "{} is rounded": np.round,
    "{} is one long row, whatever the shape of what came in": np.ravel,
    "{} is a sum where the entries belong": np.sum,
    "{} is a mean where the entries belong": np.mean,
    "{} is in the reverse order": lambda y: y[::-1] if y.ndim else y,
    "{} is sorted": lambda y: np.sort(y, axis=0) if y.ndim else y,
    "{} is 0 everywhere": np.zeros_like,
    "{} is 1 everywhere": np.ones_like,
    "{} is 1 too large": lambda y: y + 1,
    "{} is 1 too small": lambda y: y - 1,
    "{} is NaN everywhere": lambda y: np.full_like(y, np.nan),
    "{} is the logarithm of what it should be": lambda y: np.log(np.abs(y)),
    "{} is the exponential of what it should be": np.exp,
}

_BESIDE: Mapping[str, Join] = {
    "is multiplied by {} once too often": lambda y, x: y * x,
    "is divided by {} once too often": lambda y, x: y / x,
    "is multiplied by the square of {} once too often": lambda y, x: y * x**2.0,
    "is divided by the square of {} once too often": lambda y, x: y / x**2.0,
    "has its fractions cut off where {} holds integers": (
        lambda y, x: np.trunc(y) if x.dtype.kind in "iu" else y
    ),
    "is NaN where {} is 0": lambda y, x: np.where(x == 0, np.nan, y),
    "is 0 where {} is 0": lambda y, x: np.where(x == 0, 0.0, y),
    "is 1 where {} is 0": lambda y, x: np.where(x == 0, 1.0, y),
    "has the wrong sign where {} is negative": lambda y, x: np.where(x < 0, -y, y),
    "is 0 where {} is negative": lambda y, x: np.where(x < 0, 0.0, y),
    "is 1 where {} is negative": lambda y, x: np.where(x < 0, 1.0, y),
    "is positive where {} is negative": lambda y, x: np.where(x < 0, np.abs(y), y),
    "is negative where {} is negative": lambda y, x: np.where(x < 0, -np.abs(y), y),
}
"""What comes back is changed by an argument, in the place of the braces."""
LIMITS = frozenset({"tol", "rtol", "atol", "seed"})
"""Arguments of which a function takes nothing but how far it goes."""


def facts(functions: Mapping[str, Function]) -> Iterator[Fact]:
    """Yield what can be read off the values of an exercise's functions."""
    for name, function in functions.items():
        result = "what comes back" if len(functions) == 1 else f"what `{name}` returns"
        try:
            names = list(inspect.signature(function).parameters)
        except (TypeError, ValueError):
            continue
        yield Fact(f"{result} is the opposite of what it should be", {name: _opposite(function)})
        for sentence, change in _RESULT.items():
            yield Fact(sentence.format(result), {name: _with_result(function, change)})
            for n, part in enumerate(("the first part", "the second part")):
                told = sentence.format(f"{part} of {result}")
                yield Fact(told, {name: _with_part(function, change, n)})
        for n, argument in enumerate(names):
            for sentence, change in ({} if argument in LIMITS else _ARGUMENT).items():
                changed = _with_argument(function, names, n, change)
                yield Fact(sentence.format(f"`{argument}`"), {name: changed}, argument)
            for sentence, join in _BESIDE.items():
                told = f"{result} {sentence.format(f'`{argument}`')}"
                yield Fact(told, {name: _beside(function, names, n, join)})
        for n, m in itertools.combinations(range(len(names)), 2):
            told = f"`{names[n]}` and `{names[m]}` were confused"
            yield Fact(told, {name: _swapped(function, names, n, m)}, f"{names[n]} {names[m]}")


def _bound(names: list[str], args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> list[Any]:
    return [*args, *(kwargs[name] for name in names[len(args) :] if name in kwargs)]


def _with_argument(function: Function, names: list[str], n: int, change: Change) -> Function:
    """Return a function that gets something else for an argument."""

    def changed(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        values = _bound(names, args, kwargs)
        values[n] = _like(values[n], change(_float(values[n])))
        return function(*values)

    return changed


def _swapped(function: Function, names: list[str], n: int, m: int) -> Function:
    def changed(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        values = _bound(names, args, kwargs)
        values[n], values[m] = values[m], values[n]
        return function(*values)

    return changed


def _opposite(function: Function) -> Function:
    def changed(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        found = np.asarray(function(*args, **kwargs))
        if found.dtype.kind != "b":
            raise TypeError("no truth")
        return ~found if found.ndim else not found

    return changed


def _with_result(function: Function, change: Change) -> Function:
    def changed(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        found = function(*args, **kwargs)
        if isinstance(found, tuple):
            return tuple(change(_float(part)) for part in found)
        return change(_float(found))

    return changed


def _with_part(function: Function, change: Change, n: int) -> Function:
    def changed(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        parts = function(*args, **kwargs)
        if not isinstance(parts, tuple):
            raise TypeError("no tuple")
        return (*parts[:n], change(_float(parts[n])), *parts[n + 1 :])

    return changed


def _beside(function: Function, names: list[str], n: int, join: Join) -> Function:
    def changed(*args: Any, **kwargs: Any) -> Any:  # noqa: ANN401
        argument = _bound(names, args, kwargs)[n]
        _float(argument)
        return join(_float(function(*args, **kwargs)), np.asarray(argument))

    return changed
