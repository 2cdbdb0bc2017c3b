"""What one hand-in learns of its hidden inputs, by whatever channel, serves no other.

Student code has the best channel that there is here: no sandbox, and a file that stays. What asks
for names that do not exist, or counts the numbers of pipes, gets the same to know, more slowly.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading import journal
from robust_slam_autograder.grading.journal import Journal
from robust_slam_autograder.sandbox import Unsandboxed

from tests.autograder import toy
from tests.autograder.grading import course as course_of
from tests.autograder.nbgrader import course as nbgraders

TELLS = """\
from pathlib import Path
LEFT = Path({path!r})

def double(x):
    if LEFT.exists() and {reads}:
        raise ValueError(LEFT.read_text())
    if np.shape(x) == (5,):
        LEFT.write_text(repr(np.asarray(x).tolist()))
    return 2 * np.asarray(x)
"""


def hand_in(folder: Path, student: str, *, reads: bool) -> None:
    source = TELLS.format(path=str(folder / "left"), reads=reads)
    toy.hand_in(folder, student, toy.answer(source))


def inputs(kept: Journal, folder: Path) -> list[str]:
    """What the hidden cases draw for a submission."""
    data = (folder / toy.NAME / f"{toy.NAME}.ipynb").read_bytes()
    return toy.hidden_inputs(seeds.of_submission(kept.seed, data))


def by_command(folder: Path) -> tuple[Path, Path]:
    """One student hands in twice; the results' folder, and that of submissions."""
    toy.make_tree(folder)
    for reads in (False, True):
        hand_in(folder / "submitted", "bob", reads=reads)
        shutil.copytree(
            folder / "submitted" / "bob", folder / "kept" / ("bob" if reads else "ada")
        )
        course_of.grade(folder, wall=Unsandboxed())
    return folder / "out", folder / "kept"


def by_nbgrader(folder: Path) -> tuple[Path, Path]:
    """Two students, in one ``nbgrader autograde``."""
    course = nbgraders.make(folder)
    submitted = course / "class" / "submitted"
    for student, reads in (("ada", False), ("bob", True)):
        hand_in(submitted, student, reads=reads)
    done = nbgraders.nbgrader(course, "autograde", toy.NAME, "--SafeExporter.unsandboxed=True")
    assert done.returncode == 0, done.stderr
    return course / "class" / "graded", submitted


@pytest.mark.parametrize("way", [by_command, by_nbgrader])
def test_a_second_hand_in_learns_nothing_of_its_own_hidden_inputs(
    way: Callable[[Path], tuple[Path, Path]], tmp_path: Path
) -> None:
    results, handed_in = way(tmp_path)
    kept = journal.open_journal(results, None)
    said = toy.result(results, "bob")["exercises"][0]["message"]
    assert all(number in said for number in inputs(kept, handed_in / "ada")), "a channel is open"
    assert not any(number in said for number in inputs(kept, handed_in / "bob"))
