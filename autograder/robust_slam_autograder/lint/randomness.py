"""Where inputs come from: `rng`, drawn in cases, and nothing else."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from robust_slam_autograder.lint.nodes import walk
from robust_slam_autograder.lint.rule import Found, Rule
from robust_slam_autograder.lint.subject import Code, Subject

RNG = "rng"
_MAKERS = frozenset({"default_rng", "RandomState", "Random", "Generator", "SeedSequence"})
_UNSEEDED = ("secrets.", "uuid.", "time.time", "os.urandom", "random.SystemRandom")


def _no_rng(subject: Subject) -> Iterator[Found]:
    """Hidden regions with inputs that never change."""
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


def _other_random(subject: Subject) -> Iterator[Found]:
    """Draws that do not follow from the batch's seed."""
    for code in subject.codes:
        for node, name in subject.calls(code):
            if _is_other(node, name):
                yield Found(
                    code.grade_id,
                    node.lineno,
                    f"{ast.unparse(node.func)} does not follow from the batch's seed, so a mark "
                    "may change from run to run: draw from rng.",
                )


def _is_other(node: ast.Call, name: str) -> bool:
    module, _, function = name.rpartition(".")
    if module in ("numpy.random", "random"):
        return function not in _MAKERS or not (node.args or node.keywords)
    return name.startswith(_UNSEEDED)


def _setup_draws(subject: Subject) -> Iterator[Found]:
    """A set-up cell that draws: it runs on both sides, and the student's has another seed."""
    for code in subject.setup:
        for node in walk(code.tree):
            if isinstance(node, ast.Call) and _uses_rng(node) and not _in_function(node, code):
                yield Found(
                    code.grade_id,
                    node.lineno,
                    "The set-up draws from rng, and the student's side has another seed: "
                    "draw in the cases.",
                )


def _uses_rng(node: ast.Call) -> bool:
    parts = [node.func, *node.args, *(keyword.value for keyword in node.keywords)]
    owners = [part.value if isinstance(part, ast.Attribute) else part for part in parts]
    return any(isinstance(owner, ast.Name) and owner.id == RNG for owner in owners)


def _in_function(node: ast.AST, code: Code) -> bool:
    return any(isinstance(one, ast.FunctionDef | ast.Lambda) for one in code.flow.around(node))


RULES = (
    Rule("no-rng", "warning", "A hidden region draws its inputs from rng.", _no_rng),
    Rule(
        "other-random",
        "error",
        "All that is random follows from rng.",
        _other_random,
    ),
    Rule("setup-draws", "error", "A set-up cell must not draw.", _setup_draws),
)
