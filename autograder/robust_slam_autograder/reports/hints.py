"""What an exercise's students were told: the same text once per student, the commonest first.

Messages that hold a student's own words are grouped by what they have without these.
"""

import builtins
import functools
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from robust_slam_autograder.grading.results import CaseResult, Ending, ExerciseResult, Words
from robust_slam_autograder.markup import visible

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
    """Return a text's words without case, accents, punctuation and characters that do not show.

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
    students: frozenset[str]

    @functools.cached_property
    def _withheld(self) -> frozenset[str]:
        return frozenset(map(_folded, self.students)) - {""}

    def group(self, case: CaseResult) -> str:
        """Return what a case's message has in common with those that it is counted with."""
        if self.names:
            return case.sentence
        if case.words is not Words.STUDENT:
            return WITHHELD if self._is_named(case.sentence) else case.sentence
        if not case.raised or hasattr(builtins, case.raised):
            return case.sentence
        return f"{case.sentence.removesuffix(f'{case.raised}.')}{UNNAMED}."

    def _is_named(self, text: str) -> bool:
        words = f" {_folded(text)} "
        return any(f" {name} " in words for name in self._withheld)


@dataclass
class _Group:
    first: CaseResult
    students: int = 0
    cases: dict[str, None] = field(default_factory=dict)
    wordings: Counter[str] = field(default_factory=Counter)

    def add(self, told: Iterable[CaseResult]) -> None:
        """Add what one student was told."""
        self.students += 1
        texts = set()
        for case in told:
            self.cases |= {case.name: None} if case.name else {}
            texts.add(case.message if case.words is Words.STUDENT else case.sentence)
        self.wordings.update(texts)

    def as_hint(self, key: str, *, names: bool) -> Hint:
        """Return the group with its commonest text."""
        text, _ = min(self.wordings.items(), key=lambda item: (-item[1], item[0]))
        words = self.first.words
        return Hint(
            text=visible(key),
            students=self.students,
            cases=tuple(map(visible, self.cases)),
            example=visible(text) if names and words is Words.STUDENT else "",
            wordings=len(self.wordings),
            is_of_a_check=words is Words.CHECK and key != WITHHELD,
        )


def collect(exercises: Iterable[ExerciseResult], reader: Reader) -> tuple[Hint, ...]:
    """Count what was told in one exercise, of whose results each student has one."""
    groups: dict[str, _Group] = {}
    key_of = functools.cache(reader.group)  # many students get few texts
    for exercise in exercises:
        mine: dict[str, list[CaseResult]] = {}
        for case in _told(exercise):
            mine.setdefault(key_of(case), []).append(case)
        for key, told in mine.items():
            groups.setdefault(key, _Group(told[0])).add(told)
    hints = (group.as_hint(key, names=reader.names) for key, group in groups.items())
    return tuple(sorted(hints, key=lambda hint: (-hint.students, hint.text)))


def _told(exercise: ExerciseResult) -> Iterator[CaseResult]:
    """Yield failed cases; what stands for the whole exercise comes as a case without a name."""
    failed = [case for case in exercise.cases if not case.passed]
    if exercise.status == "missing":
        failed = []  # its one sentence is enough
    yield from failed
    if exercise.message and exercise.message not in (case.message for case in failed):
        message = exercise.message
        yield CaseResult("", 0, 0, True, Ending.FAILED, message, Words.GRADER)
