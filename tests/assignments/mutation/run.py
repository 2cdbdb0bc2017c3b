"""Grades mutants: each in the reference's place, on the cases of its own exercise."""

import functools
import multiprocessing
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading.passes import Pass
from robust_slam_autograder.grading.results import ExerciseResult, Result, without_grade
from robust_slam_autograder.grading.submissions import Outcome
from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment, Limits
from robust_slam_autograder.reading.submission import Code

from tests.assignments.mutation.bare_fork import BareFork
from tests.assignments.mutation.cells import Mutant, mutants

SHORTEST = 2.0
"""Seconds that a call may always take, on a busy machine too."""
TIMES_LONGER = 4.0
"""How much longer one call of a mutant may take than grading the whole reference did."""


@dataclass(frozen=True)
class Verdict:
    """What the cases of its exercise made of a mutant."""

    mutant: Mutant
    lost: tuple[str, ...]
    """Grade ids of the cases that it failed."""
    fault: str = ""
    """"timeout" or "died" where it hung or died; the cases after that were not run."""

    @property
    def is_killed(self) -> bool:
        """Return whether any case noticed."""
        return bool(self.lost or self.fault)


@dataclass(frozen=True)
class Exercise:
    """One exercise, with the reference solution and the cases that mutants must lose."""

    assignment: Assignment
    """With this exercise's cases alone, and small limits."""
    reference: Code
    cell: str
    """Grade id of the solution cell."""
    source: str
    """Its text."""


def exercises(path: Path, only: str = "") -> list[Exercise]:
    """Return the exercises of an assignment's notebook, or the one that is named.

    Raises:
        WrongUse: there is none of that name.
    """
    whole = assignment_module.load(path)
    reference = submission.collect(notebook.read(path), whole)
    sources = {piece.label: piece.source for piece in reference.pieces}
    names = [name for name in whole.exercises if only in ("", name)]
    if not names:
        raise WrongUse(f"{whole.name} has no exercise {only}; it has {', '.join(whole.exercises)}")
    return [
        Exercise(_alone(whole, name), reference, cell, sources[cell])
        for name in names
        if (cell := whole.owner(name))
    ]


def _alone(whole: Assignment, exercise: str) -> Assignment:
    """An assignment with the cases of one exercise; what solutions import is loaded beforehand."""
    loads = (f"import {name}" for name in whole.libraries)
    cases = tuple(case for case in whole.cases if case.exercise == exercise)
    return replace(whole, imports=(*whole.imports, *loads), cases=cases)


def run(exercises: Sequence[Exercise], *, seed: int, jobs: int) -> Iterator[Verdict]:
    """Grade all mutants of some exercises, and give the verdicts in the order of their text.

    Raises:
        WrongUse: the reference itself loses a case of its own exercise.
    """
    # One thread a process: children are forked.
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    context = multiprocessing.get_context("forkserver")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        timed = list(pool.map(functools.partial(with_limits, seed=seed), exercises))
        tasks = [(one, mutant) for one in timed for mutant in of_exercise(one)]
        yield from pool.map(functools.partial(grade, seed=seed), *zip(*tasks, strict=True))


def of_exercise(exercise: Exercise) -> list[Mutant]:
    """Return the mutants of an exercise's cell."""
    return mutants(exercise.cell, exercise.source)


def with_limits(exercise: Exercise, *, seed: int) -> Exercise:
    """Grade the reference, which may lose nothing, and take limits from the time that it took."""
    result = _result(exercise, exercise.source, seed)
    lost = [grade_id for one in result.exercises for grade_id in _lost(one)]
    if lost:
        raise WrongUse(f"The reference itself loses {', '.join(lost)}: fix that first.")
    config = exercise.assignment.config
    config = replace(config, limits=_limits(config.limits, result.seconds))
    return replace(exercise, assignment=replace(exercise.assignment, config=config))


def grade(exercise: Exercise, mutant: Mutant, *, seed: int) -> Verdict:
    (result,) = _result(exercise, mutant.source, seed).exercises
    if result.status in ("timeout", "died"):
        return Verdict(mutant, (), result.status)
    return Verdict(mutant, tuple(_lost(result)))


_NOT_SEEN = Outcome(without_grade("graded", "", student="", assignment="", max_score=0))


def _result(exercise: Exercise, source: str, seed: int) -> Result:
    """Grade a submission with other text in one solution cell, hidden checks and all."""
    pieces = tuple(
        replace(piece, source=source) if piece.label == exercise.cell else piece
        for piece in exercise.reference.pieces
    )
    code = replace(exercise.reference, pieces=pieces)
    # The pass over whole cases alone: it has the visible checks too.
    return Pass("mutant", exercise.assignment, code, BareFork()).finish(_NOT_SEEN, seed).result


def _limits(given: Limits, seconds: float) -> Limits:
    """Small limits, so that an endless loop costs little; never more than the assignment's."""
    call = min(given.call_seconds, max(SHORTEST, TIMES_LONGER * seconds))
    whole = max(given.notebook_seconds, 20 * call)
    return Limits(call, min(given.cell_seconds, 2 * call), whole)


def _lost(exercise: ExerciseResult) -> list[str]:
    return [f"{exercise.name}-{one.name}" for one in exercise.cases if one.earned < one.points]
