"""``autograder regrade``: who changes when a test is fixed; without ``--apply`` nothing does."""

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.executor import seeds, trusted
from robust_slam_autograder.grading import journal, regrading, results, submissions
from robust_slam_autograder.reading.submission import DATABASE_NAME

from .. import toy
from ..conftest import Run
from ..nbgrader import course as course_of

pytestmark = pytest.mark.rest

TRIPLE = "def double(x):\n    return 3 * np.asarray(x)\n"
EMPTY = "def apply(f, x, times):\n    raise NotImplementedError\n"
STRICT = "assert double(3) == 7, 'wrong'\n"


def grade(*more: str) -> list[str]:
    """The command that grades the course."""
    paths = map(str, sorted(Path("submitted").glob("*/*")))
    return ["grade", *paths, "--out", "out", "--jobs", "1", *toy.quickly(), *more]


def again() -> list[str]:
    """The command that looks what grading once more would change."""
    to = ["--submitted", "submitted", "--out", "out"]
    return ["regrade", toy.NAME, *to, "--jobs", "1", *toy.quickly()]


@pytest.fixture(scope="module")
def looked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A course whose test asked for 7 where 6 is right; it is fixed, and was looked at once."""
    folder = tmp_path_factory.mktemp("looked")
    toy.make_tree(folder, value=toy.source_notebook(double_by_hand=STRICT))
    toy.hand_in(folder / "submitted", "ada", toy.answer())
    toy.hand_in(folder / "submitted", "bob", toy.answer(TRIPLE))
    toy.hand_in(folder / "submitted", "eve", toy.answer(apply=EMPTY))
    with pytest.MonkeyPatch.context() as patched:
        patched.chdir(folder)
        assert cli.main(grade("--seed", "5")) == 0
        toy.make_tree(folder)
        before = digests(folder)
        assert cli.main(again()) == 0
        assert digests(folder) == before
    return folder


@pytest.fixture
def course(looked: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A course of the test's own; to look again grades nothing that has not changed since."""
    monkeypatch.chdir(shutil.copytree(looked, tmp_path, dirs_exist_ok=True))
    return tmp_path


@pytest.fixture
def regrade(course: Path, autograder: Run) -> Run:
    return lambda *arguments: autograder(*again(), *arguments)


