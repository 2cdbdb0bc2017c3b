"""Which calls of a test's own functions student code may make.

A callable that a test hands over runs on the trusted side. The test's author chose what
it does, but student code sends the arguments. So a call gets positional arguments of
bounded size, and by keyword only what the author's own Python signature names. What numpy
or C offers beside that (``out=`` and ``where=`` of a ufunc, a key function, a file name)
no one chose, and it is refused.
"""

import functools
import inspect
import math
import types
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

MAX_BYTES = 8 * 1024 * 1024
"""Of all arguments of a call, and of what a ufunc makes of them: a million doubles."""
_PLAIN = (bool, int, float, complex, np.number, np.bool_, np.ndarray)
_NUMERIC = "?bBhHiIlLqQefdFD"
_LARGEST = 16
_NAMED = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


def check(function: Callable[..., Any], args: Sequence[Any], kwargs: Mapping[str, Any]) -> None:
    """Refuse a call that the author of a handed-over callable did not provide for.

    Raises:
        TypeError: says what is wrong with the call.
    """
    if _size([*args, *kwargs.values()]) > MAX_BYTES:
        raise TypeError(
            f"the arguments of a function of the test have more than {MAX_BYTES} bytes"
        )
    if isinstance(function, types.FunctionType) and not kwargs:
        return
    if isinstance(function, functools.partial):
        # What the author bound counts as an argument; what was bound by keyword is the author's.
        check(function.func, [*function.args, *args], kwargs)
    elif isinstance(function, np.ufunc):
        _check_ufunc(function, args, kwargs)
    elif not _is_python(function):
        _check_foreign(function, args, kwargs)
    elif kwargs:
        _check_keywords(function, kwargs)


def _size(values: Sequence[Any]) -> int:
    """Return bytes of plain data, about."""
    found = 0
    for value in values:
        if isinstance(value, np.ndarray):
            found += value.nbytes
        elif isinstance(value, str):
            found += len(value)
        elif isinstance(value, list | tuple):
            found += _size(value)
        elif isinstance(value, dict):
            found += _size([*value, *value.values()])
        else:
            found += 8
    return found


def _is_python(function: Callable[..., Any]) -> bool:
    """Tell whether a callable, or its class's ``__call__``, is written in Python."""
    if isinstance(function, types.MethodType):
        function = function.__func__
    return isinstance(function, types.FunctionType) or any(
        isinstance(vars(base).get("__call__"), types.FunctionType)
        for base in type(function).__mro__
    )


def _check_keywords(function: Callable[..., Any], kwargs: Mapping[str, Any]) -> None:
    parameters = inspect.signature(function).parameters.values()
    named = {parameter.name for parameter in parameters if parameter.kind in _NAMED}
    for name in kwargs:
        if name not in named:
            raise TypeError(f"a function of the test has no argument named {name!r}")


def _check_foreign(
    function: Callable[..., Any], args: Sequence[Any], kwargs: Mapping[str, Any]
) -> None:
    if kwargs:
        raise TypeError(f"{_name(function)} takes no keyword arguments here")
    if not all(map(_is_numeric, args)):
        raise TypeError(f"{_name(function)} takes numbers and arrays alone here")


def _check_ufunc(function: np.ufunc, args: Sequence[Any], kwargs: Mapping[str, Any]) -> None:
    if kwargs or len(args) != function.nin:
        what = f"{function.nin} positional arguments and no others"
        raise TypeError(f"{_name(function)} takes {what} here")
    arrays = [np.asarray(value) for value in args if _is_numeric(value)]
    if len(arrays) < len(args) or any(array.dtype.char not in _NUMERIC for array in arrays):
        raise TypeError(f"{_name(function)} takes numbers and arrays alone here")
    if function.signature is not None:  # matmul and its like do not broadcast to one shape
        return
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    if math.prod(shape) * _LARGEST * function.nout > 2 * MAX_BYTES:
        raise TypeError(f"the result of {_name(function)} would be too large")


def _is_numeric(value: object) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_is_numeric, value))
    return isinstance(value, _PLAIN)


def _name(function: Callable[..., Any]) -> str:
    return str(getattr(function, "__name__", type(function).__name__))
