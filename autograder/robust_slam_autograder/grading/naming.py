"""Gives wrong answers of a batch their labels, by what visible cases saw of them.

No hidden pass has a part in it: what it is given cannot come out of a label.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from robust_slam_autograder.grading.marked import Marked
from robust_slam_autograder.grading.results import ExerciseResult
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.misconceptions import known, tables
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.misconceptions.tables import Table

Naming = Callable[[Job, Marked], Marked]
"""Names what the visible pass over a submission has found wrong."""


def nameless(job: Job, marked: Marked) -> Marked:
    """Name nothing."""
    return marked


@dataclass(frozen=True)
class Namer:
    """Labels for the wrong answers of a batch; ``folder`` is as for ``known.read``."""

    folder: Path
    _tables: dict[Path, Mapping[str, Table]] = field(default_factory=dict)

    def __call__(self, job: Job, marked: Marked) -> Marked:
        """Return what a visible pass came to with labels, and without what they come of."""
        if job.tests not in self._tables:
            found = known.read(self.folder, job.assignment.name, job.tests)
            self._tables[job.tests] = found.exercises if found else {}
        labels = self._tables[job.tests]
        exercises = (
            _named(one, marked.shapes[one.name], labels.get(one.name, {}))
            if one.name in marked.shapes and one.status in ("partial", "failed")
            else one
            for one in marked.result.exercises
        )
        result = replace(marked.result, exercises=tuple(exercises))
        return replace(marked, result=result, shapes={})


def _named(exercise: ExerciseResult, shape: Shape, table: Table) -> ExerciseResult:
    keys = shape.keys()
    said = tables.sentence(table, keys)
    return replace(exercise, misconception=said, pattern=_pattern(*keys[:1]))


def _pattern(key: str = "") -> str:
    """Return what tells answers that return the same from others, and nothing else."""
    return hashlib.sha256(f"pattern {key}".encode()).hexdigest()[:16] if key else ""
