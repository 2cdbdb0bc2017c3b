"""Where inputs come from: `rng`, drawn in cases, and nothing else."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.rule import code_rule, rule
from robust_slam_autograder.lint.subject import Code, Found, Subject

RNG = "rng"
_MAKERS = frozenset({"default_rng", "RandomState", "Random", "Generator", "SeedSequence"})
_UNSEEDED = ("secrets.", "uuid.", "time.time", "os.urandom", "random.SystemRandom")


@rule("no-rng", "warning", "A hidden region draws its inputs from rng.")
def _no_rng(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        hidden = (node for node in code.nodes if code.is_hidden(node))
        if not any(map(_is_rng, hidden)):
            yield Found(
                code.grade_id,
                code.regions[0].start,
                "The hidden inputs are the same for ever, and can be fitted once they are known: "
                "draw them from rng.",
            )


def _is_rng(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and node.id == RNG


@code_rule("other-random", "error", "All that is random follows from rng.")
def _other_random(node: ast.AST, code: Code, subject: Subject) -> str:
    if not isinstance(node, ast.Call):
        return ""
    name = subject.full_name(node.func)
    module, _, function = name.rpartition(".")
    is_other = name.startswith(_UNSEEDED)
    if module in ("numpy.random", "random"):
        is_other = function not in _MAKERS or not (node.args or node.keywords)
    said = (
        f"{ast.unparse(node.func)} does not follow from the batch's seed, so a mark may change "
        "from run to run: draw from rng."
    )
    return said if is_other else ""


@rule("setup-draws", "error", "A set-up cell must not draw.")
def _setup_draws(subject: Subject) -> Iterator[Found]:
    for code in subject.setup:
        for node in _at_once(code.tree):
            if isinstance(node, ast.Call) and _uses_rng(node):
                yield code.found(
                    node,
                    "The set-up draws from rng, and the student's side has another seed: "
                    "draw in the cases.",
                )


def _at_once(node: ast.AST) -> Iterator[ast.AST]:
    """The code below that runs with its cell, and not when a function is called."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.FunctionDef | ast.Lambda):
            yield child
            yield from _at_once(child)


def _uses_rng(node: ast.Call) -> bool:
    parts = [node.func, *node.args, *(keyword.value for keyword in node.keywords)]
    return any(_is_rng(getattr(part, "value", part)) for part in parts)
