"""What a class's wrong answers look like: one label and who has it, or no label and one answer."""

import statistics
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from robust_slam_autograder.grading.results import ExerciseResult, Result

FEWEST_ALIKE = 2
"""Students who return the same, from whom on an answer without a label is worth a look."""
FEWEST_CORRELATED = 10
"""Students from whom on it is said how well a case tells good submissions from weak ones."""

Code = Callable[[str, str], str]
"""A student's text for an exercise; empty where it is not known."""


@dataclass(frozen=True)
class Misconception:
    """One label."""

    exercise: str
    sentence: str
    """Goes on after "It looks as if"."""
    students: int
    of: int


@dataclass(frozen=True)
class Unlabelled:
    """Wrong answers that return the same, and that have no label."""

    exercise: str
    students: int
    code: str
    """One of them; empty where it is not known."""


def misconceptions(results: Sequence[Result]) -> list[tuple[Misconception, list[Result]]]:
    """Return the labels of a class, the commonest first, each with the results that have it."""
    groups = _grouped(results, lambda exercise: exercise.misconception)
    return [(Misconception(*key, len(mine), len(results)), mine) for key, mine in groups]


def unlabelled(results: Sequence[Result], code: Code) -> list[tuple[Unlabelled, list[Result]]]:
    """Return groups of wrong answers without a label, the largest first, each with its results."""
    groups = _grouped(results, lambda one: "" if one.misconception else one.pattern)
    return [
        (Unlabelled(name, len(mine), code(mine[0].student, name)), mine)
        for (name, _), mine in groups
        if len(mine) >= FEWEST_ALIKE
    ]


def _grouped(
    results: Sequence[Result], sign: Callable[[ExerciseResult], str]
) -> list[tuple[tuple[str, str], list[Result]]]:
    """Return by exercise and sign the results that have this sign, the most frequent first."""
    groups: dict[tuple[str, str], list[Result]] = defaultdict(list)
    for result in results:
        for exercise in result.exercises:
            if sign(exercise):
                groups[exercise.name, sign(exercise)].append(result)
    return sorted(groups.items(), key=lambda group: -len(group[1]))


def discrimination(
    mine: Sequence[ExerciseResult], which: int, whole: Sequence[float]
) -> float | None:
    """Return how well a case tells good submissions from weak ones, from -1 to 1.

    It is the point-biserial correlation of passing the case with all other points; None where
    too few students say something, or all of them the same. Of each submission ``mine`` has the
    exercise, and ``whole`` the points.
    """
    passed = [float(exercise.cases[which].passed) for exercise in mine]
    earned = [exercise.cases[which].earned for exercise in mine]
    rest = [score - own for score, own in zip(whole, earned, strict=True)]
    if len(mine) < FEWEST_CORRELATED or len(set(passed)) < 2 or len(set(rest)) < 2:
        return None
    return statistics.correlation(passed, rest)
