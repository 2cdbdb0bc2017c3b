"""Comparisons that a wrong shape passes, because one side is broadcast or cut off."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from robust_slam_autograder.lint.demands import conditions
from robust_slam_autograder.lint.flow import SHAPES, Flow, last_name
from robust_slam_autograder.lint.nodes import walk
from robust_slam_autograder.lint.rule import Found, Rule
from robust_slam_autograder.lint.subject import Code, Subject

_CLOSE = frozenset({"allclose", "isclose"})
_ASSERTS = frozenset(
    f"numpy.testing.assert_{name}"
    for name in ("allclose", "array_equal", "array_almost_equal", "almost_equal", "array_less")
)
_REDUCES = frozenset({"all", "any", "max", "amax", "min", "sum", "mean", "median", "norm", "std"})
_VALUES = (ast.Name, ast.Call, ast.Attribute, ast.Subscript, ast.List, ast.Tuple)
_STRICT = frozenset({"array_equal", "assert_equal"})


@dataclass(frozen=True)
class _Pair:
    """Two sides that are compared with broadcasting."""

    node: ast.expr
    left: ast.expr
    right: ast.expr
    is_close: bool
    """In one call, as np.allclose does; else by arithmetic that may mean something else."""


def _shape_unchecked(subject: Subject) -> Iterator[Found]:
    """A result of whatever shape is compared with an array."""
    for code in subject.codes:
        checked = _checked(code, subject)
        for pair in _pairs(code, subject):
            left, right = code.flow.of(pair.left), code.flow.of(pair.right)
            if not (left.many and right.many and _has_target(left.keys, right.keys)):
                continue
            if not _any_is_checked(left.keys | right.keys, checked):
                yield Found(
                    code.grade_id,
                    pair.node.lineno,
                    "One number, or an array of another shape, may pass: it is broadcast. Assert "
                    "np.shape(got) == … in this case, or use assert_allclose(…, strict=True).",
                )


def _number_unchecked(subject: Subject) -> Iterator[Found]:
    """A result is compared with a number, so that an array full of that number passes."""
    for code in subject.codes:
        checked = _checked(code, subject)
        for pair in _pairs(code, subject):
            left, right = code.flow.of(pair.left), code.flow.of(pair.right)
            if not pair.is_close or left.many == right.many:
                continue
            got = left if left.many else right
            if not _any_is_checked(got.keys, checked):
                yield Found(
                    code.grade_id,
                    pair.node.lineno,
                    "An array full of this number passes, and so does an empty list: "
                    "assert np.shape(got) == () in this case.",
                )


def _has_target(left: frozenset[str], right: frozenset[str]) -> bool:
    """Whether one side is no result; of a helper's arguments one is."""
    return not left or not right or any("(" in key for key in left)


def _any_is_checked(keys: frozenset[str], checked: frozenset[str]) -> bool:
    """Whether the shape of one of these, or of what it is an item of, is asserted."""
    wholes = tuple(f"{one}[" for one in checked)
    return not keys or any(key in checked or key.startswith(wholes) for key in keys)


def _pairs(code: Code, subject: Subject) -> Iterator[_Pair]:
    seen = set()
    for root in _roots(code):
        for node in code.flow.expanded(root):
            if isinstance(node, ast.Call) and node not in seen:
                seen.add(node)
                yield from _pairs_of(node, subject.full_name(node.func), code.flow)


