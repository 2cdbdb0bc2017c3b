"""Results that lie where a class was kept before are never passed over in silence."""

import re
import subprocess

import pytest
from robust_slam_autograder import layout
from robust_slam_autograder.errors import WrongUse

from . import toy

ROSTER = "Student,ID,SIS Login ID,Section\nAda,1,ada,A\n"


@pytest.fixture
def course(tmp_path):
    """A course with results where they were kept before."""
    (tmp_path / "build" / "graded" / "ada").mkdir(parents=True)
    (tmp_path / "build" / "submitted").mkdir()
    return tmp_path


def test_every_command_names_the_move_and_goes_on_after_it(course, autograder, monkeypatch):
    monkeypatch.chdir(course)
    toy.make_tree(course)
    toy.hand_in(course / "submitted", "ada", toy.answer())
    (course / "roster.csv").write_text(ROSTER)
    grade = ("grade", f"submitted/ada/{toy.NAME}", *toy.quickly())
    assert autograder(*grade, "--out", "build/graded", "--seed", 5)[0] == 0
    marks = (course / "build" / "graded" / "ada" / f"{toy.NAME}.json").read_bytes()
    told = set()
    for command in (
        grade,
        ("regrade", toy.NAME, "--submitted", "submitted", *toy.quickly()),
        ("feedback",),
        ("report",),
        ("export", "--format", "canvas", "--roster", "roster.csv"),
    ):
        status, _, said = autograder(*command)
        assert status == 2, command
        told.add(said)
    assert not (course / "class").exists()
    (text,) = told
    (move,) = re.findall(r"mkdir -p .+? class/(?=\.)", text)
    assert move == "mkdir -p class && mv build/graded build/submitted build/autograded class/"
    subprocess.run(["sh", "-ec", move], cwd=course, check=True)
    assert (course / "class" / "graded" / "ada" / f"{toy.NAME}.json").read_bytes() == marks
    assert autograder(*grade).worked("1 of them unchanged and reused")
    layout.refuse_unmoved(layout.GRADED, course)


def test_a_folder_that_was_made_beside_it_is_not_overwritten(course):
    (course / "class" / "graded").mkdir(parents=True)
    (course / "class" / "submitted" / "ada").mkdir(parents=True)
    with pytest.raises(WrongUse) as refused:
        layout.refuse_unmoved(course / "class" / "graded", course)
    kept = course / "class"
    assert f"mkdir -p {kept} && mv {course}/build/graded {kept}/." in str(refused.value)
