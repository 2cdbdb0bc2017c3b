"""What nobody may learn: hidden lines, hidden inputs, the seed, a token; and where it shows."""

import ast
import contextlib
import html
import json
import os
import re
import sqlite3
import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
from robust_slam_autograder.executor.seeds import PUBLIC_SEED, SEED_VARIABLE, case_generator
from robust_slam_autograder.reading.assignment import split_hidden
from robust_slam_autograder.reading.source import plain_python

from .target import Target

DIGITS = 8
"""So many first digits of a number tell it from any other."""
_FIRST_DIGITS = re.compile(rf"[0.]*\d(?:\.?\d){{{DIGITS - 1}}}")
TELLING_LENGTH = 16
PRIVATE = {".run.json", ".lock"}
"""Files of a batch that are the instructor's alone."""
GRADEBOOK = "gradebook.db"
"""nbgrader keeps the source of test cells in it; of it students see the comments."""
HIDDEN_LINE = "a line of a hidden test"


def secrets(target: Target, *seeds: int) -> dict[str, str]:
    """Texts that must not show anywhere, each with what it is."""
    return dict.fromkeys(hidden_lines(target), HIDDEN_LINE) | {str(one): "a seed" for one in seeds}


def drawn(target: Target, seed: int) -> set[str]:
    """The long numbers that cross in a hidden pass alone."""
    return {*numbers(recorded(target, seed))} - {*numbers(recorded(target, PUBLIC_SEED))}


def hidden_lines(target: Target) -> set[str]:
    """Telling lines of hidden tests that stand nowhere in the release; hints are no secret."""
    texts = ["".join(cell["source"]) for cell in target.released["cells"]]
    shown = {line.strip() for text in texts for line in text.split("\n")}
    hidden: set[str] = set()
    for case in target.assignment.cases:
        _, text = split_hidden(case.full, case.grade_id)
        hidden |= {line.strip() for line in text.split("\n") if "# hint:" not in line}
    return {line for line in hidden - shown if len(line) >= TELLING_LENGTH}


def recorded(target: Target, seed: int) -> list[Any]:
    """What crosses when the right answers are graded: arguments and results of every call."""
    said: list[Any] = []
    module = types.ModuleType("recorded")
    names = module.__dict__
    with mock.patch.dict(os.environ, {SEED_VARIABLE: str(seed)}):
        for piece in target.assignment.setup:
            if not piece.own:  # others are scratch: pictures of what a function does
                _execute(piece.source, names)
        for solution in target.assignment.solutions:
            _execute(target.answers[solution.grade_id], names)
            for name in solution.names:
                if callable(names[name]):
                    names[name] = _recording(names[name], said)
        for case in target.assignment.cases:
            names["rng"] = case_generator(seed, case.grade_id)
            _execute(case.full, names)
    return said


def _execute(source: str, names: dict[str, Any]) -> None:
    text = plain_python(source)
    exec(compile(ast.parse(text), "<recorded>", "exec", dont_inherit=True), names)


def _recording(function: Callable[..., Any], said: list[Any]) -> Callable[..., Any]:
    def record(*args: Any, **kwargs: Any) -> Any:
        said.extend([*args, *kwargs.values()])
        answer = function(*args, **kwargs)
        said.append(answer)
        return answer

    return record


def numbers(value: Any) -> Iterator[str]:
    """The first digits of every long number in what was recorded, as a text would show them."""
    if isinstance(value, list | tuple):
        for part in value:
            yield from numbers(part)
    elif isinstance(value, dict):
        yield from numbers(list(value.values()))
    elif isinstance(value, np.ndarray):
        yield from numbers(value.ravel().tolist())
    elif isinstance(value, float | np.floating):
        digits = _FIRST_DIGITS.match(repr(abs(float(value))))
        yield from [digits[0]] if digits else []


def places(folder: Path, said: Iterable[str] = ()) -> dict[str, bytes]:
    """Return what students and the public may see: a folder's files, and what commands said."""
    files = [path for path in sorted(folder.rglob("*")) if path.is_file()]
    public = [path for path in files if path.name not in PRIVATE]
    found = {str(path.relative_to(folder)): path.read_bytes() for path in public}
    found |= {f"output {n}": text.encode() for n, text in enumerate(said)}
    return found | {"the gradebook's comments": _comments(folder / GRADEBOOK)}


def shown(places: Mapping[str, bytes], texts: Mapping[str, str]) -> list[str]:
    """Which secrets show there, of texts with what they are."""
    # In a page < stands as &lt;, in JSON a quote as \".
    spellings = (str, html.escape, lambda text: json.dumps(text)[1:-1])
    wanted = [({spell(text).encode() for spell in spellings}, text) for text in texts]
    return [
        f"{texts[text]} in {place}: {text}"
        for place, data in places.items()
        for needles, text in wanted
        if any(needle in data for needle in needles)
        and (place, texts[text]) != (GRADEBOOK, HIDDEN_LINE)
    ]


def numbers_shown(places: Mapping[str, bytes], drawn: Iterable[set[str]]) -> list[str]:
    """Which long numbers show there, of sets that are looked at one by one."""
    there: dict[str, str] = {}
    for place, data in places.items():
        there |= dict.fromkeys(_FIRST_DIGITS.findall(data.decode(errors="replace")), place)
    return [f"a hidden number in {there[n]}: {n}" for some in drawn for n in some & there.keys()]


def _comments(database: Path) -> bytes:
    if not database.is_file():
        return b""
    with contextlib.closing(sqlite3.connect(database)) as connection:
        rows = connection.execute("select auto_comment, manual_comment from comment").fetchall()
    return "\n".join(str(part) for row in rows for part in row).encode()
