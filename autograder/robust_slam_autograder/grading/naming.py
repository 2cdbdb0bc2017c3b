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
from robust_slam_autograder.misconceptions.shapes import Shape
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
    _labels: dict[tuple[Path, str, frozenset[str]], dict[str, str]] = field(default_factory=dict)
    """By the cases that are failed: of others than a student's, none need be run."""

    def __call__(self, job: Job, marked: Marked) -> Result:
        """Return a submission's result with labels."""
        name = functools.partial(self._exercise, job, marked)
        return replace(marked.result, exercises=tuple(map(name, marked.result.exercises)))

    def _exercise(self, job: Job, marked: Marked, exercise: ExerciseResult) -> ExerciseResult:
        shape = marked.shapes.get(exercise.name)
        keys = shape.keys() if shape is not None else ()
        if shape is None or exercise.status not in ("partial", "failed"):
            return exercise
        setting = Setting(job.tests, job.assignment, self._seed(marked), marked.whole)
        try:
            said = self._said(setting, exercise.name, shape, has_keys=bool(keys))
        except Exception:  # a label is worth no batch
            said = ""
        return replace(exercise, misconception=said, pattern=_pattern(keys[0]) if keys else "")

    def _seed(self, marked: Marked) -> int:
        return self.seed if marked.whole else PUBLIC_SEED

    def _said(self, setting: Setting, exercise: str, shape: Shape, *, has_keys: bool) -> str:
        if setting.path not in self._known:
            name = setting.assignment.name
            self._known[setting.path] = known.read(self.folder, name, setting.path)
        found = self._known[setting.path]
        if found is None or exercise not in found.exercises:
            return ""
        key = (setting.path, exercise, setting.whole)
        if key not in self._tables:
            self._tables[key] = None  # where it cannot be made, it is tried once
            self._tables[key] = survey.right(setting, exercise)
        table, labels = self._tables[key], {}
        if has_keys:
            labels = self._labels_of(setting, exercise, frozenset(shape.failed))
        return replace(table, labels=labels).sentence(shape) if table is not None else ""

    def _labels_of(
        self, setting: Setting, exercise: str, failed: frozenset[str]
    ) -> dict[str, str]:
        """Return the labels of answers that fail the same cases; of visible ones, of all."""
        failed = failed if setting.whole else frozenset()
        key = (setting.path, exercise, failed)
        found = self._known[setting.path]
        if key not in self._labels and found is not None:
            self._labels[key] = {}
            ways = [one for one in found.exercises[exercise] if failed in (set(), set(one.fails))]
            self._labels[key] = survey.labels_of(setting, exercise, ways)
        return self._labels[key]


def _pattern(key: str) -> str:
    """Return what tells answers that return the same from others, and nothing else."""
    return hashlib.sha256(f"pattern {key}".encode()).hexdigest()[:16]
