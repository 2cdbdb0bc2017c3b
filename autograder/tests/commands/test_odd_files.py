"""One student's odd file costs no other student a mark, and is named harmlessly."""

import contextlib
import glob
import itertools
import os
import shutil
import socket
import sysconfig
import unicodedata
from collections.abc import Callable
from pathlib import Path

import pytest
from robust_slam_autograder.commands.submissions import Places, Reader
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.grading import submissions
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.nbgrader import recording

from .. import toy

OTHER = "08-other"
NAMES = (toy.NAME, OTHER)
ESCAPES = "\x1b[2J\x1b]0;x\x07"
HOSTILE = {
    "escapes": f"{ESCAPES}.ipynb",
    "newline": "a\n::error::b.ipynb",
    "carriage return": "a\r::error::b",
    "direction": "\u202egnp.ipynb",
    "half a character": os.fsdecode(b"\xff\xfe.txt"),
    "command": "::error file=a,line=1::b",
    "old command": "##[error]b.ipynb",
    "azure": "##vso[task.complete result=Failed]b",
    "very long": "x" * 200,
}


def bind(path: Path) -> None:
    """Make a socket; its address has little room, so from its folder."""
    with contextlib.chdir(path.parent), socket.socket(socket.AF_UNIX) as made:
        made.bind(path.name)


KINDS: dict[str, Callable[[Path], object]] = {
    "file": Path.touch,
    "notebook": lambda path: toy.write(path, toy.answer()),
    "folder": Path.mkdir,
    "nested": lambda path: toy.write(path / toy.NAME / f"{toy.NAME}.ipynb", toy.answer()),
    "pipe": os.mkfifo,
    "socket": bind,
    "dangling": lambda path: path.symlink_to("nowhere"),
    "loop": lambda path: path.symlink_to(path.name),
    "device": lambda path: path.symlink_to("/dev/zero"),
    "neighbour": lambda path: path.symlink_to(f"../ada/{toy.NAME}"),
}
PLACES = ("alice.ipynb", f"{toy.NAME}.ipynb", "notes", ".DS_Store", "__MACOSX", "week 1")


@pytest.fixture
def run(course, autograder):
    return lambda name, *arguments: autograder(name, *arguments, "--out", course / "out")


def everything(course: Path) -> list[str]:
    """What the documented ``submitted/*/*`` stands for, files that begin with a dot too."""
    return sorted(glob.glob(f"{glob.escape(str(course))}/submitted/*/*", include_hidden=True))


def is_harmless(text: str) -> bool:
    """Whether a terminal and a CI service show the text and do nothing else."""
    acts = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}
    letters = text.replace("\n", "")
    return not (
        any(unicodedata.category(letter) in acts for letter in letters)
        or any(line.lstrip().startswith("::") for line in text.split("\n"))
        or any(mark in text for mark in ("##[", "##vso["))
    )


def read(paths: list[Path], **options: str) -> tuple[dict[Path, str], list[Path]]:
    """By path whose work it is, and the paths that are left out."""
    reader = Reader(NAMES, options.get("assignment"), options.get("student"), Places())
    claims, strays = reader.read([path.absolute() for path in paths])
    return {claim.path: claim.student for claim in claims}, [stray.path for stray in strays]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("options", [{}, {"assignment": toy.NAME}], ids=["", "named"])
def test_a_students_own_folder_alone_counts(course, kind, place, options):
    odd = course / "submitted" / "bob" / place
    KINDS[kind](odd)
    owners, strays = read(list(map(Path, everything(course))), **options)
    assert owners == {course / "submitted" / s / toy.NAME: s for s in ("ada", "bob")}
    assert strays == [odd]


@pytest.mark.parametrize(
    "paths",
    [
        ("submitted/eve/alice.ipynb",),
        (f"submitted/eve/{toy.NAME}/alice.ipynb",),
        ("class/eve/alice.ipynb", "class/mia/alice.ipynb"),
        (f"class/eve/{toy.NAME}/alice.ipynb", f"class/mia/{toy.NAME}/x.ipynb"),
        ("class/eve/alice.ipynb", f"class/mia/{toy.NAME}"),
        (f"inbox/{toy.NAME}.ipynb",),
        (f"submitted/__MACOSX/{toy.NAME}",),
    ],
)
def test_a_notebook_in_a_students_folder_is_not_another_students(course, paths):
    for path in paths:
        toy.write(course / path / "x" if path.endswith(toy.NAME) else course / path, toy.answer())
    owners, _ = read([course / path for path in paths], assignment=toy.NAME)
    assert "alice" not in owners.values() and set(owners.values()) <= {"mia"}
    if not paths[0].endswith(toy.NAME):
        given, _ = read([course / paths[0]], assignment=toy.NAME, student="eve")
        assert list(given.values()) == ["eve"]


@pytest.mark.parametrize("path", ["inbox/alice.ipynb", f"inbox/{toy.NAME}/alice.ipynb"])
def test_a_notebook_in_an_inbox_is_its_stems(course, path):
    paths = [toy.write(course / path, toy.answer()), course / "submitted" / "ada" / toy.NAME]
    owners = dict(zip(paths, ("alice", "ada"), strict=True))
    assert read(paths, assignment=toy.NAME) == (owners, [])


def test_a_folder_in_a_students_folder_is_not_another_students(course):
    deeper = course / "submitted" / "bob" / "alice" / toy.NAME
    deeper.mkdir(parents=True)
    own = course / "submitted" / "bob" / toy.NAME
    assert read([deeper, own]) == ({own: "bob"}, [deeper])
    assert read([deeper], student="eve") == ({deeper: "eve"}, [])
    section = course / "submitted" / "monday" / "mia" / toy.NAME
    section.mkdir(parents=True)
    assert read([section]) == ({section: "mia"}, [])


