"""Asserts that cannot fail or say nothing, swallowed faults, and what a test cannot do at all.

Student code runs in another process, and only calls reach it.
"""

import ast

from robust_slam_autograder.lint.rule import code_rule
from robust_slam_autograder.lint.subject import Code, Subject

_ANY_ERROR = frozenset({"Exception", "builtins.Exception"})
_ALL_ENDS = frozenset({"BaseException", "builtins.BaseException"})
_INSIDE = frozenset(
    {"__code__", "__closure__", "__globals__", "__defaults__", "__kwdefaults__", "__wrapped__"}
)
_LOOKS = ("inspect.", "dis.", "unittest.mock.", "mock.patch", "pytest.MonkeyPatch")
_CALLS = frozenset({"globals", "get_ipython", "vars", "exec", "eval"})


@code_rule("assert-tuple", "error", "assert (condition, message) never fails.")
def _assert_tuple(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case ast.Assert(test=ast.Tuple(elts=[_, *_])):
            return "A tuple is always true: assert condition, message, without the brackets."
    return ""


@code_rule("assert-constant", "error", "An assert must be able to fail.")
def _assert_constant(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case ast.Assert(test=ast.Tuple()):
            return ""
        case ast.Assert(test=ast.BoolOp(op=ast.Or(), values=parts) as test):
            is_constant = any(map(_is_always_true, parts))
        case ast.Assert(test=test):
            is_constant = _is_always_true(test)
        case _:
            return ""
    said = f"{ast.unparse(test)} is always true: assert what the student returns."
    return said if is_constant else ""


def _is_always_true(node: ast.expr) -> bool:
    match node:
        case ast.GeneratorExp() | ast.Lambda() | ast.JoinedStr():
            return True
        case ast.Compare(left=left, comparators=others):
            return all(isinstance(part, ast.Constant) for part in (left, *others))
        case ast.BoolOp(op=ast.And(), values=parts):
            return all(map(_is_always_true, parts))
    try:
        return bool(ast.literal_eval(node))
    except (ValueError, TypeError):
        return False


@code_rule("no-message", "warning", "A visible assert says what went wrong.")
def _no_message(node: ast.AST, code: Code, subject: Subject) -> str:
    if code.case is None or code.is_hidden(node):
        return ""
    match node:
        case ast.Assert(msg=None):
            return "Students see this assert without a word: add one that names the misconception."
        case ast.Call(func=ast.Name(id="close"), args=arguments, keywords=words):
            if len(arguments) <= 2 and not any(word.arg == "why" for word in words):
                return "Students see this without a word: add why it must hold."
    return ""


@code_rule("bare-except", "error", "A test must not swallow hangs and deaths.")
def _bare_except(node: ast.AST, code: Code, subject: Subject) -> str:
    if _ALL_ENDS.isdisjoint(_caught(node, subject)):
        return ""
    return "This also takes a hang or an exit for an error: name the exception that is asked for."


@code_rule("broad-except", "warning", "A test names the exception that it asks for.")
def _broad_except(node: ast.AST, code: Code, subject: Subject) -> str:
    if _ANY_ERROR.isdisjoint(_caught(node, subject)):
        return ""
    return "This takes an unwritten function, and any slip, for the error: name that exception."


def _caught(node: ast.AST, subject: Subject) -> list[str]:
    """Names of the exceptions that a piece of code catches; a bare ``except`` catches all."""
    kinds: list[ast.expr] = []
    match node:
        case ast.ExceptHandler(type=None):
            return ["BaseException"]
        case ast.ExceptHandler(type=ast.Tuple(elts=kinds)):
            pass
        case ast.ExceptHandler(type=ast.expr() as kind):
            kinds = [kind]
        case ast.Call(func=called, args=arguments):
            is_catch = subject.full_name(called) in ("pytest.raises", "contextlib.suppress")
            kinds = arguments if is_catch else []
    return [subject.full_name(kind) for kind in kinds]


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
            is_function = full in subject.assignment.names and full not in code.made
            root = ast.unparse(owner).partition(".")[0]
            is_patch = isinstance(context, ast.Store) and root in subject.modules
            what = ast.unparse(node) if attribute in _INSIDE or is_function or is_patch else ""
    if code.case is None or not what:
        return ""
    return f"{what} does not reach into the student's process: test what the function returns."


@code_rule("rebinds", "error", "A test must not rebind a student's name.")
def _rebinds(node: ast.AST, code: Code, subject: Subject) -> str:
    match node:
        case (
            ast.Name(id=name, ctx=ast.Store() | ast.Del())
            | ast.FunctionDef(name=name)
            | ast.ClassDef(name=name)
            | ast.alias(name=name, asname=None)
            | ast.alias(asname=str() as name)
        ) if name in subject.assignment.names and (code.case or isinstance(node, ast.alias)):
            return f"{name} is the student's, and every case would test this: take another name."
    return ""
