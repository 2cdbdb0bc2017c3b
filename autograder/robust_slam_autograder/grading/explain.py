"""Says more about a visible check that failed: what a function returned, and a likely cause.

Only the visible pass uses it. Its texts hold what student code returned, so no hidden
input may ever reach them.
"""

import ast
import contextlib
import reprlib
import sys
import traceback
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from robust_slam_autograder.grading.likely_causes import NAN, NO_VALUE
from robust_slam_autograder.grading.results import Compared

HERE = "Here, "
"""How these texts begin."""
MAX_CALLS = 200
"""How many calls of one case are kept, the latest."""
MAX_ARGUMENTS = 60
MAX_VALUE = 120
MAX_EXPRESSION = 60
CURVE = range(3, 201)
"""How many numbers are worth a picture, and find room in one."""

_EXPECTED = {
    ast.Eq: "expected",
    ast.NotEq: "expected anything but",
    ast.Lt: "expected less than",
    ast.LtE: "expected at most",
    ast.Gt: "expected more than",
    ast.GtE: "expected at least",
}
_MIRRORED = {ast.Lt: ast.Gt, ast.LtE: ast.GtE, ast.Gt: ast.Lt, ast.GtE: ast.LtE}
_EQUALITIES = ("allclose", "array_equal", "array_equiv", "close", "isclose")


@dataclass(frozen=True)
class Call:
    """A call of a student's function that returned."""

    name: str
    args: tuple[Any, ...]
    kwargs: Mapping[str, Any]
    value: Any
    line: int
    """Line of the test cell that made it; 0 where no line of the cell did."""
    step: int
    """Offset of the bytecode that made it: it grows within one evaluation of a statement."""


@dataclass
class Calls:
    """Calls of the student's functions by one test cell, the latest last.

    Attributes:
        label: file name under which the test cell was compiled.
        names: what the test cell sees.
        made: the calls.
    """

    label: str = ""
    names: dict[str, Any] = field(default_factory=dict)
    made: deque[Call] = field(default_factory=lambda: deque(maxlen=MAX_CALLS))

    def begin(self, label: str, names: dict[str, Any]) -> None:
        """Forget the calls of the cell before."""
        self.label, self.names = label, names
        self.made.clear()

    def watched(self, bindings: Mapping[str, Any]) -> dict[str, Any]:
        """Return the same names, with functions that record their calls here."""
        return {
            name: self._watch(name, value) if callable(value) else value
            for name, value in bindings.items()
        }

    def _watch(self, name: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def student_function(*args: object, **kwargs: object) -> Any:  # noqa: ANN401
            line, step = self._place()
            value = function(*args, **kwargs)
            self.made.append(Call(name, args, kwargs, value, line, step))
            return value

        student_function.__name__ = student_function.__qualname__ = name
        return student_function

    def _place(self) -> tuple[int, int]:
        """Return where the test cell stands at the moment."""
        frame = sys._getframe(2)
        while frame.f_back is not None:
            if frame.f_code.co_filename == self.label and frame.f_code.co_name == "<module>":
                return frame.f_lineno, frame.f_lasti
            frame = frame.f_back
        return 0, 0


@dataclass
class _Replay:
    """Evaluates parts of a statement again; the student's functions return what they did.

    Attributes:
        calls: the calls that the statement made, in order.
        position: which of them is answered next.
    """

    source: Calls
    calls: list[Call]
    position: int = 0

    def evaluate(self, expression: ast.expr) -> Any:  # noqa: ANN401
        """Return the value of an expression of the test cell."""
        code = compile(ast.Expression(expression), self.source.label, "eval")
        return eval(code, self.source.names)

    @contextlib.contextmanager
    def instead(self) -> Iterator[None]:
        """Put the recorded values in place of the student's functions."""
        names = self.source.names
        before = {call.name: names[call.name] for call in self.calls if call.name in names}
        names.update(dict.fromkeys(before, self._answer))
        try:
            yield
        finally:
            names.update(before)

    def _answer(self, *args: object, **kwargs: object) -> Any:  # noqa: ANN401
        self.position += 1
        return self.calls[self.position - 1].value


@dataclass(frozen=True)
class Returned:
    """What is said of a check that failed."""

    text: str = ""
    """A line of its own; empty where nothing is known."""
    compared: Compared | None = None
    """The same as data, where two values were compared."""


_Comparison = tuple[ast.expr, type[ast.cmpop], ast.expr]
"""Left side, relation and right side."""


def returned(error: Exception, source: str, calls: Calls) -> Returned:
    """Say what came back and what was expected, of the error and the calls of a test cell."""
    test = failing_test(error, source, calls.label)
    made = _last_evaluation(calls, test) if test else list(calls.made)
    found = _of_comparison(test, _Replay(calls, made)) if test else None
    if found is None and made and (test or not isinstance(error, AssertionError)):
        last = made[-1]
        told = f"{_told_arguments(last)} returned {show(last.value)}."
        found = Returned(f"{told} {_remark(last.value)}".rstrip())
    return Returned() if found is None else replace(found, text=f"\n{HERE}{found.text}")


def _of_comparison(test: ast.expr, replay: _Replay) -> Returned | None:
    # A test is any code: where a part of it cannot be evaluated again, less is said.
    with contextlib.suppress(Exception), replay.instead():
        found = _comparison(test, replay)
        if found is not None:
            return _compared(found, replay)
    return None


def failing_test(error: Exception, source: str, label: str) -> ast.expr | None:
    """Return the condition of the assert, or the call of a set-up's ``close``, that failed."""
    if not isinstance(error, AssertionError):
        return None
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno or 0 for frame in frames if frame.filename == label]
    checks = [check for node in ast.walk(ast.parse(source)) if (check := _check(node))]
    found = [c for c in checks if lines and c.lineno <= lines[-1] <= (c.end_lineno or c.lineno)]
    return found[-1] if found else None