def test_two_paths_of_one_submission_cost_no_other_student_a_mark(course):
    again = toy.write(course / "c" / "d" / "bob.ipynb", toy.answer())
    twice = [toy.write(course / place / "eve.ipynb", toy.answer()) for place in ("a/b", "e/f")]
    owners, strays = read([*map(Path, everything(course)), again, *twice], assignment=toy.NAME)
    assert sorted(owners.values()) == ["ada", "bob"] and strays == [again, *twice]


def test_a_path_that_cannot_be_looked_at_is_left_out(tmp_path):
    path = tmp_path / ("x" * 300) / toy.NAME
    assert read([path]) == ({}, [path])
    job = Submission("eve", toy.assignment(), path)
    with pytest.raises(Refused, match="cannot be read"):
        submissions.locate(job)


def test_the_documented_command_grades_everyone_else(course, run):
    bob = course / "submitted" / "bob"
    makes = itertools.cycle(KINDS.values())
    for name in (*HOSTILE.values(), *PLACES):
        next(makes)(bob / name)
    # Its name is a command to GitHub, and the name of a file beside the results.
    files = ("new.json", "new.md", "book.sqlite")
    for student in ("::error::x", "##[error]y", *files, "zoe\u0308", "zo\u00eb"):
        toy.hand_in(course / "submitted", student, toy.answer())
    summary, table, book = (course / "out" / name for name in files)
    grade = ("grade", *everything(course), *toy.quickly(), "--seed", 1)
    to = ("--json", summary, "--markdown", table, "--gradebook", f"sqlite:///{book}")
    for _ in range(2):
        status, out, err = run(*grade, *to)
        assert status == 0 and "6 graded, 3 refused, 0 failed" in out
        assert out.count("is no name for a student: rename it.") == len(files)
        assert err.count("left out: ") == len(HOSTILE) + len(PLACES)
        assert is_harmless(out + err)
    for student in ("ada", "bob", "zo\u00eb", "zoe\u0308"):
        assert toy.result(course / "out", student)["score"] == toy.MOST
    assert not (course / "out" / "alice").exists() and summary.is_file()
    err = run("grade", *everything(course), *toy.quickly(), "--no-names")[2]
    # What was written before is now a file that is in its student's way.
    assert err.count("left out: path ") == len(HOSTILE) + len(PLACES) + len(files)
    assert not [word for word in ("bob", "alice", "error", str(course)) if word in err]
    for command in (
        ("feedback", "--to", course / "feedback"),
        ("report", "--to", course / "report"),
        ("regrade", toy.NAME, "--submitted", course / "submitted", *toy.quickly()),
    ):
        status, out, err = run(*command)
        assert status == 0 and is_harmless(out + err), command
    roster = course / "roster.csv"
    people = "".join(f"x,y,{name}\n" for name in ("ada", "bob", "zo\u00eb", "nil"))
    roster.write_text(f"First name,Last name,Email address\n{people}", encoding="utf-8")
    what = ("--format", "moodle", "--roster", roster, "--to", course / "moodle.csv")
    status, out, err = run("export", *what, "--missing-as-zero", *to[-2:])
    assert status == 1 and is_harmless(out + err)


@pytest.mark.sandbox
def test_what_is_no_submission_is_refused_and_the_others_are_graded(course, run, wall_name):
    kinds = KINDS | {"visible": lambda path: path.symlink_to(sysconfig.get_path("stdlib"))}
    for kind, make in kinds.items():
        odd = course / "submitted" / kind / toy.NAME
        odd.parent.mkdir()
        make(odd)
    # A notebook counts under any name: only its place tells whose it is.
    status, out, err = run("grade", *everything(course), "--sandbox", wall_name)
    assert status == 0 and f"3 graded, {len(kinds) - 1} refused, 0 failed" in out, err
    assert toy.result(course / "out", "notebook")["score"] == toy.MOST


def test_a_stray_file_among_the_results_is_named_and_harms_nobody(course, run, monkeypatch):
    monkeypatch.setattr(recording, "record_new", lambda *arguments: None)
    (course / "out").mkdir()
    (course / "out" / "ada").touch()
    status, said, err = run("grade", *everything(course), *toy.quickly())
    assert status == 0 and "1 graded, 0 refused" in said
    assert f"ada/{toy.NAME} has no place for its result" in err and "move that file away" in err
    (course / "out" / "ada").unlink()
    assert "2 graded, 0 refused" in run("grade", *everything(course), *toy.quickly())[1]


def test_names_that_differ_in_capitals_alone_are_left_out(course, run, monkeypatch):
    monkeypatch.setattr(recording, "record_new", lambda *arguments: None)
    both = [toy.hand_in(course / "submitted", name, toy.answer()) for name in ("ADA", "Bob")]
    bob = course / "submitted" / "bob" / toy.NAME
    status, said, err = run("grade", *everything(course), *toy.quickly())
    assert status == 2 and "differs from another's in capitals alone" in err
    shutil.rmtree(both[1].parent)
    status, said, err = run("grade", *everything(course), *toy.quickly())
    assert status == 0 and "1 graded, 0 refused" in said and err.count("in capitals alone") == 2
    # Who was graded before keeps the name.
    bob.parent.rename(course / "submitted" / "BOB")
    status, said, err = run("grade", course / "submitted" / "BOB" / toy.NAME, *toy.quickly())
    assert status == 2 and "name one of them anew" in err
    assert [path.name for path in (course / "out").iterdir() if path.is_dir()] == ["bob"]
