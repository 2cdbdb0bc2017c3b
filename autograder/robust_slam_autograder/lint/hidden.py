"""Hidden regions: their place, and their hints."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Code, Found, Subject
from robust_slam_autograder.reading.assignment import END_HIDDEN

_HINT = re.compile(r"\s*#\s*hint:\s*\S")
_CODE = (ast.Call, ast.BinOp, ast.Compare, ast.Subscript, ast.List, ast.Tuple, ast.Lambda)
_TELLING_LENGTH = 9
"""Code of fewer letters, such as u**2, may stand in a hint by chance."""
_TELLING_DIGITS = 4


@rule("region-place", "error", "A case ends with at most one hidden region.")
def _region_place(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        end, lines = code.regions[-1].stop, code.source.split("\n")
        fix = "visible asserts first, then one hidden region, to the cell's end."
        if len(code.regions) > 1:
            line = code.regions[1].start - 1
            yield Found(code.grade_id, line, f"There is a second hidden region: {fix}")
        elif any(line.strip() and END_HIDDEN not in line for line in lines[end - 1 :]):
            yield Found(code.grade_id, end + 1, f"Code follows the hidden region: {fix}")


@rule("no-hint", "error", "A hidden region begins with its hint.")
def _no_hint(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        lines = code.source.split("\n")
        hints = [line for line in code.regions[0] if _HINT.match(lines[line - 1])]
        first = code.regions[0].start
        if not hints:
            yield Found(
                code.grade_id, first, "The hidden region has no hint: # hint: one sentence."
            )
        elif first not in hints:
            yield Found(
                code.grade_id,
                hints[0],
                "The hint must be the region's first line, or no student sees it.",
            )


@rule("hint-quotes", "error", "A hint must not quote hidden code.")
def _hint_quotes(subject: Subject) -> Iterator[Found]:
    for code in subject.with_regions:
        quoted = sorted(_quoted(code), key=len)
        if quoted:
            yield Found(
                code.grade_id,
                code.regions[0].start,
                f"The hint quotes the hidden check ({quoted[-1]}): say it in words.",
            )


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
