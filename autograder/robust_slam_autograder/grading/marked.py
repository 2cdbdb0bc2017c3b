"""What a pass over a submission came to, and how it travels to the next one."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass

from robust_slam_autograder.grading import results
from robust_slam_autograder.grading.results import Result


@dataclass(frozen=True)
class Marked:
    """A result as far as it is known, and what the hidden pass has to know of the visible one."""

    result: Result
    doubtful: bool = False
    """Whether it ran into a limit for which a busy machine may be to blame."""
    seconds: float = 0.0
    """How much of the whole submission's limit is used up."""
    skip: tuple[int, ...] = ()
    """Cells of the student's that hung or died, by their number in the program."""

    @property
    def is_whole(self) -> bool:
        """Tell whether no hidden check could change it."""
        cases = (case for exercise in self.result.exercises for case in exercise.cases)
        return self.result.status != "graded" or not any(case.passed for case in cases)


def as_text(marked: Marked) -> str:
    """Write it down; the result as its file has it."""
    return json.dumps({**asdict(marked), "result": results.as_text(marked.result)})


def from_text(text: str) -> Marked:
    """Read back what ``as_text`` gave.

    Raises:
        ValueError: it is anything else.
    """
    try:
        value = json.loads(text)
        result = results.from_text(value.pop("result"))
        marked: Marked = results.made(Marked, value, result=result)
    except (RecursionError, OverflowError, KeyError, TypeError, AttributeError) as error:
        raise ValueError("no pass of a grader wrote it") from error
    return marked