def digests(course: Path) -> dict[str, str]:
    """Everything in the results' folder but what a look leaves there."""
    return {
        str(path.relative_to(course)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted((course / "out").rglob("*"))
        if path.is_file() and regrading.FOLDER_NAME not in path.parts
    }


def changes(regrade: Run, *arguments: object) -> dict[str, Any]:
    value: dict[str, Any] = json.loads(regrade("--json", *arguments)[1])
    return value


def scores(course: Path) -> dict[str, int]:
    return {name: toy.result(course / "out", name)["score"] for name in ("ada", "bob", "eve")}


def in_gradebook(course: Path) -> dict[str, float]:
    rows = course_of.rows(course / "out" / DATABASE_NAME, "score")
    return {name: sum(cells.values()) for name, cells in rows.items()}


def answers_become(monkeypatch: pytest.MonkeyPatch, changed: Callable[[str, Any], object]) -> None:
    """Change what comes of each student: a patch does not reach the processes that grade."""
    every = trusted.run_each

    def answers(*arguments: Any, **options: Any) -> Iterator[tuple[submissions.Submission, Any]]:
        for task, answer in every(*arguments, **options):
            yield task, changed(task.student, answer)

    monkeypatch.setattr(trusted, "run_each", answers)


TABLE = """\
student  exercise  before  after  change
ada      double    6/10    10/10  +4
ada      total     16/20   20/20  +4
eve      double    6/10    10/10  +4
eve      total     6/20    10/20  +4
07-toy: 3 graded again, 2 changed (2 up, 0 down); 0 had these tests already.
gradebook would change: ada 16 → 20
gradebook would change: eve 6 → 10
Nothing was changed; --apply does it.
"""


def test_table_and_json_say_who_changes_and_nothing_changes(course, regrade):
    before = digests(course)
    status, out, _ = regrade()
    assert status == 0 and out == TABLE
    status, out, err = regrade("--json")
    assert digests(course) == before
    value = json.loads(out)
    assert status == 0 and "graded again, 2 changed" in err
    assert value["applied"] is False
    assert list(value["counts"].values()) == [3, 2, 0, 0, 0]
    ada, eve = value["changes"]
    marks = [(16, 20, "graded"), (20, 20, "graded"), (6, 10, "partial"), (10, 10, "passed")]
    keys = ("score", "max_score", "status")
    was, now, part_was, part_now = (dict(zip(keys, mark, strict=True)) for mark in marks)
    parts = [{"name": "double", "before": part_was, "after": part_now}]
    one = {"student": "ada", "before": was, "after": now, "change": 4}
    assert ada == one | {"handed_in_anew": False, "exercises": parts}
    assert eve["change"] == 4
    assert value["gradebook"][0] == {"student": "ada", "before": 16, "after": 20, "waits": False}
    regrade("--json", "changes.json")
    assert json.loads((course / "changes.json").read_text(encoding="utf-8")) == value


def test_apply_changes_results_and_gradebook_as_shown(course, regrade, autograder):
    assert regrade("--apply").worked("gradebook: ada 16 → 20", "Applied")
    assert scores(course) == in_gradebook(course) == {"ada": 20, "bob": 10, "eve": 10}
    assert not (course / "out" / regrading.FOLDER_NAME).exists()
    again = changes(regrade)
    assert again["counts"]["kept"] == 3 and again["changes"] == again["gradebook"] == []
    assert "3 of them unchanged" in autograder(*grade())[1]


def test_what_a_look_has_graded_is_not_graded_twice(course, regrade, monkeypatch):
    shown = changes(regrade)["changes"]
    graded: list[str] = []
    answers_become(monkeypatch, lambda student, answer: graded.append(student) or answer)
    applied = changes(regrade, "--apply")
    assert applied["changes"] == shown and applied["applied"] is True
    assert graded == []
    toy.make_tree(course, value=toy.source_notebook(double_by_hand=STRICT))
    changes(regrade)
    assert {*graded} == {"ada", "bob", "eve"}


def test_the_inputs_are_the_batchs_own(course, regrade):
    bob = (course / "submitted" / "bob" / toy.NAME / f"{toy.NAME}.ipynb").read_bytes()
    drawn = seeds.case_generator(seeds.of_submission(5, bob), "double-random").random()
    random = f"### BEGIN HIDDEN TESTS\nassert rng.random() == {drawn!r}\n### END HIDDEN TESTS\n"
    toy.make_tree(course, value=toy.source_notebook(double_by_hand=STRICT, double_random=random))
    changed = {row["student"]: row["change"] for row in changes(regrade)["changes"]}
    assert changed == {"ada": -6, "bob": 6, "eve": -6}, "each has inputs of its own"


def test_a_persons_mark_stays_and_waits_to_be_looked_at(course, regrade):
    gradebook = course / "out" / DATABASE_NAME
    course_of.enter(gradebook, "ada", "double-by-hand", 1)
    rows = {row["student"]: row for row in changes(regrade)["gradebook"]}
    assert rows["ada"] == {"student": "ada", "before": 17, "after": 17, "waits": True}
    assert rows["eve"]["after"] == 10
    assert "ada 17 → 17, waits for a person" in regrade("--apply")[1]
    assert course_of.rows(gradebook, "manual_score")["ada"]["double-by-hand"] == 1


def test_an_exercise_may_come_or_go(course, regrade):
    value = toy.source_notebook()
    toy.make_tree(course, value=value | {"cells": value["cells"][:4]})
    status, out, _ = regrade()
    lines = [line.split() for line in out.splitlines()]
    assert status == 0 and ["ada", "apply", "10/10", "–", "-10"] in lines
    assert ["ada", "total", "16/20", "10/10", "-6"] in lines


def test_work_that_was_handed_in_anew_is_told_apart(course, regrade):
    path = toy.hand_in(course / "submitted", "bob", toy.answer()) / f"{toy.NAME}.ipynb"
    later = (course / "out" / "bob" / f"{toy.NAME}.json").stat().st_mtime + 5
    os.utime(path, (later, later))
    _, out, err = regrade("--json")
    anew = {one["student"]: one["handed_in_anew"] for one in json.loads(out)["changes"]}
    assert anew == {"ada": False, "bob": True, "eve": False}
    assert "handed in anew since it was graded" in err


def test_a_submission_that_is_gone_is_named_and_its_mark_stays(course, regrade):
    shutil.rmtree(course / "submitted" / "eve")
    assert regrade("--apply").worked("left out, for there is no submission of theirs: eve")
    assert scores(course)["eve"] == 6


def test_where_the_grader_fails_the_mark_stays(course, regrade, monkeypatch):
    shutil.rmtree(course / "out" / regrading.FOLDER_NAME)
    broken = {"ada": trusted.Broken("died")}
    answers_become(monkeypatch, broken.get)
    status, out, _ = regrade("--apply")
    assert status == 1 and "the grader failed on ada: the mark stays as it is" in out
    assert scores(course) == {"ada": 16, "bob": 10, "eve": 10}


def test_after_a_kill_while_applying_the_same_command_finishes(course, regrade, monkeypatch):
    with monkeypatch.context() as killed:
        killed.setattr("robust_slam_autograder.nbgrader.recording.record_new", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            regrade("--apply")
    assert scores(course)["ada"] == 20
    told = changes(regrade, "--apply")["gradebook"]
    assert [(row["student"], row["after"]) for row in told] == [("ada", 20), ("eve", 10)]
    assert in_gradebook(course)["ada"] == 20


def test_a_name_in_brackets_is_no_pattern(tmp_path):
    name = "07-toy[draft]"
    solutions, submitted = tmp_path / "solutions", tmp_path / "submitted"
    toy.write(solutions / name / "07-toy.ipynb", toy.source_notebook())
    (submitted / "ada" / name).mkdir(parents=True)
    failed = results.without_grade("failed", "", student="ada", assignment=name, max_score=1)
    results.write(tmp_path, failed)
    journal.open_journal(tmp_path, 1)
    plan = regrading.plan(solutions, name, out=tmp_path, submitted=submitted)
    assert [job.student for job in plan.jobs] == ["ada"]


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda course: shutil.rmtree(course / "submitted"), "say --submitted DIR"),
        (lambda course: shutil.rmtree(course / "out"), "holds no result of 07-toy"),
        (lambda course: (course / "out" / ".run.json").unlink(), "and with it the seed"),
        (lambda course: shutil.move(course / "solutions" / toy.NAME, course), "assignment"),
    ],
)
def test_what_cannot_be_regraded_is_refused(course, regrade, spoil, words):
    spoil(course)
    assert regrade("--apply").refused(words)