def _roots(code: Code) -> Iterator[ast.expr]:
    """Where a cell decides: its conditions, and calls that stand for themselves."""
    yield from (condition.test for condition in conditions(code.tree))
    for node in walk(code.tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            yield node.value


def _pairs_of(node: ast.Call, name: str, flow: Flow) -> Iterator[_Pair]:
    short = last_name(node.func)
    if (name in _ASSERTS and not _is_strict(node)) or short in _CLOSE:
        if len(node.args) >= 2 and not name.startswith("math."):
            yield _Pair(node, node.args[0], node.args[1], True)
    elif short in _REDUCES and isinstance(node.func, ast.Attribute):
        for part in (part for one in (*node.args, node.func) for part in flow.expanded(one)):
            if isinstance(part, ast.BinOp) and isinstance(part.op, ast.Sub):
                yield _Pair(part, part.left, part.right, False)
            elif isinstance(part, ast.Compare):
                yield _Pair(part, part.left, part.comparators[0], False)


def _is_strict(node: ast.Call) -> bool:
    return any(
        word.arg == "strict" and getattr(word.value, "value", None) is True
        for word in node.keywords
    )


def _checked(code: Code, subject: Subject) -> frozenset[str]:
    """Results whose shape the cell asserts, itself or through a helper."""
    found: set[str] = set()
    for root in _roots(code):
        for node in code.flow.expanded(root):
            found |= _shape_asked(node, code.flow)
            if isinstance(node, ast.Call):
                helper = subject.helpers.get(last_name(node.func))
                if _is_strict(node) or last_name(node.func) in _STRICT or _asks_shape(helper):
                    found |= {key for one in node.args for key in code.flow.of(one).keys}
    return frozenset(found)


def _shape_asked(node: ast.AST, flow: Flow) -> set[str]:
    match node:
        case ast.Call(func=function, args=[first, *_]) if last_name(function) in SHAPES:
            return set(flow.of(first).keys)
        case ast.Attribute(attr=attribute, value=inner) if attribute in SHAPES:
            return set(flow.of(inner).keys)
    return set()


def _asks_shape(helper: ast.FunctionDef | None) -> bool:
    parts = [part for one in conditions(helper) for part in walk(one.test)] if helper else []
    names = {last_name(part.func) for part in parts if isinstance(part, ast.Call)}
    names |= {part.attr for part in parts if isinstance(part, ast.Attribute)}
    return bool(names & (SHAPES | _STRICT))


def _empty_passes(subject: Subject) -> Iterator[Found]:
    """All of nothing is true, and any of nothing is false."""
    for code in subject.codes:
        checked = _checked(code, subject)
        for node, _ in subject.calls(code):
            if last_name(node.func) not in ("all", "any"):
                continue
            asked = [code.flow.of(part) for part in _outside_calls(node, code.flow)]
            keys = frozenset(key for value in asked if value.many for key in value.keys)
            # An array on the other side does not fit an empty one.
            has_target = any(value.many and not value.keys for value in asked)
            if not has_target and not _any_is_checked(keys, checked):
                yield Found(
                    code.grade_id,
                    node.lineno,
                    "An empty answer passes, for nothing is compared: assert np.shape or len "
                    "of it in this case.",
                )


def _outside_calls(node: ast.AST, flow: Flow) -> Iterator[ast.AST]:
    """The values in an expression, but for what the student's function was given."""
    if isinstance(node, _VALUES):
        yield node
    if node not in flow.calls:
        for part in ast.iter_child_nodes(node):
            yield from _outside_calls(part, flow)


def _zip_stops(subject: Subject) -> Iterator[Found]:
    """``zip`` ends with the shorter one: an empty answer agrees with everything."""
    for code in subject.codes:
        checked = _checked(code, subject)
        for node, name in subject.calls(code):
            keys = frozenset(key for one in node.args for key in code.flow.of(one).keys)
            if name == "zip" and not _is_strict(node) and not _any_is_checked(keys, checked):
                yield Found(
                    code.grade_id,
                    node.lineno,
                    "zip stops at the shorter one, so that an empty answer passes: "
                    "zip(…, strict=True), or assert its length.",
                )


RULES = (
    Rule(
        "shape-unchecked",
        "error",
        "A result that is compared with an array needs its shape asserted in the same case.",
        _shape_unchecked,
    ),
    Rule(
        "number-unchecked",
        "warning",
        "A result that is compared with a number needs its shape asserted in the same case.",
        _number_unchecked,
    ),
    Rule("empty-passes", "warning", "all and any must not be of nothing.", _empty_passes),
    Rule("zip-stops", "error", "zip must not cut off what is missing.", _zip_stops),
)
