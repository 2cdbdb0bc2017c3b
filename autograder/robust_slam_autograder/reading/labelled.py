"""Reads right and wrong answers to an exercise, to try its tests on.

They are in ``<assignment>/<exercise>.toml``, as the grader's README says under *Lint*. Changes are
made in their order. A text of several lines is indented like the line in which it begins; in the
file it may be indented as one likes, with line breaks around it.
"""

import re
import textwrap
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

_OF_RIGHT = frozenset({"idea"})
_OF_WRONG = frozenset({"misconception", "caught_by", "stopped_by"})
_TEXTS = frozenset({"code", "from"})


def files(folder: Path) -> list[Path]:
    """List an assignment's files of answers; beside them are mutants that were judged."""
    return [path for path in sorted(folder.glob("*.toml")) if path.name != "equivalents.toml"]


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
    """Grade id of the case that a wrong answer fails."""
    is_visible: bool = False
    """Whether a visible check stops it, not only a hidden one."""

    @property
    def label(self) -> str:
        """Return its misconception as what goes on after "It looks as if"."""
        return f"your function {self.story[:1].lower()}{self.story[1:].rstrip('.')}"

    @property
    def is_right(self) -> bool:
        """Return whether it must get full marks."""
        return self.name.startswith("right_")


def read(path: Path) -> list[Answer]:
    """Return the answers in a file, in its order.

    Raises:
        ValueError: the file is no TOML, or an answer is not written as this module says; the
            message names the file and the answer.
    """
    found: dict[str, Answer] = {}
    where = f"{path}"
    try:
        for name, table in tomllib.loads(path.read_text(encoding="utf-8")).items():
            where = f"{path}: {name}"
            found[name] = _answer(path.stem, name, table, found)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from None
    return list(found.values())


def _answer(exercise: str, name: str, table: object, above: Mapping[str, Answer]) -> Answer:
    if not name.startswith(("right_", "wrong_")) or not isinstance(table, dict):
        raise ValueError("an answer is a table with the name right_… or wrong_…")
    own = _OF_RIGHT if name.startswith("right_") else _OF_WRONG
    texts = {key: value for key, value in table.items() if key != "changes"}
    unknown = sorted(texts.keys() - own - _TEXTS)
    if unknown:
        raise ValueError(f"unknown key {unknown[0]}: it takes {', '.join(sorted(own | _TEXTS))}")
    if not all(isinstance(value, str) and value.strip() for value in texts.values()):
        raise ValueError("every value but changes is a text that is not empty")
    cases = [table[key] for key in ("caught_by", "stopped_by") if key in table]
    if own is _OF_WRONG and len(cases) != 1:
        raise ValueError("a wrong answer names one case, caught_by or stopped_by")
    return Answer(
        exercise,
        name,
        _source(table, above),
        " ".join(str(table.get("idea") or table.get("misconception", "")).split()),
        caught_by=cases[0] if cases else None,
        is_visible="stopped_by" in table,
    )


def _source(table: Mapping[str, Any], above: Mapping[str, Answer]) -> str:
    match table:
        case {"code": str(code), **rest} if not rest.keys() & {"from", "changes"}:
            return code
        case {"from": str(name), "changes": [*changes], **rest} if "code" not in rest:
            if name not in above:
                raise ValueError(f"there is no answer {name} above it")
            source = above[name].source
            for change in changes:
                match change:
                    case [str(old), str(new)]:
                        source = replaced(source, old, new)
                    case _:
                        raise ValueError(f"a change is a pair [old, new], not {change!r}")
            return source
    raise ValueError("it holds either code, or from and changes = [[old, new], …]")


def replaced(source: str, old: str, new: str) -> str:
    """Return the source with the one place where the old text stands changed to the new one.

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
    return textwrap.dedent(text).strip("\n") if "\n" in text else text


def _places(source: str, old: str) -> Iterator[tuple[int, int, str]]:
    """Start and end of each occurrence, and how the line is indented in which it starts."""
    first, _, _ = old.partition("\n")
    for start in (at.start() for at in re.finditer(f"(?={re.escape(first)})", source) if old):
        line = source[source.rfind("\n", 0, start) + 1 :]
        indent = line[: len(line) - len(line.lstrip(" "))]
        if source.startswith(sought := _below(old, indent), start):
            yield start, start + len(sought), indent


def _below(text: str, indent: str) -> str:
    return textwrap.indent(text, indent)[len(indent) :] if text.strip() else text
