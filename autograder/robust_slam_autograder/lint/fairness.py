"""What costs correct work its marks: references spoiled by student code, right answers refused."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.demands import conditions
from robust_slam_autograder.lint.flow import FACTS, SHAPES, last_name
from robust_slam_autograder.lint.nodes import walk
from robust_slam_autograder.lint.rule import Found, Rule
from robust_slam_autograder.lint.subject import Code, Subject

_NARROW_TYPES = frozenset(
    {"int", "float", "list", "numpy.ndarray", "numpy.float64", "numpy.generic", "numpy.int64"}
)
_OF_ARRAYS = SHAPES | {"T", "dtype", "sum", "mean", "max", "min", "all", "any", "reshape", "flat"}
_OF_ARRAYS |= {"tolist", "ravel", "flatten", "astype", "round", "std", "dot", "copy"}


def _reference_after_call(subject: Subject) -> Iterator[Found]:
    """Targets made from an array that the student's function has had in its hands."""
    for code in subject.codes:
        handed: set[str] = set()
        told: set[str] = set()
        for event in code.flow.events:
            if event.kind == "handed":
                handed.add(event.name)
            elif event.kind == "bound":
                handed.discard(event.name)
            elif event.name in handed - told and not _is_harmless(event.node, code):
                told.add(event.name)
                yield Found(
                    code.grade_id,
                    getattr(event.node, "lineno", 1),
                    f"{event.name} was handed to the student's function before, which may have "
                    "changed it (arguments are copies here, but not in plain nbgrader): compute "
                    f"the target first, or hand over {event.name}.copy().",
                )


def _is_harmless(node: ast.AST, code: Code) -> bool:
    """Whether a use is not of a target itself: the next call's argument, or the shape alone."""
    for around in code.flow.around(node):
        if isinstance(around, ast.stmt):
            return False
        if around in code.flow.calls:
            return True
        if isinstance(around, ast.Call) and last_name(around.func) in FACTS:
            return True
        if isinstance(around, ast.Attribute) and around.attr in SHAPES:
            return True
    return False


def _list_refused(subject: Subject) -> Iterator[Found]:
    """An array's attribute of a result as it came back, which may be a list or a float."""
    for code in subject.codes:
        for node in walk(code.tree):
            if isinstance(node, ast.Attribute) and node.attr in _OF_ARRAYS:
                inner, what = node.value, f".{node.attr}"
            elif isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
                inner, what = node.value, f"[{ast.unparse(node.slice)}]"
            else:
                continue
            if code.flow.of(inner).raw:
                yield Found(
                    code.grade_id,
                    node.lineno,
                    f"A list or a float is a right answer too, and has no {what}: "
                    f"np.asarray({ast.unparse(inner)}) first, or np.shape(…).",
                )


def _type_checked(subject: Subject) -> Iterator[Found]:
    """A test for one type, where numbers and arrays of other types are right answers."""
    for code in subject.codes:
        for condition in conditions(code.tree):
            for node in code.flow.expanded(condition.test):
                if _asks_type(node, code, subject):
                    yield Found(
                        code.grade_id,
                        getattr(node, "lineno", 1),
                        "Integers, lists, NumPy's and Python's own numbers are right answers "
                        "alike: ask for np.shape and the value, not for one type.",
                    )


def _asks_type(node: ast.AST, code: Code, subject: Subject) -> bool:
    match node:
        case ast.Call(func=ast.Name(id="isinstance"), args=[value, kind]):
            narrow = subject.full_name(kind) in _NARROW_TYPES
            return narrow and bool(code.flow.of(value).keys)
        case ast.Call(func=ast.Name(id="type"), args=[value]):
            return bool(code.flow.of(value).keys)
        case ast.Attribute(attr="dtype", value=value):
            return bool(code.flow.of(value).keys)
    return False


def _exact_float(subject: Subject) -> Iterator[Found]:
    """``==`` between a result and a fraction: another right way to compute it may round otherwise.

    Whole numbers are left alone, and so is infinity.
    """
    for code in subject.codes:
        for condition in conditions(code.tree):
            for node in walk(condition.test):
                if not isinstance(node, ast.Compare) or not isinstance(node.ops[0], ast.Eq):
                    continue
                sides = [node.left, node.comparators[0]]
                wants = [side for side in sides if not code.flow.of(side).keys]
                if len(wants) == 1 and any(map(_is_fraction, walk(wants[0]))):
                    yield Found(
                        code.grade_id,
                        node.lineno,
                        "Another right way to compute this may round in another way: "
                        "np.allclose, or abs(got - want) <= tol, in place of ==.",
                    )


def _is_fraction(node: ast.AST) -> bool:
    value = getattr(node, "value", None)
    return isinstance(value, float) and not value.is_integer()


RULES = (
    Rule(
        "reference-after-call",
        "warning",
        "A target must not be made from an array that the student's function has had already.",
        _reference_after_call,
    ),
    Rule(
        "list-refused",
        "warning",
        "A list or a float is as good as an array: take np.asarray before an array's attribute.",
        _list_refused,
    ),
    Rule("type-checked", "warning", "A test must not ask for one type of number.", _type_checked),
    Rule("exact-float", "warning", "A fraction must not be compared with ==.", _exact_float),
)
