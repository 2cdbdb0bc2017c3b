"""Hidden regions: their place, their hints, and their inputs, which come from `rng` alone."""

import ast
import re
from collections.abc import Iterator

from robust_slam_autograder.lint.rule import code_rule, rule
from robust_slam_autograder.lint.subject import Code, Found, Subject
from robust_slam_autograder.reading.assignment import END_HIDDEN

_HINT = re.compile(r"\s*#\s*hint:\s*\S")
_CODE = (ast.Call, ast.BinOp, ast.Compare, ast.Subscript, ast.List, ast.Tuple, ast.Lambda)
_TELLING_LENGTH = 9
"""Code of fewer letters, such as u**2, may stand in a hint by chance."""
_TELLING_DIGITS = 4
RNG = "rng"
_MAKERS = frozenset({"default_rng", "RandomState", "Random", "Generator", "SeedSequence"})
_UNSEEDED = ("secrets.", "uuid.", "time.time", "os.urandom", "random.SystemRandom")


@rule("region-place", "error", "A case ends with at most one hidden region.")
def _region_place(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        end, lines = code.regions[-1].stop, code.source.split("\n")
        fix = "visible asserts first, then one hidden region, to the cell's end."
        if len(code.regions) > 1:
            line = code.regions[1].start - 1
            yield Found(code.grade_id, f"There is a second hidden region: {fix}", line)
        elif any(line.strip() and END_HIDDEN not in line for line in lines[end - 1 :]):
            yield Found(code.grade_id, f"Code follows the hidden region: {fix}", end + 1)


@rule("no-hint", "error", "A hidden region begins with its hint.")
def _no_hint(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        lines = code.source.split("\n")
        hints = [line for line in code.regions[0] if _HINT.match(lines[line - 1])]
        first = code.regions[0].start
        if not hints:
            said = "The hidden region has no hint: # hint: one sentence."
            yield Found(code.grade_id, said, first)
        elif first not in hints:
            said = "The hint must be the region's first line, or no student sees it."
            yield Found(code.grade_id, said, hints[0])


@rule("hint-quotes", "error", "A hint must not quote hidden code.")
def _hint_quotes(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        quoted = sorted(_quoted(code), key=len)
        if quoted:
            said = f"The hint quotes the hidden check ({quoted[-1]}): say it in words."
            yield Found(code.grade_id, said, code.regions[0].start)


def _quoted(code: Code) -> Iterator[str]:
    """What of the hidden code alone stands in the hint."""
    hint, visible = (_dense(code.case.hint), _dense(code.case.visible)) if code.case else ("", "")
    for node in code.nodes:
        if code.is_hidden(node) and _is_telling(node):
            text = ast.unparse(node)
            if _dense(text) in hint and _dense(text) not in visible:
                yield text


def _is_telling(node: ast.AST) -> bool:
    """Whether a piece of code says more than a hint may have in common with it by chance."""
    match node:
        case ast.Name(id=name):
            return "_" in name.strip("_")
        case ast.Constant(value=int() | float() as number):
            return sum(map(str.isdigit, str(number))) >= _TELLING_DIGITS
    return isinstance(node, _CODE) and len(_dense(ast.unparse(node))) >= _TELLING_LENGTH


def _dense(text: str) -> str:
    return re.sub(r"\s", "", text)


@rule("no-rng", "warning", "A hidden region draws its inputs from rng.")
def _no_rng(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        hidden = (node for node in code.nodes if code.is_hidden(node))
        if not any(map(_is_rng, hidden)):
            said = "The hidden inputs are the same for ever, and can be learnt"
            yield Found(code.grade_id, f"{said}: draw them from rng.", code.regions[0].start)


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
                said = "The student's side draws other numbers from rng here: draw in the cases."
                yield code.found(node, said)


def _at_once(node: ast.AST) -> Iterator[ast.AST]:
    """The code below that runs with its cell, and not when a function is called."""
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.FunctionDef | ast.Lambda):
            yield child
            yield from _at_once(child)


def _uses_rng(node: ast.Call) -> bool:
    parts = [node.func, *node.args, *(keyword.value for keyword in node.keywords)]
    return any(_is_rng(getattr(part, "value", part)) for part in parts)
