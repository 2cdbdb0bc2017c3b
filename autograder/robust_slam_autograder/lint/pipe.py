"""What does not work across the pipe between tests and student code."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.flow import Value, last_name
from robust_slam_autograder.lint.nodes import walk
from robust_slam_autograder.lint.rule import Found, Rule
from robust_slam_autograder.lint.subject import Code, Subject, words
from robust_slam_autograder.reading.source import plain_python

_INSIDE = frozenset(
    {"__code__", "__closure__", "__globals__", "__defaults__", "__kwdefaults__", "__wrapped__"}
)
_LOOKS = ("inspect.", "dis.", "unittest.mock.", "mock.patch", "pytest.MonkeyPatch")
_CALLS = frozenset({"globals", "get_ipython", "vars", "exec", "eval"})
_CANNOT_CROSS = frozenset(
    {"iter", "map", "filter", "zip", "enumerate", "reversed", "set", "frozenset", "bytes", "open"}
    | {"bytearray", "object", "memoryview"}
)


def _looks_inside(subject: Subject) -> Iterator[Found]:
    """Tests that look into a function, or change what it uses."""
    for code in subject.tests:
        for node in walk(code.tree):
            what = _looked_at(node, code, subject)
            if what:
                yield Found(
                    code.grade_id,
                    getattr(node, "lineno", 1),
                    f"{what} does not reach the student's function, which runs in another "
                    "process: test what it returns.",
                )


def _looked_at(node: ast.AST, code: Code, subject: Subject) -> str:
    """What a piece of code looks at or changes that is on the other side; else empty."""
    if isinstance(node, ast.Call):
        name = subject.full_name(node.func)
        return f"{name}()" if name in _CALLS or name.startswith(_LOOKS) else ""
    if isinstance(node, ast.Attribute):
        of_function = isinstance(node.value, ast.Name) and bool(
            code.flow.of(node.value).functions and not code.flow.of(node.value).keys
        )
        is_patch = isinstance(node.ctx, ast.Store) and _is_module(node.value, subject)
        if node.attr in _INSIDE or of_function or is_patch:
            return ast.unparse(node)
    return ""


def _is_module(node: ast.expr, subject: Subject) -> bool:
    root = node
    while isinstance(root, ast.Attribute):
        root = root.value
    return isinstance(root, ast.Name) and root.id in subject.modules


def _rebinds(subject: Subject) -> Iterator[Found]:
    """Tests that give a student's name to something else: later cases find that."""
    for code in subject.tests:
        for node in walk(code.tree):
            name = ""
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store | ast.Del):
                name = node.id
            elif isinstance(node, ast.FunctionDef | ast.ClassDef):
                name = node.name
            if name in subject.assignment.names:
                yield Found(
                    code.grade_id,
                    getattr(node, "lineno", 1),
                    f"{name} is the student's: from here on every case would test something "
                    "else. Take another name.",
                )


def _cannot_cross(subject: Subject) -> Iterator[Found]:
    """Arguments of a student's function that are no plain data."""
    for code in subject.codes:
        for call in code.flow.calls:
            for argument in [*call.args, *(keyword.value for keyword in call.keywords)]:
                what = _foreign(argument, code, subject)
                if what:
                    yield Found(
                        code.grade_id,
                        argument.lineno,
                        f"{what} cannot cross to the student's function: hand over numbers, "
                        "strings, lists, tuples, dicts, arrays or functions.",
                    )


def _foreign(node: ast.expr, code: Code, subject: Subject) -> str:
    """What an argument is that cannot cross; empty where it can, or nothing is known."""
    source = code.flow.of(node).source if isinstance(node, ast.Name) else None
    match source or node:
        case ast.GeneratorExp():
            return "A generator"
        case ast.Set() | ast.SetComp():
            return "A set"
        case ast.Constant(value=bytes()):
            return "bytes"
        case ast.Name(id=name):
            return _foreign_name(name, code.flow.of(node), subject)
        case ast.Call() as call:
            called = subject.full_name(call.func)
            if called in _CANNOT_CROSS or last_name(call.func) in subject.classes:
                return f"{called}()"
            return "An array of objects" if _is_of_objects(call) else ""
    return ""


def _asks_for_class(subject: Subject) -> Iterator[Found]:
    """Solution cells whose class the tests use: its instances cannot cross."""
    used = {name for code in subject.tests for name in words(code.source)}
    for cell in subject.solutions:
        for node in walk(_parsed(cell.source)):
            if isinstance(node, ast.ClassDef) and node.name in used:
                yield Found(
                    cell.grade_id or "",
                    node.lineno,
                    f"Tests use the class {node.name}, and its instances cannot cross to them: "
                    "ask for functions.",
                )


def _parsed(source: str) -> ast.Module:
    try:
        return ast.parse(plain_python(source))
    except (SyntaxError, ValueError):
        return ast.Module([], [])


def _foreign_name(name: str, value: Value, subject: Subject) -> str:
    if name == "rng":
        return "A generator (rng)"
    if name in subject.classes:
        return f"The class {name}"
    known = subject.modules.get(name, "")
    is_module = known and (known.split(".")[0] == known or known.rpartition(".")[2].islower())
    return f"The module {name}" if is_module and "." not in known and not value.keys else ""


def _is_of_objects(call: ast.Call) -> bool:
    types = [keyword.value for keyword in call.keywords if keyword.arg == "dtype"]
    return any(
        getattr(kind, "id", getattr(kind, "value", "")) in ("object", "O") for kind in types
    )


RULES = (
    Rule(
        "looks-inside",
        "error",
        "A test calls a student's function, and does not look into it.",
        _looks_inside,
    ),
    Rule("rebinds", "error", "A test must not rebind a student's name.", _rebinds),
    Rule("asks-for-class", "error", "A test uses functions and values.", _asks_for_class),
    Rule("cannot-cross", "error", "What is handed over is plain data.", _cannot_cross),
)
