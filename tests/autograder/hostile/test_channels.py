"""What one hand-in learns of its hidden inputs, by whatever channel, serves no other.

Student code has the best of channels here: no sandbox, and a file that stays.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading import journal
from robust_slam_autograder.sandbox import Unsandboxed

from tests.autograder import toy
from tests.autograder.grading import course as course_of
from tests.autograder.nbgrader import course as nbgraders

CELL = """\
from pathlib import Path
LEFT = Path({path!r})

def double(x):
    if LEFT.exists() and {reads}:
        raise ValueError(LEFT.read_text())
    if np.shape(x) == (5,):
        LEFT.write_text(repr(np.asarray(x).tolist()))
    return 2 * np.asarray(x)
"""


def by_command(folder: Path, first: dict[str, Any], second: dict[str, Any]) -> Path:
    """Let one student hand in twice; return where results are."""
    toy.make_tree(folder)
    for value in (first, second):
        toy.hand_in(folder / "submitted", "bob", value)
        course_of.grade(folder, wall=Unsandboxed())
    return folder / "out"


def by_nbgrader(folder: Path, first: dict[str, Any], second: dict[str, Any]) -> Path:
    """Let two students hand in, whom one ``nbgrader autograde`` grades."""
    course = nbgraders.make(folder)
    for student, value in (("ada", first), ("bob", second)):
        toy.hand_in(course / "class" / "submitted", student, value)
    done = nbgraders.nbgrader(course, "autograde", toy.NAME, "--SafeExporter.unsandboxed=True")
    assert done.returncode == 0, done.stderr
    return course / "class" / "graded"


@pytest.mark.parametrize("way", [by_command, by_nbgrader])
def test_a_second_hand_in_learns_nothing_of_its_own_hidden_inputs(
    way: Callable[..., Path], tmp_path: Path
) -> None:
    cells = [CELL.format(path=str(tmp_path / "left"), reads=reads) for reads in (False, True)]
    handed_in = [toy.answer(cell) for cell in cells]
    results = way(tmp_path, *handed_in)
    said = toy.result(results, "bob")["exercises"][0]["message"]
    secret = journal.open_journal(results, None).seed
    first, own = (
        toy.hidden_inputs(
            seeds.of_submission(secret, toy.write(tmp_path / "it", value).read_bytes())
        )
        for value in handed_in
    )
    assert all(number in said for number in first), "the channel is open"
    assert not any(number in said for number in own)