def _check(statement: ast.AST) -> ast.expr | None:
    if isinstance(statement, ast.Assert):
        return statement.test
    value = statement.value if isinstance(statement, ast.Expr) else None
    is_close = isinstance(value, ast.Call) and ast.unparse(value.func) == "close"
    return value if is_close else None


def _last_evaluation(calls: Calls, test: ast.expr) -> list[Call]:
    """Return the calls that a condition made when it failed: in a loop it was evaluated before."""
    found: list[Call] = []
    for call in reversed(calls.made):
        inside = test.lineno <= call.line <= (test.end_lineno or test.lineno)
        if not inside or (found and call.step >= found[-1].step):
            break
        found.append(call)
    return found[::-1]


def _comparison(test: ast.expr, replay: _Replay) -> _Comparison | None:
    """Return the comparison in a condition that did not hold."""
    if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And):
        for part in test.values:
            start = replay.position
            if not replay.evaluate(part):
                replay.calls, replay.position = replay.calls[start:], 0
                return _comparison(part, replay)
    if isinstance(test, ast.Compare) and len(test.ops) == 1:
        return test.left, type(test.ops[0]), test.comparators[0]
    if isinstance(test, ast.Call):
        name = ast.unparse(test.func).rpartition(".")[2]
        if name in _EQUALITIES and len(test.args) >= 2:
            return test.args[0], ast.Eq, test.args[1]
        if name in ("all", "bool") and len(test.args) == 1:
            return _comparison(test.args[0], replay)
    return None


def _compared(found: _Comparison, replay: _Replay) -> Returned | None:
    left, relation, right = found
    values = replay.evaluate(left), replay.evaluate(right)
    if _is_from_student(right, replay) and not _is_from_student(left, replay):
        left, relation, values = right, _MIRRORED.get(relation, relation), values[::-1]
    if relation not in _EXPECTED:
        return None
    got, want = show(values[0]), show(values[1])
    if got == want:  # they differ where the texts were cut
        got, want = _exact(values[0]), _exact(values[1])
    what, verb = _told_side(left, values[0], replay)
    compared = Compared(what, got, _EXPECTED[relation], want, _remark(values[0]), _curves(*values))
    told = f"{what} {verb} {got}; {compared.relation} {want}. {compared.remark}".rstrip()
    return Returned(told, compared)


