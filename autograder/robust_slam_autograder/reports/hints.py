"""What an exercise's students were told: the same text once per student, the commonest first.

A student's own words, which stand in exception texts, are grouped by what was raised.
"""

from __future__ import annotations

import builtins
import functools
import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from robust_slam_autograder.grading.explain import HERE
from robust_slam_autograder.grading.marking import FAULT_SENTENCES, NO_HINT
from robust_slam_autograder.grading.results import ExerciseResult
from robust_slam_autograder.grading.wording import NOT_WRITTEN, UNEXPLAINED
from robust_slam_autograder.markup import visible

_OWN_WORDS = re.compile(
    r"(?P<said>Your function raised |Your cell stops with "
    r"|The check could not use what came back: )"
    r"(?P<raised>\w+)"
    r"|(?P<other>What your function returned cannot be checked"
    r"|A cell of your own ran longer than it may, or ended the process, and is left out)"
)
"""How the grader's sentences begin that go on with a student's words."""
_OF_THE_GRADER = re.compile(
    r"\w+ is not defined in your notebook, or is nothing that can be checked"
)
"""How sentences begin that the grader itself says of a case, beside these."""
_SENTENCES = {NOT_WRITTEN, UNEXPLAINED, NO_HINT, *FAULT_SENTENCES.values()}
UNNAMED = "an exception of the student's own"
WITHHELD = "A text that holds a student's name."


@dataclass(frozen=True)
class Hint:
    """One text, or texts that begin alike and go on with students' own words."""

    text: str
    students: int
    """How many got it; a student who got it in several cases counts once."""
    cases: tuple[str, ...]
    """Where it was said; empty if it stands for the exercise as a whole."""
    example: str
    """With the words of one student, as most put it; empty where they have no words in it."""
    wordings: int
    """How many different texts this stands for."""
    is_of_a_check: bool
    """Whether it is a check's sentence or its hint, and so says what was misunderstood."""


def _folded(text: str) -> str:
    """Words of a text without case, accents, punctuation and characters that do not show.

    So a name is found however it is written: é is one letter, or e with an accent.
    """
    plain = unicodedata.normalize("NFKD", unicodedata.normalize("NFKD", text).casefold())
    kinds = ((letter, unicodedata.category(letter)) for letter in plain)
    # Marks and invisible characters (M, C) stand within a word, punctuation between words.
    kept = (
        letter if kind[0] in "LN" else " "
        for letter, kind in kinds
        if kind[0] not in "MC" or letter.isspace()
    )
    return " ".join("".join(kept).split())


@dataclass(frozen=True)
class Reader:
    """Tells which texts belong together, and what may be shown of them.

    Attributes:
        names: whether students' names and words may be shown.
        students: the names that else must not.
    """

    names: bool
    students: frozenset[str] = frozenset()
    _folded: frozenset[str] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        folded = frozenset(map(_folded, self.students)) - {""}
        object.__setattr__(self, "_folded", folded)

    def _is_named(self, text: str) -> bool:
        words = f" {_folded(text)} "
        return any(f" {name} " in words for name in self._folded)

    def group(self, text: str) -> str:
        """What a text has in common with those that it is counted with."""
        found = _OWN_WORDS.match(text)
        if found is None:
            return text if self.names or not self._is_named(text) else WITHHELD
        if found["other"]:
            return f"{found['other']}."
        known = self.names or hasattr(builtins, found["raised"])
        return f"{found['said']}{found['raised'] if known else UNNAMED}."

    def may_quote(self, text: str) -> bool:
        """Whether the text is an example of students' words, and may be shown."""
        return self.names and _OWN_WORDS.match(text) is not None


@dataclass
class _Group:
    students: int = 0
    cases: dict[str, None] = field(default_factory=dict)
    wordings: Counter[str] = field(default_factory=Counter)

    def add(self, told: Sequence[tuple[str, str]]) -> None:
        """Add what one student was told, as pairs of case and text."""
        self.students += 1
        self.cases.update((case, None) for case, _ in told if case)
        self.wordings.update({text for _, text in told})


def collect(exercises: Iterable[ExerciseResult], reader: Reader) -> tuple[Hint, ...]:
    """Count what was told.

    Args:
        exercises: one exercise's results, one per student.
        reader: tells which texts belong together.
    """
    groups: dict[str, _Group] = {}
    keys = functools.cache(reader.group)  # many students get few texts
    for exercise in exercises:
        mine: dict[str, list[tuple[str, str]]] = {}
        for case, text in _told(exercise):
            mine.setdefault(keys(text), []).append((case, text))
        for key, told in mine.items():
            groups.setdefault(key, _Group()).add(told)
    hints = (_hint(key, group, reader) for key, group in groups.items())
    return tuple(sorted(hints, key=lambda hint: (-hint.students, hint.text)))


def _told(exercise: ExerciseResult) -> Iterator[tuple[str, str]]:
    """Pairs of case and text; a missing cell is said once, not by each case that needs it."""
    if exercise.status == "missing":
        yield "", exercise.message
        return
    told = [(case.name, _said(case.message)) for case in exercise.cases if case.message]
    yield from told
    if exercise.message and _said(exercise.message) not in (text for _, text in told):
        yield "", _said(exercise.message)


def _said(message: str) -> str:
    """A check's own sentence, without the line below it that says what the student returned."""
    return message if _OWN_WORDS.match(message) else message.partition(f"\n{HERE}")[0]


def _is_of_the_grader(text: str) -> bool:
    """Whether no check says this: nothing was written, or nothing could be checked."""
    is_own = _OWN_WORDS.match(text) or _OF_THE_GRADER.match(text)
    return bool(is_own) or text in _SENTENCES


def _hint(key: str, group: _Group, reader: Reader) -> Hint:
    text, _ = min(group.wordings.items(), key=lambda item: (-item[1], item[0]))
    return Hint(
        text=visible(key),
        students=group.students,
        cases=tuple(map(visible, group.cases)),
        example=visible(text) if reader.may_quote(text) else "",
        wordings=len(group.wordings),
        is_of_a_check=bool(group.cases) and key != WITHHELD and not _is_of_the_grader(text),
    )
