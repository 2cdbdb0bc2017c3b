"""What a test demands: the conditions of its asserts, and how they fare with NaN."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from robust_slam_autograder.lint.flow import VERDICTS, Flow, last_name
from robust_slam_autograder.lint.nodes import walk

_ORDER = (ast.Lt, ast.LtE, ast.Gt, ast.GtE)
_KEEP = frozenset({"any", "all", "bool", "logical_and", "logical_or"})
_COUNTS = frozenset({"sum", "mean", "count_nonzero", "len", "flatnonzero", "nonzero", "any"})


@dataclass(frozen=True)
class Condition:
    """An expression, and whether it must be true or false."""

    test: ast.expr
    holds: bool


def conditions(tree: ast.AST) -> Iterator[Condition]:
    """What a piece of code demands: of asserts, of ``if`` that leads to a failure, of helpers."""
    for node in walk(tree):
        match node:
            case ast.Assert():
                yield Condition(node.test, True)
            case ast.If():
                if _fails(node.body):
                    yield Condition(node.test, False)
                elif _fails(node.orelse):
                    yield Condition(node.test, True)
            case ast.Return(value=ast.expr() as test) if _is_verdict(test):
                yield Condition(test, True)


def _is_verdict(node: ast.expr) -> bool:
    """Whether a helper returns a yes or no."""
    is_call = isinstance(node, ast.Call) and last_name(node.func) in _KEEP | VERDICTS
    is_not = isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not)
    return is_call or is_not or isinstance(node, ast.Compare | ast.BoolOp)


def _fails(body: list[ast.stmt]) -> bool:
    """Whether a branch is there to fail: it raises, asserts False or calls fail."""
    return any(
        isinstance(node, ast.Raise)
        or (isinstance(node, ast.Assert) and getattr(node.test, "value", None) is False)
        or (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Call)
            and last_name(node.value.func) == "fail"
        )
        for node in body
    )


def comparisons(condition: Condition, flow: Flow) -> Iterator[tuple[ast.Compare, bool]]:
    """The comparisons in a condition, and whether each must be true or false.

    Variables stand for what they were made from.
    """
    return _comparisons(condition.test, condition.holds, flow, frozenset())


def _comparisons(
    node: ast.expr, holds: bool, flow: Flow, seen: frozenset[ast.AST]
) -> Iterator[tuple[ast.Compare, bool]]:
    if node in seen:
        return
    for inner, kept in _inside(node, flow):
        yield from _comparisons(inner, holds == kept, flow, seen | {node})
    if isinstance(node, ast.Compare):
        counted = _counted(node)
        yield from ((one, not holds) for one in counted)
        if not counted:
            yield node, holds


def _inside(node: ast.expr, flow: Flow) -> Iterator[tuple[ast.expr, bool]]:
    """The parts that decide a condition, and whether they decide it as they are or negated."""
    match node:
        case ast.UnaryOp(op=ast.Not() | ast.Invert(), operand=inner):
            yield inner, False
        case ast.BoolOp(values=parts):
            yield from ((part, True) for part in parts)
        case ast.BinOp(op=ast.BitAnd() | ast.BitOr(), left=left, right=right):
            yield from ((left, True), (right, True))
        case ast.Call(func=function, args=arguments):
            name = last_name(function)
            if name in _KEEP or name == "logical_not":
                owner = function.value if isinstance(function, ast.Attribute) else None
                yield from ((part, name in _KEEP) for part in [*arguments, owner] if part)
        case ast.GeneratorExp(elt=inner) | ast.ListComp(elt=inner) | ast.NamedExpr(value=inner):
            yield inner, True
        case ast.Name():
            source = flow.of(node).source
            yield from [(source, True)] if source is not None else []
        case ast.Compare(
            left=left, ops=[ast.Eq() | ast.Is()], comparators=[ast.Constant() as said]
        ):
            yield from [(left, bool(said.value))] if isinstance(said.value, bool) else []


def _counted(node: ast.Compare) -> list[ast.Compare]:
    """Comparisons of which only few may be true: sum(a > b) == 0, mean(a > b) < 0.1."""
    small = isinstance(node.ops[0], ast.Lt | ast.LtE) or (
        isinstance(node.ops[0], ast.Eq) and getattr(node.comparators[0], "value", None) == 0
    )
    parts = list(walk(node.left))
    calls = [part for part in parts if isinstance(part, ast.Call)]
    if not small or not any(last_name(call.func) in _COUNTS for call in calls):
        return []
    return [part for part in parts if isinstance(part, ast.Compare) and is_order(part)]


def is_order(node: ast.Compare) -> bool:
    """Whether a comparison asks for less or more, so that it is false for NaN."""
    return isinstance(node.ops[0], _ORDER)
