"""Finds out once how answers can be wrong, and under which keys that can be told.

Ways to be wrong are the answers that an author wrote down, and the solution's own results with a
change that many slips come to. The grader's own pass runs them, so a key here is one there.
Nothing here is a wall: it is the instructor's code that runs.
"""

import contextlib
from collections import defaultdict, deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from robust_slam_autograder.executor import guarded
from robust_slam_autograder.executor.guarded import Overrun
from robust_slam_autograder.grading.passes import Pass
from robust_slam_autograder.grading.results import CaseResult, ExerciseResult
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.misconceptions.tables import Table
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment, Limits, Solution
from robust_slam_autograder.reading.labelled import Answer
from robust_slam_autograder.reading.submission import Code
from robust_slam_autograder.sandbox import InProcess

LIMITS = Limits(call_seconds=4, cell_seconds=4, notebook_seconds=8)
"""Of one answer: what takes longer, without an end in sight or not, is left out."""
CHANGES = {
    "is twice what it should be": "2 * y",
    "is half of what it should be": "y / 2",
    "is four times what it should be": "4 * y",
    "is a quarter of what it should be": "y / 4",
    "is the square of what it should be": "y**2",
    "is the square root of what it should be": "np.sqrt(np.abs(y))",
    "has the wrong sign": "-y",
    "has lost its sign": "np.abs(y)",
    "is one over what it should be": "1 / y",
    "is transposed": "np.swapaxes(y, -1, -2)",
    "is in degrees": "np.rad2deg(y)",
    "is in the reverse order": "y[::-1]",
}
"""By sentence, what is done to the result ``y`` of the solution."""
_CHANGED = """
import numpy as np

def _changed(right):
    def changed(*args, **kwargs):
        y = np.asarray(right(*args, **kwargs), dtype=float)
        return {}

    return changed

{name} = _changed({name})
"""


@dataclass(frozen=True)
class Way:
    """One way to be wrong."""

    sentence: str
    """What goes on after "It looks as if"."""
    source: str
    """Text of the solution cell."""
    is_written: bool
    """Whether an author wrote it down: then it counts before a change of results."""


def ways(right: Code, exercise: Solution, answers: Iterable[Answer]) -> Iterator[Way]:
    """Yield the ways to be wrong in an exercise, of which there are answers, right and wrong."""
    for answer in answers:
        if exercise.is_of(answer.exercise) and not answer.is_right:
            yield Way(answer.label, answer.source, is_written=True)
    (solution,) = [one.source for one in right.pieces if one.label == exercise.grade_id]
    for name in exercise.names:
        result = "what comes back" if len(exercise.names) == 1 else f"what `{name}` returns"
        for sentence, change in CHANGES.items():
            source = solution + _CHANGED.format(change, name=name)
            yield Way(f"{result} {sentence}", source, is_written=False)


def tried(
    assignment: Assignment, exercise: str, answers: Iterable[Answer]
) -> Iterator[tuple[Way, tuple[str, ...]]]:
    """Run ways to be wrong on an exercise's visible cases, and yield each with its keys.

    Words and whole numbers are alike by chance, and what students draw from a number of their own
    tells nothing of others': that has no keys. Nor has what nothing interrupts.
    """
    cases = tuple(one for one in assignment.cases if one.exercise == exercise and not one.has_town)
    if not cases:
        return
    right = submission.collect(notebook.read(assignment.path), assignment)
    config = replace(assignment.config, limits=LIMITS, withheld=())
    alone = replace(assignment, cases=cases, config=config)
    owner = assignment.owner(exercise)
    (mine,) = [one for one in assignment.solutions if one.grade_id == owner]
    # What the solution imports here, each child has.
    failing = (replace(one, visible=f"{one.visible}\nassert False") for one in cases)
    solved = _look(replace(alone, cases=tuple(failing)), right)
    values = {key for case in solved.cases for key in _of(case)}
    left = deque(ways(right, mine, answers))

    def looked() -> Iterator[tuple[str, ...]]:
        for way in [*left]:
            changed = {owner: way.source}
            texts = (replace(p, source=changed.get(p.label, p.source)) for p in right.pieces)
            result = _look(alone, replace(right, pieces=tuple(texts)))
            ends_right = any(key in values for case in result.cases for key in _of(case))
            yield tables.keys(result) if tables.is_real(result) and not ends_right else ()

    while left:
        with contextlib.suppress(Overrun):
            for keys in guarded.guarded(looked):
                yield left.popleft(), keys
            continue
        left.popleft()


def _look(tests: Assignment, code: Code) -> ExerciseResult:
    return Pass("", tests, code, InProcess()).look().result.exercises[0]


def _of(case: CaseResult) -> Iterator[tuple[str, str]]:
    """Yield what a case returned, with its name."""
    return ((case.name, one) for one in case.returned or ())


def survey(assignment: Assignment, exercise: str, answers: Iterable[Answer]) -> Table:
    """Return the labels of an exercise's wrong answers, by what they come to."""
    return labelled(tried(assignment, exercise, answers))


def labelled(found: Iterable[tuple[Way, tuple[str, ...]]]) -> Table:
    """Return the table of ways to be wrong, of which the keys are known."""
    alike: dict[str, list[Way]] = defaultdict(list)
    for way, keys in found:
        if keys:
            alike[next((key for key in keys if key in alike), keys[0])].append(way)
    return tables.sealed({key: chosen(group) for key, group in alike.items()})


def chosen(alike: Iterable[Way]) -> str:
    """Return the sentence that is true of ways which cannot be told apart, or nothing.

    Two sentences say different things, and there is no name. An author's goes before a change's.
    """
    written = {one.sentence for one in alike if one.is_written}
    said = written or {one.sentence for one in alike}
    return said.pop() if len(said) == 1 else ""
