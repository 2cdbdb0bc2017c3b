"""Comparisons that NaN passes."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.demands import comparisons, conditions, is_order
from robust_slam_autograder.lint.flow import last_name
from robust_slam_autograder.lint.rule import Found, Rule
from robust_slam_autograder.lint.subject import Code, Subject

_SKIPPING = frozenset(
    {"nanmax", "nanmin", "nanmean", "nansum", "nanmedian", "nanstd", "nanvar", "nanprod"}
    | {"nanargmax", "nanargmin", "nanpercentile", "nanquantile", "nan_to_num"}
)
_FINITE = frozenset({"isfinite", "isnan", "allclose", "array_equal"})
_EQUAL_NAN = frozenset({"allclose", "isclose", "array_equal"})


def _nan_passes(subject: Subject) -> Iterator[Found]:
    """Comparisons that must be false, or unequal: NaN is neither more nor less nor equal."""
    for code in subject.codes:
        seen = set()
        for condition in conditions(code.tree):
            for node, holds in comparisons(condition, code.flow):
                if node in seen or not _passes(node, holds) or _is_safe(node, code):
                    continue
                seen.add(node)
                yield Found(
                    code.grade_id,
                    node.lineno,
                    f"NaN passes, because {ast.unparse(node)} is "
                    f"{'true' if holds else 'false'} for it: ask for what shall hold "
                    "(assert np.all(error <= tol)), or assert np.isfinite first.",
                )


def _passes(node: ast.Compare, holds: bool) -> bool:
    if is_order(node) or isinstance(node.ops[0], ast.Eq):
        return not holds
    return isinstance(node.ops[0], ast.NotEq) and holds


def _is_safe(node: ast.Compare, code: Code) -> bool:
    parts = [node.left, *node.comparators]
    keys = frozenset[str]().union(*(code.flow.of(part).keys for part in parts))
    not_numbers = (ast.List, ast.Tuple, ast.Dict, ast.JoinedStr)
    if not is_order(node) and any(
        isinstance(part, not_numbers) or isinstance(getattr(part, "value", 0), str | bool | None)
        for part in parts
    ):
        return True
    return keys <= _guarded(code, node)


def _guarded(code: Code, place: ast.AST) -> frozenset[str]:
    """Results of which the cell asserts elsewhere that they are numbers.

    What the hidden region asserts is of other inputs than what is visible.
    """
    found: set[str] = set()
    for condition in conditions(code.tree):
        for node in code.flow.expanded(condition.test):
            there = code.is_hidden(place) or not code.is_hidden(node)
            if there and isinstance(node, ast.Call) and last_name(node.func) in _FINITE:
                found |= {k for argument in node.args[:2] for k in code.flow.of(argument).keys}
    return frozenset(found)


def _nan_order(subject: Subject) -> Iterator[Found]:
    """Python's own max and min, which NaN gets past unless it comes first."""
    for code in subject.codes:
        for node, name in subject.calls(code):
            keys = {key for argument in node.args for key in code.flow.of(argument).keys}
            if name in ("max", "min", "sorted") and not keys <= _guarded(code, node):
                yield Found(
                    code.grade_id,
                    node.lineno,
                    f"{name}() passes over NaN unless it comes first: take np.max or np.min, "
                    "or compare every one (np.all(errors <= tol)).",
                )


def _nan_skipped(subject: Subject) -> Iterator[Found]:
    """Functions that leave NaN out."""
    for code in subject.codes:
        for node, name in subject.calls(code):
            is_skipping = name.startswith("numpy.") and last_name(node.func) in _SKIPPING
            if is_skipping and any(code.flow.of(argument).keys for argument in node.args):
                yield Found(
                    code.grade_id,
                    node.lineno,
                    f"{ast.unparse(node.func)} leaves NaN out, so that an answer of NaN passes: "
                    "take the function that does not.",
                )


def _equal_nan(subject: Subject) -> Iterator[Found]:
    """``equal_nan=True``, and numpy.testing's own default between two of the student's values."""
    for code in subject.codes:
        for node, name in subject.calls(code):
            sides = [bool(code.flow.of(argument).keys) for argument in node.args[:2]]
            asked = {word.arg: getattr(word.value, "value", None) for word in node.keywords}
            if last_name(node.func) in _EQUAL_NAN:
                wrong = asked.get("equal_nan") is True and any(sides)
            else:
                by_default = name.startswith("numpy.testing.assert_") and len(sides) == 2
                wrong = by_default and all(sides) and asked.get("equal_nan") is not False
            if wrong:
                yield Found(
                    code.grade_id,
                    node.lineno,
                    "NaN agrees with NaN here: leave equal_nan out (in numpy.testing: "
                    "equal_nan=False), or assert np.isfinite first.",
                )


RULES = (
    Rule("nan-passes", "error", "A comparison must not be one that NaN passes.", _nan_passes),
    Rule("nan-order", "error", "Python's max, min and sorted get past NaN.", _nan_order),
    Rule("nan-skipped", "error", "np.nanmax and its like leave NaN out.", _nan_skipped),
    Rule("equal-nan", "warning", "NaN must not agree with NaN.", _equal_nan),
)
