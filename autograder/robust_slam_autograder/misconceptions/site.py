"""A place in a program's tree where something else may stand."""

from __future__ import annotations

import ast
from dataclasses import dataclass


@dataclass(frozen=True)
class Site:
    """A node that may be changed, and where its parent holds it."""

    parent: ast.AST
    field: str
    index: int | None
    node: ast.expr | ast.stmt

    def put(self, node: ast.AST) -> None:
        """Put another node in its place."""
        if self.index is None:
            setattr(self.parent, self.field, node)
        else:
            getattr(self.parent, self.field)[self.index] = node
