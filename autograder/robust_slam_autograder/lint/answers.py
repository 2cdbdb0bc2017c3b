"""Right and wrong answers to an exercise, to try its tests on.

A file ``<assignment>/<exercise>.py`` holds functions ``right_…`` and ``wrong_…``. The body of
each, below its docstring, is the text of the cell that a student hands in. The docstring of a
wrong answer tells the misconception and ends with the case that it fails: "Caught by
<grade id>." for a hidden check, "Stopped by the visible case <grade id>." for a visible one.

An answer that differs from a right one in a few places is written as a change to it, with its
story below (see ``change``). The files are read and never run.
"""

from __future__ import annotations

import ast
import re
import textwrap
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

_CAUGHT = re.compile(r"\s*(Caught by|Stopped by the visible case) ([\w-]+)\.")


def change(
    right: Callable[..., object],
    *texts: str | tuple[str, str],
    caught_by: str = "",
    stopped_by: str = "",
) -> None:
    '''Declare an answer: a right one with other text in one or more places.

    ``read`` evaluates the declaration; called, it does nothing::

        wrong_knee = change(right_formula, "2 * u**2", "u**2", stopped_by="start_mu-by-hand")
        """Wrong: puts the upper knee at u itself."""

    Args:
        right: the answer of the same file that it changes.
        texts: the old text and the new one, or a pair ``(old, new)`` for each place, changed in
            this order. The old text must occur exactly once. Where a text has several lines, they
            are indented like the line in which it begins; one that starts with a line break is
            dedented first.
        caught_by: grade id of the case whose hidden check catches it, if it is wrong.
        stopped_by: grade id of the case whose visible check stops it, if it is wrong.
    '''


@dataclass(frozen=True)
class Answer:
    """One answer to one exercise."""

    exercise: str
    name: str
    """``right_…`` or ``wrong_…``."""
    source: str
    """The text of the cell."""
    story: str
    """What is particular to it: for a wrong one the misconception."""
    caught_by: str | None = None
    """Grade id of the case that a wrong answer says it fails."""
    is_visible: bool = False
    """Whether a visible check stops it, not only a hidden one."""

    @property
    def is_right(self) -> bool:
        """Whether it must get full marks."""
        return self.name.startswith("right_")


def read(path: Path) -> list[Answer]:
    """The answers in a file, in its order.

    Raises:
        ValueError: a change is not written as ``change`` says, or its old text does not occur
            exactly once.
        SyntaxError: the file is not Python.
    """
    text = path.read_text(encoding="utf-8")
    nodes = ast.parse(text).body
    found: dict[str, Answer] = {}
    for node, below in zip(nodes, [*nodes[1:], None], strict=True):
        if isinstance(node, ast.FunctionDef) and _is_answer(node.name):
            found[node.name] = _written(path.stem, text, node)
        elif isinstance(node, ast.Assign) and _is_answer(name := ast.unparse(node.targets[0])):
            try:
                found[name] = _changed(name, node.value, _string(below), found)
            except ValueError as error:
                raise ValueError(f"{path}:{node.lineno}: {name}: {error}") from None
    return list(found.values())


def _is_answer(name: str) -> bool:
    return name.startswith(("right_", "wrong_"))


def _written(exercise: str, text: str, node: ast.FunctionDef) -> Answer:
    story = " ".join((ast.get_docstring(node) or "").split())
    caught = _CAUGHT.search(story)
    return Answer(
        exercise,
        node.name,
        _body(text, node),
        _CAUGHT.sub("", story),
        caught_by=caught.group(2) if caught else None,
        is_visible=bool(caught and caught.group(1).startswith("Stopped")),
    )


def _body(text: str, node: ast.FunctionDef) -> str:
    body = node.body[1:] if ast.get_docstring(node) is not None else node.body
    if not body:
        return ""
    first = min(part.lineno for part in (body[0], *getattr(body[0], "decorator_list", [])))
    return textwrap.dedent("\n".join(text.split("\n")[first - 1 : node.end_lineno])) + "\n"


def _changed(name: str, call: ast.expr, story: str, known: Mapping[str, Answer]) -> Answer:
    if not (isinstance(call, ast.Call) and ast.unparse(call.func) == "change" and call.args):
        raise ValueError("an answer is a function, or change(right, old, new, …)")
    right = known.get(ast.unparse(call.args[0]))
    if right is None:
        raise ValueError(f"there is no answer {ast.unparse(call.args[0])} above it")
    source = right.source
    for old, new in _pairs([ast.literal_eval(text) for text in call.args[1:]]):
        source = replaced(source, old, new)
    cases = {word.arg: ast.literal_eval(word.value) for word in call.keywords}
    changed = Answer(right.exercise, name, source, story)
    if changed.is_right and not cases:
        return changed
    if changed.is_right or len(cases) != 1 or not cases.keys() <= {"caught_by", "stopped_by"}:
        raise ValueError("a wrong one names one case, caught_by or stopped_by; a right one none")
    (case,) = cases.values()
    return replace(changed, caught_by=case, is_visible="stopped_by" in cases)


def _string(node: ast.stmt | None) -> str:
    value = node.value if isinstance(node, ast.Expr) else None
    return " ".join(str(value.value).split()) if isinstance(value, ast.Constant) else ""


def _pairs(texts: list[str | tuple[str, str]]) -> list[tuple[str, str]]:
    match texts:
        case [str(old), str(new)]:
            return [(old, new)]
        case [(str(), str()), *_]:
            pairs = [text for text in texts if isinstance(text, tuple) and len(text) == 2]
            if len(pairs) == len(texts):
                return pairs
    raise ValueError("it takes an old text and a new one, or pairs (old, new)")


def replaced(source: str, old: str, new: str) -> str:
    """The source with the one place where the old text stands changed to the new one.

    Raises:
        ValueError: the old text does not occur exactly once.
    """
    old, new = _dedented(old), _dedented(new)
    places = list(_places(source, old))
    if len(places) != 1:
        raise ValueError(f"occurs {len(places)} times, not once: {old!r}")
    start, end, indent = places[0]
    return source[:start] + _below(new, indent) + source[end:]


def _dedented(text: str) -> str:
    return textwrap.dedent(text).strip("\n") if text.startswith("\n") else text


def _places(source: str, old: str) -> Iterator[tuple[int, int, str]]:
    """Start and end of each occurrence, and how the line is indented in which it starts."""
    first = 0
    for line in source.splitlines(keepends=True):
        indent = line[: len(line) - len(line.lstrip(" "))]
        sought = _below(old, indent)
        start = source.find(sought, first) if old else -1
        while first <= start < first + len(line):
            yield start, start + len(sought), indent
            start = source.find(sought, start + 1)
        first += len(line)


def _below(text: str, indent: str) -> str:
    return textwrap.indent(text, indent)[len(indent) :] if text.strip() else text
