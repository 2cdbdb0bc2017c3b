"""Modules of a public copy that import one which stays private would not run there."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.publishing.course import COURSE_NAME


def refuse_private(root: Path, made: Path) -> None:
    """Refuse a copy of a course in which a module imports a file that was not copied.

    Args:
        root: the course, whose folders are packages.
        made: the copy.

    Raises:
        GraderFailure: names the module and the file.
    """
    seen: set[tuple[str, ...]] = set()
    for path in sorted(made.rglob("*.py")):
        name = path.relative_to(made)
        found = imported(path.read_text(encoding="utf-8"), name.parent.parts)
        for module in dict.fromkeys(module for module in found if module not in seen):
            seen.add(module)
            for file in _files_of(module):
                if (root / file).is_file() and not (made / file).is_file():
                    raise GraderFailure(
                        f"{name} imports {file}, which stays private: leave both out in "
                        f"{COURSE_NAME}, or none. Nothing written."
                    )


def imported(source: str, package: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """The modules that a file of a package may import, each as the parts of its name."""
    for node in _statements(ast.parse(source)):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            module = (*above, *(node.module.split(".") if node.module else ()))
            yield module
            yield from ((*module, alias.name) for alias in node.names)


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """All statements below a node; looking into their expressions would take longer."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, (ast.stmt, ast.ExceptHandler, ast.match_case)):
            yield child
            yield from _statements(child)


def _files_of(module: tuple[str, ...]) -> Iterator[str]:
    """Where a module and the packages that it is in would stand."""
    for end in range(1, len(module) + 1):
        path = "/".join(module[:end])
        yield f"{path}/__init__.py"
        yield f"{path}.py"
