"""What people gave and took beside the tests, and the marks that follow.

Where it is kept is the gradebook's matter, ``nbgrader/by_hand.py``.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from robust_slam_autograder.grading.results import Result, tidy


@dataclass(frozen=True)
class Entry:
    """What a person gave or took."""

    name: str
    """An exercise, or the grade id of a cell that no test marks."""
    points: float
    """Beside those of the tests."""
    words: str = ""
    """The reason, and what else the person wrote there."""
    max_score: float = 0
    """What a person alone can give here; 0 for an exercise, whose points are the tests'."""
    waits: bool = False
    """Whether no one has marked it yet."""


Entries = tuple[Entry, ...]


@dataclass(frozen=True)
class Entered:
    """All that people entered in one assignment."""

    students: Mapping[str, Entries] = field(default_factory=dict)
    blank: Entries = ()
    """What stands for a student whom the gradebook does not have: what waits for a person."""

    def of(self, student: str) -> Entries:
        """Return one student's, in the order of the notebook."""
        return self.students.get(student, self.blank)


def with_marks(result: Result, entries: Entries) -> Result:
    """Return a result with the points that count: what people gave and took is added.

    Its cases stay as the tests found them. What the grader failed on has no mark at all.
    """
    if result.status == "failed":
        return result
    given = {entry.name: entry.points for entry in entries}
    exercises = tuple(
        replace(each, score=tidy(each.score + given.get(each.name, 0)))
        for each in result.exercises
    )
    return replace(
        result,
        exercises=exercises,
        score=tidy(result.score + sum(entry.points for entry in entries)),
        max_score=tidy(result.max_score + sum(entry.max_score for entry in entries)),
    )
