"""What a test cannot do: student code runs in another process, and only calls reach it."""

from __future__ import annotations

import ast

from robust_slam_autograder.lint.rule import code_rule
from robust_slam_autograder.lint.subject import Code, Subject

_INSIDE = frozenset(
    {"__code__", "__closure__", "__globals__", "__defaults__", "__kwdefaults__", "__wrapped__"}
)
_LOOKS = ("inspect.", "dis.", "unittest.mock.", "mock.patch", "pytest.MonkeyPatch")
_CALLS = frozenset({"globals", "get_ipython", "vars", "exec", "eval"})


@code_rule(
    "looks-inside", "error", "A test calls a student's function, and does not look into it."
)
def _looks_inside(node: ast.AST, code: Code, subject: Subject) -> str:
    what = ""
    match node:
        case ast.Call(func=called):
            name = subject.full_name(called)
            what = f"{name}()" if name in _CALLS or name.startswith(_LOOKS) else ""
        case ast.Attribute(attr=attribute, value=owner, ctx=context):
            full = subject.full_name(owner)
            is_function = full in subject.functions and full not in code.made
            root = ast.unparse(owner).partition(".")[0]
            is_patch = isinstance(context, ast.Store) and root in subject.modules
            what = ast.unparse(node) if attribute in _INSIDE or is_function or is_patch else ""
    if code.case is None or not what:
        return ""
    return (
        f"{what} does not reach the student's function, which runs in another process: "
        "test what it returns."
    )


@code_rule("rebinds", "error", "A test must not rebind a student's name.")
def _rebinds(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case (
            ast.Name(id=name, ctx=ast.Store() | ast.Del())
            | ast.FunctionDef(name=name)
            | ast.ClassDef(name=name)
        ) if code.case and name in subject.assignment.names:
            return (
                f"{name} is the student's: from here on every case would test something else. "
                "Take another name."
            )
    return ""
