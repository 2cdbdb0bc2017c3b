"""Remembers calls by their inputs, as someone does who learns the visible checks by heart."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, field
from typing import Any

import numpy as np

Key = tuple[Any, ...]
PROBES = np.array([-2.3, 0.0, 0.7, 4.1])
"""Functions that are handed in count as the same input where they agree here."""


@dataclass(frozen=True)
class Raised:
    """An exception in the place of a value."""

    error: Exception


@dataclass(frozen=True)
class Call:
    """One call of a student's function: its arguments by name, and what came of it."""

    given: Mapping[str, Any]
    result: Any
    """A value, or ``Raised``."""


@dataclass
class Recorder:
    """A function that remembers all its calls, by input."""

    function: Callable[..., Any]
    calls: dict[Key, Call] = field(default_factory=dict)

    def __call__(self, *args: Any, **kwargs: Any) -> Any:
        """Call the function."""
        given = deepcopy(named(args, kwargs))
        key = key_of((args, kwargs))
        try:
            result = self.function(*args, **kwargs)
        except Exception as error:
            result = Raised(error)
        self.calls[key] = Call(given, deepcopy(result))
        return give(result)

    def recall(self, *args: Any, **kwargs: Any) -> Any:
        """Give what a call with this input gave; call the function where that has effects."""
        answer = self.function if _has_effects((args, kwargs)) else self.replay
        return answer(*args, **kwargs)

    def replay(self, *args: Any, **kwargs: Any) -> Any:
        """Give what a call with this input gave, without its effects."""
        call = self.calls.get(key_of((args, kwargs)))
        return give(deepcopy(call.result)) if call else self.function(*args, **kwargs)


def _has_effects(value: Any) -> bool:
    """Whether a function that is handed this may change more than what it returns."""
    if isinstance(value, Mapping):
        value = tuple(value.values())
    if isinstance(value, tuple | list):
        return any(map(_has_effects, value))
    return callable(value) or isinstance(value, np.random.Generator)


def give(result: Any) -> Any:
    """Return what was remembered, or raise it.

    Raises:
        Exception: the one that was remembered.
    """
    if isinstance(result, Raised):
        raise result.error
    return result


def named(args: Sequence[Any], kwargs: Mapping[str, Any]) -> dict[str, Any]:
    """The arguments of a call by name, and the fields of those that are dicts."""
    given = {**{f"argument {n}": value for n, value in enumerate(args, start=1)}, **kwargs}
    dicts = {name: value for name, value in given.items() if isinstance(value, dict)}
    fields = {f"{name}[{key}]": item for name, one in dicts.items() for key, item in one.items()}
    return {**given, **fields}


def key_of(value: Any) -> Key:
    """A key that equal inputs share, be they lists or arrays, integers or floats."""
    if isinstance(value, Mapping):
        return ("dict", *((name, key_of(value[name])) for name in sorted(value)))
    if isinstance(value, np.random.Generator):
        return ("generator", str(value.bit_generator.state))
    if callable(value):
        return ("function", *_behaviour(value))
    array = numbers(value)
    if array is not None:
        return ("numbers", array.shape, (array.astype(float) + 0.0).tobytes())
    if isinstance(value, Sequence) and not isinstance(value, str):
        return ("row", *(key_of(one) for one in value))
    return (type(value).__name__, str(value))


def _behaviour(function: Callable[..., Any]) -> Iterator[Any]:
    try:
        yield key_of(function(PROBES))
    except Exception:
        code = getattr(function, "__code__", None)
        yield (code.co_code, repr(code.co_consts)) if code else repr(function)


def numbers(value: Any) -> np.ndarray | None:
    """The value as an array of numbers or booleans, or None where it is no such thing."""
    try:
        array = np.asarray(value)
    except ValueError:
        return None
    return array if array.dtype.kind in "biuf" else None
