"""How results are compared: what is no answer must not pass, and correct work must.

A result is a call of a student's function, or a name that is bound to nothing else.
"""

import ast

import numpy as np

from robust_slam_autograder.lint.rule import code_rule
from robust_slam_autograder.lint.subject import Code, Subject, last_name

_CLOSE = frozenset({"numpy.allclose", "numpy.isclose"}) | {
    f"numpy.testing.assert_{name}"
    for name in ("allclose", "array_equal", "array_almost_equal", "almost_equal", "array_less")
}
_REDUCES = frozenset({"abs", "all", "any", "max", "amax", "sum", "mean", "norm"})
_ARRAYS = frozenset({"asarray", "asanyarray", "array"})
_NARROW_TYPES = frozenset(
    {"int", "float", "list", "numpy.ndarray", "numpy.float64", "numpy.generic", "numpy.int64"}
)


def _is_whole(node: ast.AST, code: Code, subject: Subject) -> bool:
    """Whether an expression is a result with all its numbers, perhaps made an array."""
    inner = _bare(node)
    made = code.made.get(inner.id, []) if isinstance(inner, ast.Name) else [inner]
    return bool(made) and all(_calls_student(_bare(one), subject) for one in made)


def _bare(node: ast.AST) -> ast.AST:
    """What np.asarray was called with, where it was called."""
    match node:
        case ast.Call(func=function, args=[inner, *_]) if last_name(function) in _ARRAYS:
            return inner
    return node


def _calls_student(node: ast.AST, subject: Subject) -> bool:
    function = node.func if isinstance(node, ast.Call) else None
    return isinstance(function, ast.Name) and function.id in subject.assignment.names


@code_rule("by-close", "error", "Results are compared by close: shape, NaN and tolerance at once.")
def _by_close(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case ast.Call(func=function) if code.case and subject.full_name(function) in _CLOSE:
            is_loose = not _is_strict(node)
        case ast.Assert(test=test):
            is_loose = any(_reduces(part, code, subject) for part in ast.walk(test))
        case _:
            return ""
    said = (
        "One number for a whole array may pass here, or an empty list: compare by "
        "close(got, want), which shows both, or by np.array_equal where nothing is rounded."
    )
    return said if is_loose else ""


def _reduces(node: ast.AST, code: Code, subject: Subject) -> bool:
    """Whether a call makes one number of a result's differences from something."""
    if not isinstance(node, ast.Call) or last_name(node.func) not in _REDUCES:
        return False
    for part in ast.walk(node):
        match part:
            case (
                ast.BinOp(op=ast.Sub(), left=left, right=right)
                | ast.Compare(left=left, ops=[ast.Eq()], comparators=[right])
            ):
                # A student sees the value of a part in no difference either.
                sides = (
                    [left, right] if code.is_hidden(node) else [*ast.walk(left), *ast.walk(right)]
                )
                if any(_is_whole(one, code, subject) for one in sides):
                    return True
    return False


def _is_strict(node: ast.Call) -> bool:
    return any(word.arg == "strict" and _value(word.value) is True for word in node.keywords)


def _value(node: ast.AST) -> object:
    return getattr(node, "value", None)


@code_rule("nan-passes", "error", "A comparison must not be one that NaN passes.")
def _nan_passes(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case (
            ast.Assert(test=ast.UnaryOp(op=ast.Not(), operand=denied))
            | ast.Return(value=ast.UnaryOp(op=ast.Not(), operand=denied))
        ):
            pass
        case ast.If(test=denied, body=body) if any(map(_fails, body)):
            pass
        case _:
            return ""
    for part in ast.walk(denied):
        match part:
            case ast.UnaryOp(op=ast.Not()):
                return ""  # what is denied twice must hold
            case ast.Compare(ops=[ast.Lt() | ast.LtE() | ast.Gt() | ast.GtE()]):
                return (
                    f"NaN passes, because {ast.unparse(part)} is false for it: ask for what "
                    "shall hold (assert np.all(error <= tol)), or compare by close."
                )
    return ""


def _fails(node: ast.stmt) -> bool:
    is_false = isinstance(node, ast.Assert) and _value(node.test) is False
    return is_false or isinstance(node, ast.Raise)


@code_rule("zip-stops", "error", "zip must not cut off what is missing.")
def _zip_stops(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case ast.Call(func=ast.Name(id="zip")) if code.case and not _is_strict(node):
            return "zip stops at the shorter one, so an empty answer passes: zip(…, strict=True)."
    return ""


@code_rule("type-checked", "warning", "A test must not ask for one type of number.")
def _type_checked(node: ast.AST, code: Code, subject: Subject) -> str:
    parts = ast.walk(node.test) if isinstance(node, ast.Assert) else ()
    if not any(_asks_type(part, code, subject) for part in parts):
        return ""
    return "Integers, lists and arrays are right answers alike: ask for np.shape and the value."


def _asks_type(node: ast.AST, code: Code, subject: Subject) -> bool:
    match node:
        case ast.Call(func=ast.Name(id="isinstance"), args=[_, kind]):
            return subject.full_name(kind) in _NARROW_TYPES
        case ast.Call(func=ast.Name(id="type")):
            return True
        case ast.Attribute(attr="dtype", value=value):
            return _is_whole(value, code, subject)
    return False


@code_rule("exact-float", "warning", "A fraction must not be compared with ==.")
def _exact_float(node: ast.AST, code: Code, subject: Subject) -> str:
    for part in ast.walk(node.test) if isinstance(node, ast.Assert) else ():
        match part:
            case ast.Compare(left=left, ops=[ast.Eq()], comparators=[right]):
                if _is_fraction(left) or _is_fraction(right):
                    return (
                        "Another right way to compute this may round in another way: "
                        "close(got, want) in place of ==."
                    )
    return ""


def _is_fraction(node: ast.expr) -> bool:
    """Whether an expression is a fraction, or holds one beside numbers alone."""
    try:
        numbers = np.ravel(ast.literal_eval(node)).tolist()
    except (ValueError, TypeError):
        return False
    return any(isinstance(number, float) and not number.is_integer() for number in numbers)
