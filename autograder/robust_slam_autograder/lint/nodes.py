"""The nodes of a tree, found once: each rule looks through the same cells again."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.reading.source import plain_python, tree_of


def parsed(source: str) -> ast.Module:
    """Return a cell's tree; an empty one where the cell is no Python, which another rule tells."""
    return tree_of(plain_python(source))


def walk(tree: ast.AST) -> tuple[ast.AST, ...]:
    """Return all that ``ast.walk`` gives; the tree must not change afterwards."""
    kept = vars(tree)
    if "_walked" not in kept:
        kept["_walked"] = tuple(ast.walk(tree))
    found: tuple[ast.AST, ...] = kept["_walked"]
    return found


def around(node: ast.AST, tree: ast.AST) -> Iterator[ast.AST]:
    """Yield what a node of a tree stands in, from the inside out."""
    kept = vars(tree)
    if "_parents" not in kept:
        pairs = ((child, one) for one in walk(tree) for child in ast.iter_child_nodes(one))
        kept["_parents"] = dict(pairs)
    parents: dict[ast.AST, ast.AST] = kept["_parents"]
    while node in parents:
        node = parents[node]
        yield node


def last_name(node: ast.expr) -> str:
    """Return the last part of a dotted name: np.linalg.norm is norm; empty for other code."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""
