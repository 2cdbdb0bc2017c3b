"""``autograder regrade``: who changes when a test is fixed, and nothing before it is told to."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
from collections.abc import Callable, Generator, Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.grading import batch, journal, regrading, results
from robust_slam_autograder.grading.results import without_grade

from tests.autograder import toy
from tests.autograder.nbgrader import course as course_of

TRIPLE = "def double(x):\n    return 3 * np.asarray(x)\n"
EMPTY = "def apply(f, x, times):\n    raise NotImplementedError\n"
STRICT = "assert double(3) == 7, 'wrong'\n"
Run = Callable[..., tuple[int, str, str]]


def write_tests(course: Path, **sources: str) -> None:
    """Write the instructor's notebook with other sources in some test cells."""
    value = toy.source_notebook()
    for cell in value["cells"]:
        cell["source"] = sources.get(cell["id"].replace("-", "_"), cell["source"])
    toy.write(course / "solutions" / toy.NAME / f"{toy.NAME}.ipynb", value)


@pytest.fixture(scope="module")
def graded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three students, graded by a test that asks for 7 where 6 is right."""
    folder = tmp_path_factory.mktemp("regrade")
    toy.make_tree(folder)
    write_tests(folder, double_by_hand=STRICT)
    for student, value in {
        "ada": toy.answer(),
        "bob": toy.answer(TRIPLE),
        "eve": toy.answer(apply=EMPTY),
    }.items():
        toy.hand_in(folder / "submitted", student, value)
    paths = map(str, sorted((folder / "submitted").glob("*/*")))
    assert cli.main([*tree(folder), "grade", *paths, *how(folder), "--seed", "5"]) == 0
    return folder


def tree(course: Path) -> tuple[str, str]:
    return "--solutions", str(course / "solutions")


def how(course: Path) -> tuple[str, ...]:
    return "--out", str(course / "out"), "--unsandboxed", "--jobs", "1"


@pytest.fixture(scope="module")
def looked(graded: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The test has been fixed, and somebody has looked what that changes."""
    made = Path(shutil.copytree(graded, tmp_path_factory.mktemp("looked") / "course"))
    write_tests(made)
    before = digests(made)
    assert cli.main(command(made)) == 0
    assert digests(made) == before
    return made


def command(course: Path, *arguments: object) -> list[str]:
    what = ("regrade", toy.NAME, "--submitted", str(course / "submitted"), *how(course))
    return [*tree(course), *what, *map(str, arguments)]


@pytest.fixture
def course(looked: Path, tmp_path: Path) -> Path:
    """A course of the test's own; who looks again grades nothing that has not changed since."""
    return Path(shutil.copytree(looked, tmp_path / "course"))


