"""Asserts that cannot fail or say nothing, and faults that a test would swallow."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.nodes import walk
from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Code, Found, Subject

_ANY_ERROR = frozenset({"Exception", "builtins.Exception"})
_ALL_ENDS = frozenset({"BaseException", "builtins.BaseException"})


def _asserts(subject: Subject) -> Iterator[tuple[Code, ast.Assert]]:
    for code in subject.codes:
        for node in walk(code.tree):
            if isinstance(node, ast.Assert):
                yield code, node


@rule("assert-tuple", "error", "assert (condition, message) never fails.")
def _assert_tuple(subject: Subject) -> Iterator[Found]:
    for code, node in _asserts(subject):
        if isinstance(node.test, ast.Tuple) and node.test.elts:
            yield code.found(
                node,
                "A tuple is always true: assert condition, message, without the brackets.",
            )


@rule("assert-constant", "error", "An assert must be able to fail.")
def _assert_constant(subject: Subject) -> Iterator[Found]:
    for code, node in _asserts(subject):
        parts = node.test.values if isinstance(node.test, ast.BoolOp) else [node.test]
        always = [_is_always_true(part) for part in parts if not isinstance(part, ast.Tuple)]
        is_and = isinstance(node.test, ast.BoolOp) and isinstance(node.test.op, ast.And)
        if always and (all(always) if is_and else any(always)):
            yield code.found(
                node,
                f"{ast.unparse(node.test)} is always true: assert what the student returns.",
            )


def _is_always_true(node: ast.expr) -> bool:
    if isinstance(node, ast.GeneratorExp | ast.Lambda | ast.JoinedStr):
        return True
    if isinstance(node, ast.Compare):
        parts = [node.left, *node.comparators]
        return all(isinstance(part, ast.Constant) for part in parts)
    try:
        return bool(ast.literal_eval(node))
    except (ValueError, TypeError):
        return False


@rule("no-message", "warning", "A visible assert says what went wrong.")
def _no_message(subject: Subject) -> Iterator[Found]:
    for code, node in _asserts(subject):
        if code.case and node.msg is None and not code.is_hidden(node):
            yield code.found(
                node,
                "Students see this assert without a word: add a message that names the "
                "misconception.",
            )
    for code in subject.tests:
        for call, name in subject.calls(code):
            is_told = len(call.args) > 2 or any(word.arg == "why" for word in call.keywords)
            if name == "close" and not is_told and not code.is_hidden(call):
                yield code.found(call, "Students see this without a word: add why it must hold.")


@rule("bare-except", "error", "A test must not swallow hangs and deaths.")
def _bare_except(subject: Subject) -> Iterator[Found]:
    yield from _handlers(
        subject,
        _ALL_ENDS,
        "This also takes a hang, or the end of the process, for an error: "
        "name the exception that the exercise asks for.",
    )


@rule("broad-except", "warning", "A test names the exception that it asks for.")
def _broad_except(subject: Subject) -> Iterator[Found]:
    yield from _handlers(
        subject,
        _ANY_ERROR,
        "This takes an unwritten function's NotImplementedError, and any slip, for the error "
        "that is asked for: name that exception.",
    )


def _handlers(subject: Subject, names: frozenset[str], message: str) -> Iterator[Found]:
    for code in subject.codes:
        for node in walk(code.tree):
            for kind in _caught(node, subject):
                if kind in names:
                    yield code.found(node, message)


def _caught(node: ast.AST, subject: Subject) -> list[str]:
    """Names of the exceptions that a piece of code catches; a bare ``except`` catches all."""
    kinds: list[ast.expr] = []
    if isinstance(node, ast.ExceptHandler):
        if node.type is None:
            return ["BaseException"]
        kinds = node.type.elts if isinstance(node.type, ast.Tuple) else [node.type]
    elif isinstance(node, ast.Call):
        called = subject.full_name(node.func)
        kinds = node.args if called in ("pytest.raises", "contextlib.suppress") else []
    return [subject.full_name(kind) for kind in kinds]
