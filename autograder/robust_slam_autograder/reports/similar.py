"""Answers of two students that are nearly one text, for an instructor who reads both.

What is compared are the texts of one exercise, without comments, with every name of a variable
alike, and without what the release gives. The measure is copydetect's, the share of the runs of
letters that two texts have in common (Schleimer, Wilkerson, Aiken: Winnowing, SIGMOD 2003);
with a window of 1 no run is left out, so that the same class gives the same pairs each time.
"""

import io
import itertools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from robust_slam_autograder.markup import visible

RUN = 25
"""Letters of a run; shorter ones are in every program."""
LEAST_SHARE = 0.8
"""Of both texts, what they have in common at least."""
LEAST_LETTERS = 60
"""Of these in common at least: one line of arithmetic looks alike in all right answers."""
MOST_LETTERS = 20_000
"""Of an answer that is compared."""
COMMON = 0.2
"""Where more of a class than this write one text, there may be one way to write it."""
FEWEST = 4
"""Students that always count as few enough to be looked at."""


@dataclass(frozen=True)
class Pair:
    """Two answers to one exercise."""

    exercise: str
    students: tuple[str, str]
    share: float
    """Of the text that has the smaller share in common."""
    texts: tuple[str, str]


@dataclass(frozen=True)
class Two:
    """Two students, and their answers that are alike."""

    students: tuple[str, str]
    pairs: tuple[Pair, ...]
    """In the order of the notebook."""


@dataclass(frozen=True)
class Alike:
    """What is to be read side by side in one assignment."""

    two: tuple[Two, ...]
    """Those with most exercises first, and of these who is most alike."""
    common: tuple[tuple[str, int], ...]
    """Exercises that many wrote in one way, with how many: no pair of theirs is shown."""


def find(answers: Mapping[str, Mapping[str, str]], released: Mapping[str, str]) -> Alike:
    """Find answers that are nearly one text, beside what students begin with.

    Answers come by exercise and student, and what is released by exercise.
    """
    pairs: list[Pair] = []
    common: list[tuple[str, int]] = []
    for exercise, texts in answers.items():
        found = list(_pairs(exercise, texts, released.get(exercise, "")))
        most = max(FEWEST, COMMON * len(texts))
        for group in _groups(found):
            if len(group) > most:
                common.append((visible(exercise), len(group)))
            else:
                pairs += [pair for pair in found if pair.students[0] in group]
    by_students: dict[tuple[str, str], list[Pair]] = {}
    for pair in pairs:
        by_students.setdefault(pair.students, []).append(pair)
    two = [Two(students, tuple(theirs)) for students, theirs in by_students.items()]
    two.sort(key=lambda one: (-len(one.pairs), -sum(pair.share for pair in one.pairs)))
    return Alike(tuple(two), tuple(common))


def _pairs(exercise: str, texts: Mapping[str, str], released: str) -> Iterator[Pair]:
    from copydetect import compare_files  # with matplotlib, which takes its time to import

    given = _printed(released)
    prints = {
        student: _printed(text, given.hashes)
        for student, text in sorted(texts.items())
        if len(text) <= MOST_LETTERS
    }
    for (first, one), (second, other) in itertools.combinations(prints.items(), 2):
        letters, shares, _ = compare_files(one, other)
        if letters >= LEAST_LETTERS and min(shares) >= LEAST_SHARE:
            sources = visible(texts[first]), visible(texts[second])
            yield Pair(visible(exercise), (first, second), min(1.0, float(min(shares))), sources)


def _printed(text: str, given: frozenset[int] | set[int] = frozenset()) -> Any:  # noqa: ANN401
    from copydetect import CodeFingerprint

    return CodeFingerprint("answer.py", RUN, 1, boilerplate=[*given], fp=io.StringIO(text))


def _groups(pairs: list[Pair]) -> list[set[str]]:
    """Return students who are joined by pairs, each in one group."""
    groups: list[set[str]] = []
    for pair in pairs:
        mine = [group for group in groups if group & set(pair.students)]
        groups = [group for group in groups if group not in mine]
        groups.append(set(pair.students).union(*mine))
    return groups
