"""The lazy answers: constants, arguments, and simple functions of one argument."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np

from tests.assignments.lazy.memory import Raised, give

PLAIN = (0.0, 1.0, float("nan"), float("inf"), True, False, None, "", [])
FILLINGS = (0.0, 1.0, -1.0, 0.5, np.nan, np.inf, True, False)
FEW = 6
SIMPLEST: Mapping[str, Callable[[Any], Any]] = {
    "": lambda a: a,
    "size of ": np.abs,
    "minus ": np.negative,
    "sum of ": np.sum,
    "mean of ": np.mean,
    "median of ": np.median,
    "shape of ": np.shape,
}
SIMPLE: Mapping[str, Callable[[Any], Any]] = {
    **SIMPLEST,
    "list of ": list,
    "float of ": float,
    "array of ": np.asarray,
    "square of ": np.square,
    "root of ": np.sqrt,
    "inverse of ": np.reciprocal,
    "sign of ": np.sign,
    "sorted ": np.sort,
    "unique ": np.unique,
    "running sum of ": np.cumsum,
    "least of ": np.min,
    "most of ": np.max,
    "first of ": lambda a: a[0],
    "last of ": lambda a: a[-1],
    "length of ": len,
    "transpose of ": np.transpose,
    "truth of ": lambda a: np.not_equal(a, 0),
}


@dataclass(frozen=True)
class Guess:
    """One lazy answer."""

    name: str
    answer: Callable[[Mapping[str, Any], Any], Any]
    """From the arguments by name, and the right answer, of which it uses the shape alone."""


def guesses(known: Sequence[Any], given: Mapping[str, Any], *, thorough: bool) -> list[Guess]:
    """The lazy answers to try.

    Args:
        known: constants that may be right, the most likely one first.
        given: the arguments of one call, by name.
        thorough: also constants that are less likely, and functions of an argument.
    """
    few = known if thorough else known[:FEW]
    return [*constants(few), *echoes(given, SIMPLE if thorough else SIMPLEST)]


def constants(known: Iterable[Any]) -> Iterator[Guess]:
    """One value for every input: plain ones, values of the right shape, and those known."""
    for value in (*PLAIN, *known):
        yield Guess(f"always {_short(value)}", lambda given, right, value=value: _give(value))
    for value in FILLINGS:
        yield Guess(f"full of {value}", lambda given, right, value=value: _full(right, value))
    yield Guess("identity", lambda given, right: _identity(np.shape(right)))
    yield Guess("0, 1, 2, …", lambda given, right: _counted(np.shape(right)))


def echoes(
    given: Mapping[str, Any], simple: Mapping[str, Callable[[Any], Any]]
) -> Iterator[Guess]:
    """A simple function of an argument, or a function that was handed in of one."""
    handed_in = {f"{name} of ": name for name, value in given.items() if callable(value)}
    for name in (name for name, value in given.items() if not callable(value)):
        for what, function in simple.items():
            yield Guess(
                f"{what}{name}",
                lambda given, right, name=name, function=function: _fitted(
                    function(given[name]), np.shape(right)
                ),
            )
        for what, function_name in handed_in.items():
            yield Guess(
                f"{what}{name}",
                lambda given, right, name=name, function_name=function_name: _fitted(
                    given[function_name](np.asarray(given[name])), np.shape(right)
                ),
            )


def _give(value: Any) -> Any:
    return give(value if isinstance(value, Raised) else deepcopy(value))


def _short(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 40 else f"{text[:39]}…"


def _full(right: Any, value: Any) -> Any:
    return np.full(np.shape(right), value)[()]


def _identity(shape: tuple[int, ...]) -> Any:
    return np.broadcast_to(np.eye(*shape[-2:]), shape).copy()


def _counted(shape: tuple[int, ...]) -> Any:
    return np.arange(np.prod(shape, dtype=int)).reshape(shape)


def _fitted(value: Any, shape: tuple[int, ...]) -> Any:
    """The value, repeated to the right shape where it fits into that."""
    try:
        return value if np.shape(value) == shape else np.broadcast_to(value, shape).copy()[()]
    except ValueError:
        return value
