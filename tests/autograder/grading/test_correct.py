"""Correct submissions that look unusual: what is said of them. (Their marks: test_hostile.)"""

from __future__ import annotations

from pathlib import Path

import pytest
from robust_slam_autograder.grading import batch, tasks
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.sandbox import Unsandboxed

from tests.autograder import correct, toy
from tests.autograder.hostile.entry import Place
from tests.autograder.hostile.target import load

NOTES = {
    "plain": "",
    "copied-cell": "double stands in 2 cells: they ran in order.",
    "another-name": "Homework (1).ipynb was taken for 07-toy.ipynb.",
    "no-metadata": "The cell double was found by its function's name. "
    "The cell apply was found by its function's name.",
    "split-cell": "",
}


def grade(name: str, folder: Path) -> Result:
    tree = toy.make_tree(folder)
    target = load(tree, toy.NAME, folder / "release")
    (entry,) = [entry for entry in correct.CORRECT if entry.name == name]
    place = Place(folder / "submitted" / name / toy.NAME, folder, "mk")
    entry.write(target, place)
    tests = tree / toy.NAME / f"{toy.NAME}.ipynb"
    job = tasks.Job(name, target.assignment, tests, place.folder)
    task = tasks.Fingerprints(1, Unsandboxed()).task(job)
    return batch.grade_task(task, seed=1, wall=Unsandboxed())


@pytest.mark.parametrize("name", NOTES)
def test_what_was_unusual_is_said(name: str, tmp_path: Path) -> None:
    result = grade(name, tmp_path)
    assert result.score == result.max_score == toy.MOST
    assert result.reason == NOTES[name]
