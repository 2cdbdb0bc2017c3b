"""Finds what of a cell holds a student's results, by names.

The order of statements does not count: a name that is bound to a result anywhere is a result
everywhere in the cell, and so is what is made from it.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field

from robust_slam_autograder.lint.nodes import last_name, walk

SHAPES = frozenset({"shape", "ndim", "size", "len"})
"""Functions and attributes that tell of a value's shape alone."""
_SAME = frozenset({"asarray", "asanyarray", "array", "copy"})


@dataclass(frozen=True)
class Results:
    """The student's functions and results in a cell.

    Attributes:
        functions: names of the student's functions, and of variables that stand for one.
        calls: calls of these.
        raw: variables that only ever hold a result as it came back, or a part of it.
        whole: variables that hold one with all its numbers, perhaps made an array.
        names: variables that hold a result, or what was made from one.
        made: what variables are bound to; of a loop's what it goes through.
    """

    functions: set[str]
    calls: set[ast.Call] = field(default_factory=set)
    raw: set[str] = field(default_factory=set)
    whole: set[str] = field(default_factory=set)
    names: set[str] = field(default_factory=set)
    made: dict[str, list[ast.expr]] = field(default_factory=dict)

    def holds(self, node: ast.AST) -> bool:
        """Return whether an expression has a result in it."""
        return any(self._is_result(part) for part in walk(node))

    def is_raw(self, node: ast.AST) -> bool:
        """Return whether an expression is a result as it came back."""
        return node in self.calls or (isinstance(node, ast.Name) and node.id in self.raw)

    def is_whole(self, node: ast.AST, name: str = "") -> bool:
        """Return whether an expression is a result with all its numbers; ``name`` may be one."""
        if isinstance(node, ast.Call) and last_name(node.func) in _SAME and node.args:
            return self.is_whole(node.args[0], name)
        is_name = isinstance(node, ast.Name) and node.id in self.whole | {name}
        return node in self.calls or is_name

    def _is_result(self, node: ast.AST) -> bool:
        return node in self.calls or (isinstance(node, ast.Name) and node.id in self.names)


def find(tree: ast.AST, functions: Collection[str], variables: Collection[str]) -> Results:
    """Look through a cell.

    Args:
        tree: the cell's.
        functions: what the student is to write.
        variables: other names that the student's cells define.
    """
    found = Results(set(functions), names=set(variables))
    bound = [pair for node in walk(tree) for pair in _bindings(node)]
    for name, value in bound:
        found.made.setdefault(name, []).append(value)
    found.functions.update(name for name, value in bound if found.functions & set(_named(value)))
    calls = (node for node in walk(tree) if isinstance(node, ast.Call))
    found.calls.update(call for call in calls if found.functions & set(_named(call.func)))
    found.raw.update(name for name, made in found.made.items() if found.calls.issuperset(made))
    for name, made in found.made.items():
        if all(found.is_whole(value, name) for value in made):
            found.whole.add(name)
    found.names.update(_parameters(tree))
    before = -1
    while len(found.names) > before:
        before = len(found.names)
        found.names.update(name for name, value in bound if found.holds(value))
    return found


def _bindings(node: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    match node:
        case ast.Assign(targets=targets, value=value):
            yield from ((name, value) for target in targets for name in _named(target))
        case ast.AnnAssign(target=target, value=ast.expr() as value):
            yield from ((name, value) for name in _named(target))
        case ast.NamedExpr(target=target, value=value):
            yield target.id, value
        case ast.For(target=target, iter=source) | ast.comprehension(target=target, iter=source):
            yield from ((name, source) for name in _named(target))


def _named(node: ast.AST) -> Iterator[str]:
    """Names that an expression is, or that stand in the tuples and lists that it is."""
    if isinstance(node, ast.Name):
        yield node.id
    elif isinstance(node, ast.Tuple | ast.List):
        for part in node.elts:
            yield from _named(part)


def _parameters(tree: ast.AST) -> Iterator[str]:
    """Parameters of helpers that ask for no shape: they may be handed any result."""
    for node in walk(tree):
        if isinstance(node, ast.FunctionDef) and not any(map(_asks_shape, walk(node))):
            yield from (argument.arg for argument in node.args.args)


def _asks_shape(node: ast.AST) -> bool:
    """Whether a node asks for a value's shape or length."""
    if isinstance(node, ast.Call):
        return last_name(node.func) in SHAPES | {"array_equal", "assert_equal", "close"}
    return isinstance(node, ast.Attribute) and node.attr in SHAPES
