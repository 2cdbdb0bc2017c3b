"""How results are compared: what is no answer must not pass, and correct work must."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.nodes import around, last_name, walk
from robust_slam_autograder.lint.results import SHAPES
from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Code, Found, Subject

_CLOSE = frozenset({"numpy.allclose", "numpy.isclose"}) | {
    f"numpy.testing.assert_{name}"
    for name in ("allclose", "array_equal", "array_almost_equal", "almost_equal", "array_less")
}
_REDUCES = frozenset({"all", "any", "max", "amax", "sum", "mean", "norm"})
_ORDER = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
_KEEP = frozenset({"any", "all", "bool", "logical_and", "logical_or"})
_NARROW_TYPES = frozenset(
    {"int", "float", "list", "numpy.ndarray", "numpy.float64", "numpy.generic", "numpy.int64"}
)
_OF_ARRAYS = SHAPES | {"T", "dtype", "sum", "mean", "max", "min", "all", "any", "reshape", "flat"}
_OF_ARRAYS |= {"tolist", "ravel", "flatten", "astype", "round", "std", "dot", "copy"}


@rule("by-close", "error", "Results are compared by close: shape, NaN and tolerance at once.")
def _by_close(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        for node, name in subject.calls(code):
            is_close = name in _CLOSE and not _is_strict(node)
            sides = node.args[:2]
            if (is_close and any(map(code.results.holds, sides))) or _reduced(node, code):
                yield code.found(
                    node,
                    "One number for a whole array may pass here, or an empty list: compare by "
                    "close(got, want), or by np.array_equal where nothing is rounded.",
                )


def _reduced(node: ast.Call, code: Code) -> bool:
    """Whether a call makes one number of a result's differences from something."""
    if last_name(node.func) not in _REDUCES or _is_in_lambda(node, code):
        return False
    for part in (part for one in (*node.args, node.func) for part in walk(one)):
        match part:
            case ast.BinOp(op=ast.Sub(), left=left, right=right):
                pair = left, right
            case ast.Compare(left=left, ops=[ast.Eq()], comparators=[right]):
                pair = left, right
            case _:
                continue
        if any(map(code.results.is_whole, pair)):
            return True
    return False


def _is_in_lambda(node: ast.AST, code: Code) -> bool:
    return any(isinstance(one, ast.Lambda) for one in around(node, code.tree))


def _is_strict(node: ast.Call) -> bool:
    return any(word.arg == "strict" and _value(word.value) is True for word in node.keywords)


def _value(node: ast.AST) -> object:
    return getattr(node, "value", None)


@rule("nan-passes", "error", "A comparison must not be one that NaN passes.")
def _nan_passes(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        denied = (
            node for test, holds in _demands(code.tree) for node in _denied(test, holds, code)
        )
        for node in denied:
            if code.results.holds(node):
                yield code.found(
                    node,
                    f"NaN passes, because {ast.unparse(node)} is false for it: ask for what shall "
                    "hold (assert np.all(error <= tol)), or compare by close.",
                )


def _demands(tree: ast.AST) -> Iterator[tuple[ast.expr, bool]]:
    """What a cell demands, and whether it must be true or false."""
    for node in walk(tree):
        match node:
            case ast.Assert(test=test) | ast.Return(value=ast.UnaryOp() as test):
                yield test, True
            case ast.If(test=test, body=body, orelse=other):
                if any(map(_fails, body)) or any(map(_fails, other)):
                    yield test, any(map(_fails, other))


def _fails(node: ast.stmt) -> bool:
    is_false = isinstance(node, ast.Assert) and _value(node.test) is False
    return is_false or isinstance(node, ast.Raise)


def _denied(node: ast.expr, holds: bool, code: Code) -> Iterator[ast.expr]:
    """The comparisons of order in a condition that must be false."""
    match node:
        case ast.UnaryOp(op=ast.Not() | ast.Invert(), operand=inner):
            yield from _denied(inner, not holds, code)
        case ast.BoolOp(values=parts):
            yield from (found for part in parts for found in _denied(part, holds, code))
        case ast.Call(func=function, args=arguments) if last_name(function) in _KEEP:
            owner = [function.value] if isinstance(function, ast.Attribute) else []
            yield from (one for part in (*arguments, *owner) for one in _denied(part, holds, code))
        case ast.Name(id=name):
            made = code.results.made.get(name, [])
            tests = [one for one in made if isinstance(one, ast.Compare)]
            yield from (one for test in tests for one in _denied(test, holds, code))
        case ast.Compare(ops=[operation]) if isinstance(operation, _ORDER) and not holds:
            yield node


@rule("zip-stops", "error", "zip must not cut off what is missing.")
def _zip_stops(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        for node, name in subject.calls(code):
            if name == "zip" and not _is_strict(node) and any(map(code.results.holds, node.args)):
                yield code.found(
                    node,
                    "zip stops at the shorter one, so that an empty answer passes: "
                    "zip(…, strict=True).",
                )


@rule("list-refused", "warning", "A list or a float is as good an answer as an array.")
def _list_refused(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        for node in walk(code.tree):
            match node:
                case ast.Attribute(attr=name, value=inner) if name in _OF_ARRAYS:
                    what = f".{name}"
                case ast.Subscript(value=inner, slice=ast.Tuple() as place):
                    what = f"[{ast.unparse(place)}]"
                case _:
                    continue
            if code.results.is_raw(inner):
                yield code.found(
                    node,
                    f"A list or a float is a right answer too, and has no {what}: "
                    f"np.asarray({ast.unparse(inner)}) first, or np.shape(…).",
                )


@rule("type-checked", "warning", "A test must not ask for one type of number.")
def _type_checked(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        for test, _ in _demands(code.tree):
            for node in walk(test):
                if _asks_type(node, code, subject):
                    yield code.found(
                        node,
                        "Integers, lists, NumPy's and Python's own numbers are right answers "
                        "alike: ask for np.shape and the value, not for one type.",
                    )


def _asks_type(node: ast.AST, code: Code, subject: Subject) -> bool:
    match node:
        case ast.Call(func=ast.Name(id="isinstance"), args=[value, kind]):
            return subject.full_name(kind) in _NARROW_TYPES and code.results.holds(value)
        case ast.Call(func=ast.Name(id="type"), args=[value]):
            return code.results.holds(value)
        case ast.Attribute(attr="dtype", value=value):
            return code.results.is_whole(value)
    return False


@rule("exact-float", "warning", "A fraction must not be compared with ==.")
def _exact_float(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        for node in (part for test, _ in _demands(code.tree) for part in walk(test)):
            match node:
                case ast.Compare(left=left, ops=[ast.Eq()], comparators=[right]):
                    wants = [side for side in (left, right) if not code.results.holds(side)]
                    if len(wants) == 1 and any(map(_is_fraction, walk(wants[0]))):
                        yield code.found(
                            node,
                            "Another right way to compute this may round in another way: "
                            "close(got, want) in place of ==.",
                        )


def _is_fraction(node: ast.AST) -> bool:
    value = _value(node)
    return isinstance(value, float) and not value.is_integer()
