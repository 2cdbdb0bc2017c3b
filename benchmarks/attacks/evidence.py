"""What a grading run leaves: secrets in what students get to see, and files that changed."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from typing import Any

from robust_slam_autograder.grading.marking import PUBLIC_SEED

from benchmarks.attacks.record import HIDDEN_INPUTS, HIDDEN_TESTS, OWN_READING, TOKEN
from tests.autograder.hostile import leaks
from tests.autograder.hostile.target import Target

_TAG = re.compile(r"<[^>]*>")
TRACEBACK = "Traceback (most recent call last)"
"""After it stands code that the interpreter shows, of the tests too."""
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")


@dataclass(frozen=True)
class Seen:
    """The texts that one student gets."""

    page: str
    """All of it."""
    told: str
    """The part that the submission's own code said."""


@dataclass(frozen=True)
class Secrets:
    """What a batch must not tell."""

    lines: Set[str]
    inputs: Set[str]
    token: str


def secrets(target: Target, seed: int, token: str, *, one_generator: bool) -> Secrets:
    """The secrets of a batch.

    Args:
        target: the assignment.
        seed: the batch's seed.
        token: the one in the grading job's environment.
        one_generator: all cases draw from the set-up's generator, as nbgrader runs them.
    """
    secret, public = (
        set(leaks.numbers(leaks.recorded(target, which, one_generator=one_generator)))
        for which in (seed, PUBLIC_SEED)
    )
    return Secrets(leaks.hidden_lines(target), (secret - public) | {str(seed)}, token)


def found(seen: Seen, secret: Secrets) -> tuple[str, ...]:
    """The names of the secrets that a student got to see."""
    shows = {
        HIDDEN_TESTS: _has(seen.page, secret.lines),
        OWN_READING: _has(seen.told, secret.lines),
        HIDDEN_INPUTS: _has(seen.page, secret.inputs),
        TOKEN: secret.token in seen.page,
    }
    return tuple(name for name, shown in shows.items() if shown)


def _has(text: str, needles: Iterable[str]) -> bool:
    # A text within a representation has its quotes escaped.
    plain = text.replace("\\'", "'").replace('\\"', '"')
    return any(needle in text or needle in plain for needle in needles)


def text_of_page(page: bytes) -> str:
    """What a reader of a page sees: highlighted code is cut up by tags."""
    return html.unescape(_TAG.sub("", page.decode(errors="replace")))


def outputs(notebook: bytes) -> tuple[str, str]:
    """The texts of a graded notebook's outputs: all of them, and those without tracebacks."""
    every, told = [], []
    for output in _outputs(notebook):
        words = " ".join(_strings({k: v for k, v in output.items() if k != "traceback"}))
        told.append(words.partition(TRACEBACK)[0])
        every += [words, "\n".join(_strings(output.get("traceback", [])))]
    return _COLOUR.sub("", "\n".join(every)), _COLOUR.sub("", "\n".join(told))


def _outputs(notebook: bytes) -> Iterator[dict[str, Any]]:
    try:
        cells = json.loads(notebook)["cells"]
    except (ValueError, KeyError, TypeError):
        return
    for cell in cells:
        yield from cell.get("outputs", [])


def _strings(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for part in value:
            yield from _strings(part)
    elif isinstance(value, dict):
        yield from _strings(list(value.values()))


def changes(
    before: Mapping[str, tuple[object, ...]], after: Mapping[str, tuple[object, ...]]
) -> list[str]:
    """Sentences on files that are not as they were; what is new where all may write is no harm."""
    paths = [path for path in sorted({*before, *after}) if before.get(path) != after.get(path)]
    return [f"{path} changed" for path in paths if path in before or not _is_public(path)]


def _is_public(path: str) -> bool:
    return path.startswith("outside/")
