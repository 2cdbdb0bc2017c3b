"""Gives wrong answers of a batch their labels, after the pass that found them wrong.

The passes hand on digests of what failed cases saw, and no value. What they may mean is worked
out here, of the instructor's code alone. What a way to be wrong returns to visible cases is known
before a batch: so of all ways those alone run on hidden inputs that an answer may still be. A
label is one of a table's sentences: no other text comes of a hidden pass.
"""

from __future__ import annotations

import functools
import hashlib
import itertools
from dataclasses import dataclass, field, replace
from pathlib import Path

from robust_slam_autograder.executor.seeds import PUBLIC_SEED
from robust_slam_autograder.grading.marked import Marked
from robust_slam_autograder.grading.results import ExerciseResult, Result
from robust_slam_autograder.grading.tasks import Job
from robust_slam_autograder.misconceptions import known, survey
from robust_slam_autograder.misconceptions.bench import Setting
from robust_slam_autograder.misconceptions.known import Known
from robust_slam_autograder.misconceptions.runner import Runner
from robust_slam_autograder.misconceptions.shapes import Shape

MOST = 12
"""Ways to be wrong that are run for one answer, an author's own before others: it costs a tenth of
its grading at most, and no clock decides on a label."""


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
    _labels: dict[tuple[object, ...], dict[str, str]] = field(default_factory=dict)
    """By exercise and the keys of what hidden and visible cases saw."""
    _runners: dict[tuple[Path, bool], Runner] = field(default_factory=dict)

    def __call__(self, job: Job, marked: Marked) -> Result:
        """Return a submission's result with labels."""
        name = functools.partial(self._exercise, job, marked)
        return replace(marked.result, exercises=tuple(map(name, marked.result.exercises)))

    def close(self) -> None:
        """End the processes that ran the instructor's code."""
        for runner in self._runners.values():
            runner.close()

    def _exercise(self, job: Job, marked: Marked, exercise: ExerciseResult) -> ExerciseResult:
        shape = marked.shapes.get(exercise.name)
        if shape is None or exercise.status not in ("partial", "failed"):
            return exercise
        keys = shape.keys()
        try:
            said = self._said(job, marked, exercise.name, shape)
        except Exception:  # a label is worth no batch
            said = ""
        return replace(exercise, misconception=said, pattern=_pattern(keys[0]) if keys else "")

    def _said(self, job: Job, marked: Marked, exercise: str, shape: Shape) -> str:
        if job.tests not in self._known:
            self._known[job.tests] = known.read(self.folder, job.assignment.name, job.tests)
        found = self._known[job.tests]
        if found is None or exercise not in found.exercises:
            return ""
        runner = self._runner(job, whole=marked.whole)
        table = runner.table(exercise)
        if table is None:
            return ""
        visible = marked.visible.get(exercise, Shape()).all_keys() if marked.whole else ()
        key = (job.tests, exercise, *shape.keys()[:1], *visible[:1])
        if key not in self._labels:
            is_like_none = not shape.keys() or (marked.whole and not shape.real)
            ways = () if is_like_none else found.exercises[exercise]
            may_be = (one for one in ways if not marked.whole or one.fits(shape.failed, visible))
            self._labels[key] = survey.one_each(
                (one, runner.keys(exercise, one, shape) if marked.whole else (one.seen,))
                for one in itertools.islice(may_be, MOST if marked.whole else None)
            )
        return replace(table, labels=self._labels[key]).sentence(shape)

    def _runner(self, job: Job, *, whole: bool) -> Runner:
        seed = self.seed if whole else PUBLIC_SEED
        setting = Setting(job.tests, job.assignment, seed, whole)
        return self._runners.setdefault((job.tests, whole), Runner(setting))


def _pattern(key: str) -> str:
    """Return what tells answers that return the same from others, and nothing else."""
    return hashlib.sha256(f"pattern {key}".encode()).hexdigest()[:16]
