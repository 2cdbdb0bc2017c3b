"""More mutants of a cell than a test suite is measured by: slips of students, not of typists.

A factor or a term is left out, a square is lost or added, a loop takes one step, a case is
forgotten. Of the changes that ``mutators`` makes these are no part, because a mutation score
counts each of them once.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.misconceptions import mutators
from robust_slam_autograder.misconceptions.mutators import Mutant
from robust_slam_autograder.misconceptions.site import Site

_SQUARED = (ast.Compare, ast.BinOp, ast.Call)
_FACTORS = (ast.Mult, ast.Div, ast.MatMult)
_TERMS = (ast.Add, ast.Sub)
STEPS = (2, 3, 10, 20, 50, 100)
"""After which a loop may be made to end."""


def mutants(exercise: str, source: str) -> list[Mutant]:
    """Return the mutants of a cell, those of ``mutators`` first, no two of them alike."""
    lines = [(0, source.count("\n") + 2)]
    first = list(mutators.changed(exercise, source, lines, mutators.variants))
    found = {one.source: one for one in first}
    for one in mutators.changed(exercise, source, lines, variants):
        found.setdefault(one.source, one)
    return list(found.values())


def variants(site: Site) -> Iterator[ast.AST]:
    """Yield what a student may have written in a node's place."""
    node = site.node
    if isinstance(node, ast.stmt):
        yield from _of_statement(node)
        return
    if isinstance(getattr(node, "ctx", None), ast.Store | ast.Del):
        return
    if isinstance(node, ast.BinOp):
        yield from _of_operator(node)
    elif isinstance(node, ast.Call):
        yield from _of_call(node)
    elif isinstance(node, ast.Compare) and len(node.ops) == 1:
        for side in (_square(node.left), node.left):
            for other in (_square(node.comparators[0]), node.comparators[0]):
                yield ast.Compare(side, node.ops, [other])
    elif isinstance(node, ast.Subscript):
        yield node.value
    elif isinstance(node, ast.BoolOp):
        yield from node.values
    if isinstance(node, ast.Name | ast.Subscript | ast.Attribute) and isinstance(
        site.parent, _SQUARED
    ):
        is_function = isinstance(site.parent, ast.Call) and site.field == "func"
        if not is_function:
            yield _square(node)
            yield _call("abs", node)
            yield _call("np.sqrt", node)
    if isinstance(site.parent, ast.If | ast.IfExp) and site.field == "test":
        yield from (ast.Constant(True), ast.Constant(False))


def _of_statement(node: ast.stmt) -> Iterator[ast.AST]:
    if isinstance(node, ast.For):
        yield ast.For(node.target, node.iter, [*node.body, ast.Break()], node.orelse)
        if ast.unparse(node.iter).startswith("range("):
            yield from (_steps(node.target, None, node.body, steps) for steps in STEPS)
    elif isinstance(node, ast.While):
        yield ast.While(node.test, [*node.body, ast.Break()], node.orelse)
        none = ast.Name("_", ast.Store())
        yield from (_steps(none, node.test, node.body, steps) for steps in STEPS)
    elif isinstance(node, ast.Return) and node.value is not None:
        yield ast.Return(_call("np.ravel", node.value))
        if isinstance(node.value, ast.Tuple):
            for n in range(len(node.value.elts)):
                yield ast.Return(node.value.elts[n])


def _steps(target: ast.expr, test: ast.expr | None, body: list[ast.stmt], steps: int) -> ast.AST:
    """Return a loop of at most so many steps."""
    last = [] if test is None else [ast.If(ast.UnaryOp(ast.Not(), test), [ast.Break()], [])]
    rounds = ast.Call(ast.Name("range", ast.Load()), [ast.Constant(steps)], [])
    return ast.For(target, rounds, [*last, *body], [])


def _of_operator(node: ast.BinOp) -> Iterator[ast.AST]:
    left, right = node.left, node.right
    if isinstance(node.op, ast.Pow):
        yield left
        if isinstance(right, ast.Constant) and right.value == 2:
            yield _call("np.sqrt", left)
            yield _call("abs", left)
    elif isinstance(node.op, _FACTORS):
        yield left
        yield right
        if isinstance(node.op, ast.Div):
            yield ast.BinOp(right, ast.Div(), left)
    elif isinstance(node.op, _TERMS):
        yield left
        yield right
        if isinstance(node.op, ast.Sub):
            yield ast.BinOp(right, ast.Sub(), left)
            yield _call("abs", node)


def _of_call(node: ast.Call) -> Iterator[ast.AST]:
    name = ast.unparse(node.func).rpartition(".")[2]
    args = node.args
    if any(isinstance(arg, ast.Starred) for arg in args):
        return
    if name == "where" and len(args) == 3:
        yield from (args[1], args[2], _call("np.where", args[0], args[2], args[1]))
    elif name in ("maximum", "minimum", "clip", "max", "min") and len(args) >= 2:
        yield from args[:2]
        if name == "clip" and len(args) == 3:
            yield _call("np.minimum", args[0], args[2])
            yield _call("np.maximum", args[0], args[1])
    elif name == "square" and len(args) == 1:
        yield _call("abs", args[0])
        yield ast.BinOp(args[0], ast.Mult(), ast.Constant(2))
    elif name == "sum":
        yield ast.Call(_function("np.max"), args, node.keywords)
        if args and isinstance(args[0], ast.BinOp) and isinstance(args[0].op, ast.Pow):
            yield _square(ast.Call(node.func, [args[0].left, *args[1:]], node.keywords))
    elif name in ("mean", "average"):
        yield _call("np.median", *args[:1])
    elif name == "inv" and len(args) == 1:
        yield _call("np.linalg.pinv", *args)


def _square(node: ast.expr) -> ast.expr:
    return ast.BinOp(node, ast.Pow(), ast.Constant(2))


def _call(name: str, *args: ast.expr) -> ast.expr:
    return ast.Call(_function(name), list(args), [])


def _function(name: str) -> ast.expr:
    return ast.parse(name, mode="eval").body
