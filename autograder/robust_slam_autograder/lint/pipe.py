"""What a test cannot do: student code runs in another process, and only calls reach it."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.nodes import walk
from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Code, Found, Subject

_INSIDE = frozenset(
    {"__code__", "__closure__", "__globals__", "__defaults__", "__kwdefaults__", "__wrapped__"}
)
_LOOKS = ("inspect.", "dis.", "unittest.mock.", "mock.patch", "pytest.MonkeyPatch")
_CALLS = frozenset({"globals", "get_ipython", "vars", "exec", "eval"})


@rule("looks-inside", "error", "A test calls a student's function, and does not look into it.")
def _looks_inside(subject: Subject) -> Iterator[Found]:
    for code in subject.tests:
        for node in walk(code.tree):
            what = _looked_at(node, code, subject)
            if what:
                yield code.found(
                    node,
                    f"{what} does not reach the student's function, which runs in another "
                    "process: test what it returns.",
                )


def _looked_at(node: ast.AST, code: Code, subject: Subject) -> str:
    """What a piece of code looks at or changes that is on the other side; else empty."""
    if isinstance(node, ast.Call):
        name = subject.full_name(node.func)
        return f"{name}()" if name in _CALLS or name.startswith(_LOOKS) else ""
    if isinstance(node, ast.Attribute):
        functions = code.results.functions - code.results.names
        of_function = isinstance(node.value, ast.Name) and node.value.id in functions
        is_patch = isinstance(node.ctx, ast.Store) and _is_module(node.value, subject)
        if node.attr in _INSIDE or of_function or is_patch:
            return ast.unparse(node)
    return ""


def _is_module(node: ast.expr, subject: Subject) -> bool:
    root = node
    while isinstance(root, ast.Attribute):
        root = root.value
    return isinstance(root, ast.Name) and root.id in subject.modules


@rule("rebinds", "error", "A test must not rebind a student's name.")
def _rebinds(subject: Subject) -> Iterator[Found]:
    for code in subject.tests:
        for node in walk(code.tree):
            name = ""
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store | ast.Del):
                name = node.id
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                name = node.name
            if name in subject.assignment.names:
                yield code.found(
                    node,
                    f"{name} is the student's: from here on every case would test something "
                    "else. Take another name.",
                )
