"""Where inputs come from: `rng`, drawn in cases, and nothing else."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.nodes import around, walk
from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Code, Found, Subject

RNG = "rng"
_MAKERS = frozenset({"default_rng", "RandomState", "Random", "Generator", "SeedSequence"})
_UNSEEDED = ("secrets.", "uuid.", "time.time", "os.urandom", "random.SystemRandom")


@rule("no-rng", "warning", "A hidden region draws its inputs from rng.")
def _no_rng(subject: Subject) -> Iterator[Found]:
    for code in subject.tests:
        hidden = [node for node in walk(code.tree) if code.is_hidden(node)]
        names = {node.id for node in hidden if isinstance(node, ast.Name)}
        if code.regions and RNG not in names:
            yield Found(
                code.grade_id,
                code.regions[0].start,
                "The hidden inputs are the same for ever, and can be fitted once they are known: "
                "draw them from rng.",
            )


@rule("other-random", "error", "All that is random follows from rng.")
def _other_random(subject: Subject) -> Iterator[Found]:
    for code in subject.codes:
        for node, name in subject.calls(code):
            if _is_other(node, name):
                yield code.found(
                    node,
                    f"{ast.unparse(node.func)} does not follow from the batch's seed, so a mark "
                    "may change from run to run: draw from rng.",
                )


def _is_other(node: ast.Call, name: str) -> bool:
    module, _, function = name.rpartition(".")
    if module in ("numpy.random", "random"):
        return function not in _MAKERS or not (node.args or node.keywords)
    return name.startswith(_UNSEEDED)


@rule("setup-draws", "error", "A set-up cell must not draw.")
def _setup_draws(subject: Subject) -> Iterator[Found]:
    for code in subject.setup:
        for node in walk(code.tree):
            if isinstance(node, ast.Call) and _uses_rng(node) and not _in_function(node, code):
                yield code.found(
                    node,
                    "The set-up draws from rng, and the student's side has another seed: "
                    "draw in the cases.",
                )


def _uses_rng(node: ast.Call) -> bool:
    parts = [node.func, *node.args, *(keyword.value for keyword in node.keywords)]
    owners = [part.value if isinstance(part, ast.Attribute) else part for part in parts]
    return any(isinstance(owner, ast.Name) and owner.id == RNG for owner in owners)


def _in_function(node: ast.AST, code: Code) -> bool:
    return any(isinstance(one, ast.FunctionDef | ast.Lambda) for one in around(node, code.tree))
