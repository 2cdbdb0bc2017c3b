"""The nodes of a tree, found once: each rule looks through the same cells again."""

from __future__ import annotations

import ast


def walk(tree: ast.AST) -> tuple[ast.AST, ...]:
    """All that ``ast.walk`` gives; the tree must not change afterwards."""
    kept = vars(tree)
    if "_walked" not in kept:
        kept["_walked"] = tuple(ast.walk(tree))
    found: tuple[ast.AST, ...] = kept["_walked"]
    return found
