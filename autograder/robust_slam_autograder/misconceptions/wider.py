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
from robust_slam_autograder.misconceptions.slips import Change, Site, called

_SQUARED = (ast.Compare, ast.BinOp, ast.Call)
_FACTORS = (ast.Mult, ast.Div, ast.MatMult)
_TERMS = (ast.Add, ast.Sub)
STEPS = (2, 3, 10, 20, 50, 100)
"""After which a loop may be made to end."""


def mutants(source: str) -> list[Mutant]:
    """Return the mutants of a cell, those of ``mutators`` first, no two of them alike."""
    found: dict[str, Mutant] = {}
    for each in (mutators.variants, variants):
        for one in mutators.changed(source, each):
            found.setdefault(one.source, one)
    return list(found.values())


def variants(site: Site) -> Iterator[Change]:
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
                yield Change("compared with square", ast.Compare(side, node.ops, [other]))
    elif isinstance(node, ast.Subscript):
        yield Change("entry", node.value)
    elif isinstance(node, ast.BoolOp):
        yield from (Change("condition lost", value) for value in node.values)
    if isinstance(node, ast.Name | ast.Subscript | ast.Attribute) and isinstance(
        site.parent, _SQUARED
    ):
        is_function = isinstance(site.parent, ast.Call) and site.field == "func"
        if not is_function:
            yield Change("square added", _square(node))
            yield Change("size added", _call("abs", node))
            yield Change("root added", _call("np.sqrt", node))
    if isinstance(site.parent, ast.If | ast.IfExp) and site.field == "test":
        yield from (Change("case", ast.Constant(truth)) for truth in (True, False))


def _of_statement(node: ast.stmt) -> Iterator[Change]:
    if isinstance(node, ast.For | ast.While):
        yield from (Change("one step", loop) for loop in _shorter(node))
    elif isinstance(node, ast.Return) and node.value is not None:
        parts = node.value.elts if isinstance(node.value, ast.Tuple) else []
        yield Change("part" if parts else "flat", ast.Return(_call("np.ravel", node.value)))
        yield from (Change("part", ast.Return(part)) for part in parts)


def _shorter(loop: ast.For | ast.While) -> Iterator[ast.AST]:
    """Yield the loop with one step, and with a few where it counts them or waits for an end."""
    once = [*loop.body, ast.Break()]
    if isinstance(loop, ast.While):
        yield ast.While(loop.test, once, loop.orelse)
        none = ast.Name("_", ast.Store())
        yield from (_steps(none, loop.test, loop.body, steps) for steps in STEPS)
        return
    yield ast.For(loop.target, loop.iter, once, loop.orelse)
    if ast.unparse(loop.iter).startswith("range("):
        yield from (_steps(loop.target, None, loop.body, steps) for steps in STEPS)


def _steps(target: ast.expr, test: ast.expr | None, body: list[ast.stmt], steps: int) -> ast.AST:
    """Return a loop of at most so many steps."""
    last = [] if test is None else [ast.If(ast.UnaryOp(ast.Not(), test), [ast.Break()], [])]
    rounds = ast.Call(ast.Name("range", ast.Load()), [ast.Constant(steps)], [])
    return ast.For(target, rounds, [*last, *body], [])


def _of_operator(node: ast.BinOp) -> Iterator[Change]:
    left, right = node.left, node.right
    if isinstance(node.op, ast.Pow):
        is_square = isinstance(right, ast.Constant) and right.value == 2
        yield Change("square lost" if is_square else "power", left, left)
        if is_square:
            yield Change("power", _call("np.sqrt", left), left)
            yield Change("size for square", _call("abs", left), left)
    elif isinstance(node.op, _FACTORS):
        is_quotient = isinstance(node.op, ast.Div)
        yield Change("divisor lost" if is_quotient else "factor lost", left, right)
        yield Change("factor lost", right, left)
        if is_quotient:
            yield Change("upside down", ast.BinOp(right, ast.Div(), left))
    elif isinstance(node.op, _TERMS):
        yield Change("term lost", left, right)
        yield Change("term lost", right, left)
        if isinstance(node.op, ast.Sub):
            yield Change("turned round", ast.BinOp(right, ast.Sub(), left))
            yield Change("size added", _call("abs", node))


def _of_call(node: ast.Call) -> Iterator[Change]:
    name, args = called(node), node.args
    if any(isinstance(arg, ast.Starred) for arg in args):
        return
    if name == "where" and len(args) == 3:
        yield from (Change("case", args[1]), Change("case", args[2]))
        yield Change("condition", _call("np.where", args[0], args[2], args[1]))
    elif name in ("maximum", "minimum", "clip", "max", "min") and len(args) >= 2:
        yield from (Change("bound lost", args[0]), Change("bounded", args[1]))
        if name == "clip" and len(args) == 3:
            yield Change("bound lost", _call("np.minimum", args[0], args[2]))
            yield Change("bound lost", _call("np.maximum", args[0], args[1]))
    elif name == "square" and len(args) == 1:
        yield Change("size for square", _call("abs", args[0]))
        twice = ast.BinOp(args[0], ast.Mult(), ast.Constant(2))
        yield Change("twice for square", twice)
    elif name == "sum":
        largest = ast.Call(_function("np.max"), args, node.keywords)
        yield Change("largest for sum", largest)
        if args and isinstance(args[0], ast.BinOp) and isinstance(args[0].op, ast.Pow):
            whole = ast.Call(node.func, [args[0].left, *args[1:]], node.keywords)
            yield Change("sum before square", _square(whole))
    elif name in ("mean", "average"):
        yield Change("median", _call("np.median", *args[:1]))
    elif name == "inv" and len(args) == 1:
        yield Change("inverse lost", _call("np.linalg.pinv", *args))


def _square(node: ast.expr) -> ast.expr:
    return ast.BinOp(node, ast.Pow(), ast.Constant(2))


def _call(name: str, *args: ast.expr) -> ast.expr:
    return ast.Call(_function(name), list(args), [])


def _function(name: str) -> ast.expr:
    return ast.parse(name, mode="eval").body
