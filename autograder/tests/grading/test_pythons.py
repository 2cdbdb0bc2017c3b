"""What a newer Python wrote, and this one does not know, is told as that, to both sides."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest
from robust_slam_autograder.grading import pythons
from robust_slam_autograder.grading.results import Result

from .. import toy

OURS = f"Python {sys.version_info[0]}.{sys.version_info[1]}"
RIGHT = "def double(x):\n    return 2 * np.asarray(x)\n"
HELPED = "def double(x):\n    return helper(x)\n"
SYNTAX = "def helper(x):\n    return x +* 2\n"
NEWER = "type Pair = tuple[int, int]\n" if sys.version_info < (3, 12) else "t'{x}'\n"
NEW = "from typing import no_such_name as helper\n"


def graded(double: str, own: str = "", version: str = "3.99.1") -> Result:
    value = toy.notebook([toy.cell(own), *toy.answer(double)["cells"]])
    value["metadata"]["language_info"] = {"name": "python", "version": version}
    return toy.graded(value)


@pytest.mark.parametrize(
    ("double", "own", "said"),
    [
        (SYNTAX + RIGHT, "", "Your cell stops with SyntaxError"),
        (NEW + RIGHT, "", "Your cell stops with ImportError"),
        (f"import math\n{RIGHT}    math.no_such_name", "", ""),
        ("def double(x):\n    return x['a']\n", "", ""),
        ("def double(x):\n    return nothing\n", "", ""),
        (f"import math\nmath.no_such_name\n{RIGHT}", "", "Your cell stops with AttributeError"),
        (HELPED, SYNTAX, "A cell of your own is left out: SyntaxError"),
        (HELPED, NEW, "name 'helper' is not defined"),
    ],
)
def test_an_error_that_a_newer_python_does_not_raise_names_both(double, own, said):
    message = graded(double, own).exercises[0].message
    both = f"Your notebook was written in Python 3.99, and {OURS} runs it here"
    assert said in message
    assert (both in message) == (bool(said)), message
    for version in ("3.8", ".".join(map(str, sys.version_info[:3]))):
        assert "runs it here" not in graded(double, own, version).exercises[0].message
    unknown = graded(double, own, "new").exercises[0].message
    is_told = said.endswith("ImportError")  # and of this SyntaxError no Python would say else
    assert (f"{OURS} runs it here: what only a newer one" in unknown) == is_told


@pytest.mark.parametrize(("double", "own"), [(NEWER + RIGHT, ""), (HELPED, NEWER + SYNTAX)])
def test_newer_grammar_is_known_by_its_look_where_no_version_is_named(double, own):
    unknown = graded(double, own, "new").exercises[0].message
    told = f"{OURS} runs it here: what only a newer one knows fails." in unknown
    assert told == (sys.version_info < (3, 14)), "Python 3.14 knows all grammar that is named"


def test_no_message_holds_a_folder_of_this_python():
    for text, name in (NEW, "typing.py"), ("from numpy import no_such_name\n", "numpy"):
        message = graded(text + RIGHT).exercises[0].message
        assert name in message and "/" not in message.replace("(", "")
    folder = Path(np.__file__).parent
    assert pythons.without_paths(f"'{folder}/a b.py' and /tmp/a") == "'a b.py' and /tmp/a"
    for bare in (sys.prefix, os.path.realpath(sys.prefix), str(folder.parent)):
        assert pythons.without_paths(f"no {bare}, '{bare}'") == "no …, '…'"
    assert pythons.without_paths(f"{sys.base_prefix}-x") == f"{sys.base_prefix}-x"


@pytest.fixture
def lab(course, monkeypatch):
    """A lab with Python 3.99, on a machine that has it and an older one on its path."""
    (course / "solutions" / "course.toml").write_text('[lab]\npython = "3.99"\n')
    for name in ("python3.2", "python3.99", "python3"):
        (course / name).touch()
    monkeypatch.setenv("PATH", str(course), prepend=":")


@pytest.mark.parametrize(
    "command",
    [
        ["doctor"],
        ["release", "--out", "release"],
        ["grade", f"submitted/ada/{toy.NAME}", "--out", "out", *toy.quickly()],
    ],
    ids=lambda command: command[0],
)
def test_a_teacher_is_told_that_the_lab_has_a_newer_one(
    autograder, course, lab, monkeypatch, command
):
    monkeypatch.chdir(course)
    status, out, err = autograder(*command)
    said = f"note: Students write in Python 3.99 in the browser, and {OURS} grades: "
    assert status == 0 and said in out + err
    assert "which this machine has: python3.99." in out + err
    grades = f"{OURS} grades what was written in it or in an older one."
    assert (grades in out) == (command == ["doctor"])
    (course / "solutions" / "course.toml").write_text('[lab]\npython = "3.1"\n')
    assert "note: Students" not in "".join(autograder(*command)[1:])
    (course / "solutions" / "course.toml").write_text('[lab]\npython = "new"\n')
    assert autograder(*command)[0] == 2