def _curves(yours: object, expected: object) -> tuple[tuple[float, ...], ...]:
    """Return both as numbers in a row; one number that is expected everywhere is a row of it."""
    with contextlib.suppress(TypeError, ValueError, OverflowError):
        mine, other = np.asarray(yours), np.asarray(expected)
        are_numbers = all(side.dtype.kind in "iuf" for side in (mine, other))
        if are_numbers and mine.ndim == 1 and mine.size in CURVE and other.ndim <= 1:
            rows = [row.astype(float) for row in np.broadcast_arrays(mine, other)]
            if all(row.size == mine.size and np.all(np.isfinite(row)) for row in rows):
                return tuple(tuple(float(f"{number:.6g}") for number in row) for row in rows)
    return ()


def _is_from_student(side: ast.expr, replay: _Replay) -> bool:
    """Tell whether an expression holds a call of a student's function, or what one returned."""
    names = {node.id for node in ast.walk(side) if isinstance(node, ast.Name)}
    called = {call.name for call in replay.source.made}
    values = [replay.source.names.get(name) for name in names]
    return bool(names & called) or any(_source_of(value, replay) for value in values)


def _source_of(value: object, replay: _Replay) -> Call | None:
    """Return the call that returned this very object, or a tuple that holds it."""
    for call in reversed(replay.source.made):
        parts = call.value if isinstance(call.value, tuple) else ()
        if value is not None and any(value is item for item in (call.value, *parts)):
            return call
    return None


def _told_side(side: ast.expr, value: object, replay: _Replay) -> tuple[str, str]:
    """Return what a value is of, and the verb between the two."""
    called = side.func if isinstance(side, ast.Call) else None
    if isinstance(called, ast.Name) and any(call.name == called.id for call in replay.calls):
        own = [call for call in replay.calls if call.name == called.id]
        return _told_arguments(own[0]), "returned"
    source = _source_of(value, replay) if isinstance(side, ast.Name) else None
    if source is not None and source.value is value:
        return _told_arguments(source), "returned"
    text = ast.unparse(side)
    return (text if len(text) <= MAX_EXPRESSION else f"{text[: MAX_EXPRESSION - 1]}…"), "is"


def _told_arguments(call: Call) -> str:
    """Return a call as one would type it; without its arguments where they are long."""
    texts = [show(item) for item in call.args]
    texts += [f"{key}={show(item)}" for key, item in call.kwargs.items()]
    text = ", ".join(texts)
    return f"{call.name}({text if len(text) <= MAX_ARGUMENTS else '…'})"


def _remark(value: object) -> str:
    if value is None:
        return NO_VALUE
    return NAN if _has_nan(value) else ""


def _has_nan(value: object) -> bool:
    if isinstance(value, list | tuple):
        return any(_has_nan(item) for item in value)
    with contextlib.suppress(TypeError, ValueError):
        return bool(np.any(np.isnan(value)))  # type: ignore[call-overload]
    return False


def show(value: object) -> str:
    """Return a value on one line: floats with at most eight digits, long values cut."""
    with contextlib.suppress(Exception):  # it is shown to help, and may be anything
        text = " ".join(_text(value).split())
        return text if len(text) <= MAX_VALUE else f"{text[: MAX_VALUE - 1]}…"
    return f"a value of type {type(value).__name__}"


def _exact(value: object) -> str:
    """Show a value with all its digits."""
    with np.printoptions(precision=17, floatmode="unique", threshold=20):
        return " ".join(repr(value).split())[:MAX_VALUE]


def _text(value: object) -> str:
    if isinstance(value, bool | np.bool_):
        return str(bool(value))
    if isinstance(value, float | np.floating):
        return repr(float(f"{float(value):.8g}"))
    if isinstance(value, np.ndarray):
        return np.array2string(value, precision=6, threshold=20, separator=", ")
    if isinstance(value, np.generic):
        return str(value)
    if isinstance(value, tuple):
        return f"({', '.join(map(show, value[:6]))}{',' * (len(value) == 1)})"
    if isinstance(value, list):
        more = ", …" if len(value) > 8 else ""
        return f"[{', '.join(map(show, value[:8]))}{more}]"
    return "a function" if callable(value) else reprlib.repr(value)