@pytest.fixture
def regrade(course: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Grade again: exit status, output, errors."""

    def run(*arguments: object) -> tuple[int, str, str]:
        status = cli.main(command(course, *arguments))
        return (status, *capsys.readouterr())

    return run


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


def test_the_table_says_who_changes_and_nothing_changes(course: Path, regrade: Run) -> None:
    before = digests(course)
    status, out, _ = regrade()
    assert status == 0 and out == TABLE
    assert digests(course) == before


def test_json_says_the_same_and_has_standard_output_for_itself(course: Path, regrade: Run) -> None:
    status, out, err = regrade("--json")
    value = json.loads(out)
    assert status == 0 and "graded again, 2 changed" in err
    assert value["applied"] is False
    assert list(value["counts"].values()) == [3, 2, 0, 0, 0]
    ada, eve = value["changes"]
    assert ada == {
        "student": "ada",
        "before": {"score": 16, "max_score": 20, "status": "graded"},
        "after": {"score": 20, "max_score": 20, "status": "graded"},
        "change": 4,
        "handed_in_anew": False,
        "exercises": [
            {
                "name": "double",
                "before": {"score": 6, "max_score": 10, "status": "partial"},
                "after": {"score": 10, "max_score": 10, "status": "passed"},
            }
        ],
    }
    assert eve["change"] == 4
    assert value["gradebook"][0] == {"student": "ada", "before": 16, "after": 20, "waits": False}
    regrade("--json", course / "changes.json")
    assert json.loads((course / "changes.json").read_text(encoding="utf-8")) == value


def test_apply_changes_results_and_gradebook_as_shown(course: Path, regrade: Run) -> None:
    status, out, _ = regrade("--apply")
    assert status == 0 and "gradebook: ada 16 → 20" in out and "Applied" in out
    scores = {name: toy.result(course / "out", name)["score"] for name in ("ada", "bob", "eve")}
    assert scores == {"ada": 20, "bob": 10, "eve": 10}
    rows = course_of.rows(course / "out" / "gradebook.db", "auto_score")
    assert {name: sum(cells.values()) for name, cells in rows.items()} == scores
    assert not (course / "out" / regrading.FOLDER_NAME).exists()
    again = changes(regrade)
    assert again["counts"]["kept"] == 3 and again["changes"] == again["gradebook"] == []


def test_the_grade_command_keeps_what_was_applied(
    course: Path, regrade: Run, capsys: pytest.CaptureFixture[str]
) -> None:
    regrade("--apply")
    paths = map(str, sorted((course / "submitted").glob("*/*")))
    assert cli.main([*tree(course), "grade", *paths, *how(course)]) == 0
    assert "3 graded, 0 refused, 0 failed, 3 of them unchanged" in capsys.readouterr().out


def spy(seen: list[batch.Job], jobs: Iterable[batch.Job]) -> Generator[Any, None, None]:
    """In place of grading: note what would be graded."""
    seen += jobs
    yield from ()


def test_what_a_look_has_graded_is_not_graded_twice(
    course: Path, regrade: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = changes(regrade)["changes"]
    jobs: list[batch.Job] = []
    monkeypatch.setattr(batch, "_grade_all", lambda left, *how: spy(jobs, left))
    applied = changes(regrade, "--apply")
    assert applied["changes"] == shown and applied["applied"] is True
    assert jobs == []
    write_tests(course, double_by_hand=STRICT)
    with pytest.raises(KeyError):  # for the spy grades nothing
        changes(regrade)
    assert len(jobs) == 3


def test_the_inputs_are_the_batchs_own(course: Path, regrade: Run) -> None:
    write_tests(
        course,
        double_by_hand=STRICT,
        double_random="### BEGIN HIDDEN TESTS\nassert rng.random() == "
        f"{toy.case_generator(5, 'double-random').random()!r}\n### END HIDDEN TESTS\n",
    )
    (bob,) = changes(regrade)["changes"]
    assert bob["student"] == "bob" and bob["change"] == 6


def test_a_persons_mark_stays_and_waits_to_be_looked_at(course: Path, regrade: Run) -> None:
    course_of.enter(course / "out" / "gradebook.db", "ada", "double-by-hand", 1)
    rows = {row["student"]: row for row in changes(regrade)["gradebook"]}
    assert rows["ada"] == {"student": "ada", "before": 17, "after": 17, "waits": True}
    assert rows["eve"]["after"] == 10
    assert "ada 17 → 17, waits for a person" in regrade("--apply")[1]
    marks = course_of.rows(course / "out" / "gradebook.db", "manual_score")
    assert marks["ada"]["double-by-hand"] == 1


def test_an_exercise_may_come_or_go(course: Path, regrade: Run) -> None:
    value = toy.source_notebook()
    value["cells"] = value["cells"][:4]
    toy.write(course / "solutions" / toy.NAME / f"{toy.NAME}.ipynb", value)
    status, out, _ = regrade()
    lines = [line.split() for line in out.splitlines()]
    assert status == 0 and ["ada", "apply", "10/10", "–", "-10"] in lines
    assert ["ada", "total", "16/20", "10/10", "-6"] in lines


def test_work_that_was_handed_in_anew_is_told_apart(course: Path, regrade: Run) -> None:
    path = toy.hand_in(course / "submitted", "bob", toy.answer()) / f"{toy.NAME}.ipynb"
    later = (course / "out" / "bob" / f"{toy.NAME}.json").stat().st_mtime + 5
    os.utime(path, (later, later))
    anew = {one["student"]: one["handed_in_anew"] for one in changes(regrade)["changes"]}
    assert anew == {"ada": False, "bob": True, "eve": False}
    assert "handed in anew since it was graded" in regrade()[1]


def test_a_submission_that_is_gone_is_named_and_its_mark_stays(course: Path, regrade: Run) -> None:
    shutil.rmtree(course / "submitted" / "eve")
    status, out, _ = regrade("--apply")
    assert status == 0 and "left out, for there is no submission of theirs: eve" in out
    assert toy.result(course / "out", "eve")["score"] == 6


def test_where_the_grader_fails_the_mark_stays(
    course: Path, regrade: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.rmtree(course / "out" / regrading.FOLDER_NAME)
    # Student code runs in other processes, which a patch does not reach: their answers do.
    every = batch._grade_all
    failed = without_grade("failed", "why", student="ada", assignment=toy.NAME, max_score=20)

    def fails(*arguments: Any) -> Iterator[tuple[batch.Task, results.Result]]:
        for task, result in every(*arguments):
            yield task, failed if task.job.student == "ada" else result

    monkeypatch.setattr(batch, "_grade_all", fails)
    status, out, _ = regrade("--apply")
    assert status == 1 and "the grader failed on ada: the mark stays as it is" in out
    assert toy.result(course / "out", "ada")["score"] == 16
    assert toy.result(course / "out", "eve")["score"] == 10


def test_a_kill_while_applying_is_made_good_by_the_same_command(
    course: Path, regrade: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as killed:
        killed.setattr("robust_slam_autograder.commands.grade.record", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            regrade("--apply")
    assert toy.result(course / "out", "ada")["score"] == 20
    told = changes(regrade, "--apply")["gradebook"]
    assert [(row["student"], row["after"]) for row in told] == [("ada", 20), ("eve", 10)]
    rows = course_of.rows(course / "out" / "gradebook.db", "auto_score")
    assert sum(rows["ada"].values()) == 20


def test_a_name_in_brackets_is_no_pattern(tmp_path: Path) -> None:
    name = "07-toy[draft]"
    toy.write(tmp_path / "solutions" / name / "07-toy.ipynb", toy.source_notebook())
    (tmp_path / "submitted" / "ada" / name).mkdir(parents=True)
    results.write(
        tmp_path, without_grade("failed", "", student="ada", assignment=name, max_score=1)
    )
    journal.open_run(tmp_path, 1)
    plan = regrading.plan(
        tmp_path / "solutions", name, out=tmp_path, submitted=tmp_path / "submitted"
    )
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
def test_what_cannot_be_regraded_is_refused(
    course: Path, regrade: Run, spoil: Callable[[Path], object], words: str
) -> None:
    spoil(course)
    status, out, err = regrade("--apply")
    assert status == 2 and words in err and out == ""
