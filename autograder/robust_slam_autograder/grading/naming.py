"""Gives wrong answers of a batch their labels, after the pass that found them wrong.

The passes hand on digests of what failed cases saw, and no value. What they may mean is worked
out here, of the instructor's code alone, and once for each exercise that somebody has failed. A
label is one of a table's sentences: no other text comes of a hidden pass.
"""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from robust_slam_autograder.grading.marked import Marked
from robust_slam_autograder.grading.marking import PUBLIC_SEED
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.misconceptions import known, survey
from robust_slam_autograder.misconceptions.known import Known
from robust_slam_autograder.misconceptions.survey import Setting
from robust_slam_autograder.misconceptions.tables import Table

Naming = Callable[[Job, Marked], Result]
"""Says what a submission's wrong answers look like."""


@dataclass(frozen=True)
class Namer:
    """Labels for the wrong answers of a batch.

    Attributes:
        folder: what ``autograder misconceptions`` has written.
        seed: the batch's.
    """

    folder: Path
    seed: int
    _known: dict[Path, Known | None] = field(default_factory=dict)
    _tables: dict[tuple[Path, str, bool], Table | None] = field(default_factory=dict)

    def __call__(self, job: Job, marked: Marked) -> Result:
        """Return a submission's result with labels."""
        name = functools.partial(self._exercise, job, marked)
        return replace(marked.result, exercises=tuple(map(name, marked.result.exercises)))

    def _exercise(self, job: Job, marked: Marked, exercise: ExerciseResult) -> ExerciseResult:
        shape = marked.shapes.get(exercise.name)
        keys = shape.keys() if shape is not None else ()
        if shape is None or exercise.status not in ("partial", "failed"):
            return exercise
        table = self._table(job, exercise.name, marked.whole)
        said = table.sentence(shape) if table is not None else ""
        return replace(exercise, misconception=said, pattern=_pattern(keys[0]) if keys else "")

    def _table(self, job: Job, exercise: str, whole: bool) -> Table | None:
        key = (job.tests, exercise, whole)
        if key not in self._tables:
            if job.tests not in self._known:
                self._known[job.tests] = known.read(self.folder, job.assignment.name, job.tests)
            seed = self.seed if whole else PUBLIC_SEED
            self._tables[key] = self._made(
                Setting(job.tests, job.assignment, seed, whole), exercise
            )
        return self._tables[key]

    def _made(self, setting: Setting, exercise: str) -> Table | None:
        found = self._known[setting.path]
        if found is None or exercise not in found.exercises:
            return None
        try:
            return survey.table(setting, exercise, found.exercises[exercise])
        except Exception:  # a label is worth no batch
            return None


def _pattern(key: str) -> str:
    """Return what tells answers that return the same from others, and nothing else."""
    return hashlib.sha256(f"pattern {key}".encode()).hexdigest()[:16]
