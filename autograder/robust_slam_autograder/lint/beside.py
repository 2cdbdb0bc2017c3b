"""What lies beside the notebook: ``autograder.toml``, and answers to test the tests with."""

from __future__ import annotations

import ast
import importlib.util
from collections.abc import Iterator
from itertools import pairwise

from robust_slam_autograder.lint.rule import Found, Rule
from robust_slam_autograder.lint.subject import Subject
from robust_slam_autograder.reading.assignment import CONFIG_NAME


def _no_module(subject: Subject) -> Iterator[Found]:
    """Withheld modules that are not there: a slip in a name withholds nothing."""
    for name in subject.assignment.config.withheld:
        if not _exists(name):
            yield Found(
                CONFIG_NAME,
                1,
                f"withheld names {name}, which is not installed here: mend the name, "
                "or install what the assignment uses.",
            )


def _exists(name: str) -> bool:
    """Whether a module can be found; of its packages only those around it are imported."""
    try:
        return importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        return False


def _limits(subject: Subject) -> Iterator[Found]:
    """A limit that is never reached, because the one around it is shorter."""
    limits = subject.assignment.config.limits
    order = ("call_seconds", "cell_seconds", "notebook_seconds")
    for inner, outer in pairwise(order):
        if getattr(limits, inner) > getattr(limits, outer):
            yield Found(
                CONFIG_NAME,
                1,
                f"{inner} ({getattr(limits, inner):g}) is more than {outer} "
                f"({getattr(limits, outer):g}), and so never counts: make it less.",
            )


def _no_mutant(subject: Subject) -> Iterator[Found]:
    """Exercises without a wrong answer that the tests must catch, or without a right one."""
    if subject.answers is None:
        return
    folder = subject.answers / subject.assignment.name
    for cell in subject.solutions:
        path = folder / f"{cell.grade_id}.py"
        names = _functions(path.read_text(encoding="utf-8")) if path.is_file() else []
        for kind in ("wrong_", "right_"):
            if not any(name.startswith(kind) for name in names):
                yield Found(
                    cell.grade_id or "",
                    1,
                    f"{path} has no function {kind}…: add an answer that the tests must "
                    f"{'catch' if kind == 'wrong_' else 'accept'}.",
                )


def _functions(text: str) -> list[str]:
    try:
        body = ast.parse(text).body
    except (SyntaxError, ValueError):
        return []
    return [node.name for node in body if isinstance(node, ast.FunctionDef)]


RULES = (
    Rule("no-module", "error", "A withheld module must exist.", _no_module),
    Rule(
        "limits",
        "error",
        "A limit is at most the one around it.",
        _limits,
    ),
    Rule(
        "no-mutant",
        "error",
        "With --answers: each exercise has a wrong_… and a right_… answer.",
        _no_mutant,
    ),
)
