"""The command line: what a path means, exit statuses, and messages that name the fix."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from robust_slam_autograder import cli, sandbox
from robust_slam_autograder.commands import grade as grade_command
from robust_slam_autograder.nbgrader import database
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading.submission import DATABASE_NAME

from tests.autograder import toy

RIGHT = "def double(x):\n    return 2 * np.asarray(x)\n"
WRONG = "def double(x):\n    return x\n"
Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def course(tmp_path: Path) -> Path:
    """A folder with a source tree, and one submission."""
    toy.make_tree(tmp_path)
    toy.hand_in(tmp_path / "submitted", "ada", toy.answer())
    return tmp_path


@pytest.fixture
def run(course: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Run a command on the course's tree: exit status, output, errors."""

    def command(*arguments: object) -> tuple[int, str, str]:
        try:
            status = cli.main(["--solutions", str(course / "solutions"), *map(str, arguments)])
        except SystemExit as error:  # how argparse ends
            status = int(error.code or 0)
        out, err = capsys.readouterr()
        return status, out, err

    return command


@pytest.fixture
def grade(course: Path, run: Run, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Grade paths without a wall and without a gradebook."""
    monkeypatch.setattr(grade_command, "record", lambda *arguments: None)
    where = ("--out", course / "out", "--unsandboxed", "--seed", 1)
    return lambda *arguments: run("grade", *where, *arguments)


def test_a_folder_says_student_and_assignment(course: Path, grade: Run) -> None:
    folder = course / "submitted" / "ada" / toy.NAME
    status, out, _ = grade(f"{folder}/", folder)
    assert status == 0
    assert out.splitlines()[:2] == [
        "student  assignment  mark",
        "ada      07-toy      20/20  all passed",
    ]
    assert toy.result(course / "out", "ada")["sandbox"] == "none"


def test_a_path_from_where_one_stands_works(
    course: Path, grade: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(course / "submitted" / "ada" / toy.NAME)
    status, out, _ = grade(".")
    assert status == 0 and "ada " in out


def test_a_notebook_is_its_stems(course: Path, grade: Run) -> None:
    path = toy.write(course / "inbox" / "Grace Hopper.ipynb", toy.answer())
    assert grade(path)[0] == 0
    assert toy.result(course / "out", "Grace Hopper")["score"] == 20
    assert grade(path, "--student", "grace")[0] == 0
    assert toy.result(course / "out", "grace")["score"] == 20


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["submitted/eve/07-toy"], "does not exist"),
        (["submitted/ada"], "name folders <student>/<assignment>/, or add --assignment"),
        (["submitted/ada/07-toy", "--assignment", "08"], "no assignment 08; there are 07-toy"),
        (["submitted/ada/07-toy/07-toy.ipynb"], "name that folder, or add --student"),
        (["submitted/ada/07-toy", "--student", "../eve"], "is no name for a student"),
        (["submitted/ada/07-toy", "--student", ".."], "is no name for a student"),
        (["submitted/ada/07-toy", "--student", "a\x1bb"], "is no name for a student"),
        (["submitted/ada/07-toy", "--student", "ä" * 101], "is no name for a student"),
        (["submitted/ada/07-toy", "--student", "gradebook.db"], "is no name for a student"),
        (["submitted/ada/07-toy", "--student", "gradebook.db-wal"], "is no name for a student"),
        (["submitted/ada/07-toy", "copy.ipynb", "--student", "ada"], "is handed in twice"),
        (["submitted/ada/07-toy", "--seed", "-1"], "a seed is a whole number"),
        (["submitted/ada/07-toy", "--seed", "x"], "a seed is a whole number"),
        (["submitted/ada/07-toy", "--jobs", "0"], "a whole number, 1 or more"),
        ([], "the following arguments are required: PATH"),
    ],
)
def test_wrong_use_is_told_and_nothing_graded(
    course: Path, grade: Run, monkeypatch: pytest.MonkeyPatch, arguments: list[str], sentence: str
) -> None:
    monkeypatch.chdir(course)
    toy.write(course / "copy.ipynb", toy.answer())
    status, out, err = grade(*arguments)
    assert status == 2 and sentence in err and out == ""
    assert not (course / "out").exists()


@pytest.mark.parametrize(
    "name", ["two\nlines", ".hidden", "a\u202eb", "ä" * 101, "a" * 129, "gradebook.db"]
)
def test_an_odd_folder_name_is_refused_and_the_batch_goes_on(
    course: Path, grade: Run, name: str
) -> None:
    odd = toy.hand_in(course / "submitted", name, toy.answer())
    status, out, _ = grade(odd, course / "submitted" / "ada" / toy.NAME)
    assert status == 0 and "1 graded, 1 refused" in out
    (stand_in,) = [path.name for path in (course / "out").glob("student-*")]
    assert "is no name for a student" in toy.result(course / "out", stand_in)["reason"]
    assert toy.result(course / "out", "ada")["score"] == toy.MOST
    assert grade(odd, "--student", "ben")[0] == 0
    assert toy.result(course / "out", "ben")["score"] == toy.MOST


def test_names_that_look_alike_are_two_students_and_are_named(course: Path, grade: Run) -> None:
    composed, decomposed = "Zo\u00eb", "Zoe\u0308"
    names = (composed, decomposed, "Zoe")
    paths = [toy.hand_in(course / "submitted", name, toy.answer()) for name in names]
    status, out, err = grade(*paths)
    assert status == 0 and "3 graded" in out
    assert "note: 'Zoe\\u0308' and 'Zo\\xeb' look alike and are graded apart" in err
    assert err.count("note:") == 1
    err = grade(*paths, "--no-names")[2]
    assert "note: 2 students' names look alike" in err and "Zo" not in err
    assert "note:" not in grade(*paths[1:])[2]


def test_a_draft_beside_the_submissions_is_left_out_and_named(course: Path, grade: Run) -> None:
    drafts = course / "submitted" / "ada" / "draft"
    drafts.mkdir()
    status, out, err = grade(course / "submitted" / "ada" / toy.NAME, drafts)
    assert status == 0 and "1 graded" in out
    assert f"left out: {drafts} does not say its assignment" in err
    err = grade(course / "submitted" / "ada" / toy.NAME, drafts, "--no-names")[2]
    assert "left out: path 2 of 2 does not say its assignment" in err and "ada" not in err


@pytest.mark.parametrize(
    ("paths", "complaint"),
    [
        (["ada/07-toy", "eve/07-toy"], "path 2 of 2 does not exist"),
        (["ada"], "path 1 of 1 does not say its assignment, or misspells it"),
        (["more/ada.ipynb"], "path 1 of 1 lies beside the folders"),
        (["ada/07-toy/07-toy.ipynb"], "path 1 of 1 lies in a submission's folder"),
    ],
)
def test_without_names_a_complaint_numbers_the_paths(
    course: Path, grade: Run, paths: list[str], complaint: str
) -> None:
    toy.write(course / "submitted" / "more" / "ada.ipynb", toy.answer())
    status, out, err = grade(*(course / "submitted" / path for path in paths), "--no-names")
    assert status == 2 and complaint in err
    assert not [name for name in ("ada", "eve") if name in out + err]


def test_a_reader_who_has_enough_is_no_error() -> None:
    command = [sys.executable, "-m", "robust_slam_autograder.cli", "doctor"]
    # The pipe's reading end is closed before anything is written.
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


def test_a_missing_source_tree_names_the_option(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    notebook = toy.write(tmp_path / "ada.ipynb", toy.answer())
    command = ["--solutions", str(tmp_path / "none"), "grade", str(notebook)]
    assert cli.main(command) == 2
    assert "autograder --solutions DIR" in capsys.readouterr().err


def test_without_a_sandbox_nothing_is_graded(
    course: Path, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sandbox, "BACK_ENDS", {"broken": toy.Broken()})
    path = course / "submitted" / "ada" / toy.NAME
    status, _, err = run("grade", path, "--out", course / "out")
    assert status == 2 and "--unsandboxed" in err


def test_a_refusal_is_a_result(course: Path, grade: Run) -> None:
    (course / "bad.ipynb").write_text("{")
    status, out, _ = grade(course / "bad.ipynb", course / "submitted" / "ada" / toy.NAME)
    assert status == 0
    assert "refused: bad.ipynb is not valid JSON" in out
    assert "1 graded, 1 refused, 0 failed" in out
    assert toy.result(course / "out", "bad")["status"] == "refused"


def test_a_place_that_cannot_be_written_is_named(course: Path, grade: Run) -> None:
    (course / "out").write_text("a file")
    status, _, err = grade(course / "submitted" / "ada" / toy.NAME)
    assert status == 2 and str(course / "out") in err


def test_a_failure_of_the_grader_is_status_1(course: Path, grade: Run) -> None:
    value = toy.source_notebook()
    value["cells"][0]["source"] = "1 / 0\n"
    toy.write(course / "solutions" / toy.NAME / f"{toy.NAME}.ipynb", value)
    status, out, _ = grade(course / "submitted" / "ada" / toy.NAME)
    assert status == 1
    assert "failed: The instructor's cell, set-up 1, fails: division by zero" in out


class TestSummaries:
    """``grade --json``, ``--markdown`` and ``--no-names``."""

    @pytest.fixture
    def both(self, course: Path, grade: Run) -> Run:
        """Grade two submissions, of which one is refused for its name's sake."""
        broken = course / "grace.ipynb"
        broken.write_text("{")
        paths = (course / "submitted" / "ada" / toy.NAME, broken)
        return lambda *arguments: grade(*paths, *arguments)

    def test_files_are_written_beside_the_table(self, course: Path, both: Run) -> None:
        where = course / "out" / "marks.json", course / "marks.md"
        status, out, _ = both("--json", where[0], "--markdown", where[1])
        assert status == 0 and "ada      07-toy      20/20  all passed" in out
        value = json.loads(where[0].read_text(encoding="utf-8"))
        assert value["counts"] == {"graded": 1, "refused": 1, "failed": 0, "kept": 0}
        assert [each["student"] for each in value["submissions"]] == ["ada", "grace"]
        assert "| `ada` | `07-toy` | 20/20 | ✓ All checks passed" in where[1].read_text("utf-8")

    def test_standard_output_is_the_summarys_own(self, both: Run) -> None:
        status, out, err = both("--json", "-")
        assert status == 0 and json.loads(out)["schema"] == 1
        assert "1 graded, 1 refused" in err
        assert both("--markdown", "-")[1].startswith("## Grading\n")

    def test_two_summaries_want_two_places(self, course: Path, both: Run) -> None:
        status, out, err = both("--json", "-", "--markdown", "-")
        assert status == 2 and "want two places" in err and out == ""
        assert not (course / "out").exists()

    @pytest.mark.parametrize("option", ["--json", "--markdown"])
    def test_a_place_that_cannot_be_written_is_told_before_grading(
        self, course: Path, both: Run, option: str
    ) -> None:
        mistyped = course / "maks" / "marks"
        status, out, err = both(option, mistyped)
        assert status == 2 and out == ""
        assert err == (
            f"autograder: There is no folder {mistyped.parent} for {option} {mistyped}: "
            "make it, or correct the path.\n"
        )
        assert both(option, course)[2].endswith("is a folder: name a file in it.\n")
        assert not mistyped.parent.exists() and not (course / "out").exists()

    def test_a_place_that_fails_after_grading_is_named(self, course: Path, both: Run) -> None:
        status, _, err = both("--json", "/dev/full")
        assert status == 1
        assert err.startswith("autograder: /dev/full cannot be written (No space left on device)")

    def test_without_names_no_output_has_one(self, course: Path, both: Run) -> None:
        where = course / "marks.json", course / "marks.md"
        status, out, err = both("--json", where[0], "--markdown", where[1], "--no-names")
        shown = [out.replace(str(course), ""), err, *(path.read_text("utf-8") for path in where)]
        assert status == 0
        assert not [text for text in shown for name in ("ada", "grace") if name in text]
        assert "07-toy      20/20  all passed" in out and "0/20   refused" in out

    def test_what_a_summary_says_follows_from_the_submissions_alone(
        self, course: Path, both: Run
    ) -> None:
        outs = [both("--json", "-", "--seed", seed)[1] for seed in (1, 2)]
        assert outs[0] == outs[1]


@pytest.mark.sandbox
def test_marks_reach_the_gradebook_once(course: Path, run: Run, wall_name: str) -> None:
    folder = course / "submitted" / "ada" / toy.NAME
    where = ("grade", folder, "--out", course / "out", "--sandbox", wall_name)
    database = course / "out" / "gradebook.db"
    assert run(*where)[0] == 0 and database.is_file()
    before = database.stat().st_mtime_ns
    assert "1 of them unchanged and reused" in run(*where)[1]
    assert database.stat().st_mtime_ns == before
    assert toy.result(course / "out", "ada")["sandbox"] == wall_name


def test_the_gradebook_follows_a_result_that_came_out_otherwise(course: Path, run: Run) -> None:
    dice = course / "dice"
    code = f"{RIGHT}if not __import__('os').path.exists({str(dice)!r}):\n    double = abs\n"
    folder = toy.hand_in(course / "submitted", "ada", toy.answer(code))
    out = course / "out"
    for points in (10, 20):
        assert run("grade", folder, "--out", out, "--unsandboxed")[0] == 0
        (out / "ada" / f"{toy.NAME}.json").unlink()
        dice.touch()
        with Gradebook(database.url_of(out / DATABASE_NAME)) as gradebook:
            assert gradebook.find_submission(toy.NAME, "ada").score == points


class TestCheck:
    def test_a_right_notebook_passes(self, course: Path, run: Run) -> None:
        path = course / "submitted" / "ada" / toy.NAME / f"{toy.NAME}.ipynb"
        status, out, _ = run("check", path)
        assert status == 0
        assert out.splitlines() == [
            f"Checking {path}: the visible cases in it.",
            "✓ passed   double (visible cases; hidden cases remain)",
            "All visible cases passed; hidden cases remain when it is graded.",
        ]

    def test_a_wrong_one_does_not(self, course: Path, run: Run) -> None:
        path = toy.write(course / "mine.ipynb", toy.answer(WRONG))
        status, out, _ = run("check", path)
        assert status == 1
        assert out.splitlines()[1:3] == [
            "✗ failed   double (by-hand): double(3) is 6: add the number to itself",
            "    Here, double(3) returned 3; expected 6.",
        ]
        assert "Visible cases passed in 0 of 1 exercises;" in out

    def test_a_file_that_is_no_notebook_is_wrong_use(self, course: Path, run: Run) -> None:
        (course / "mine.ipynb").write_text("{")
        status, _, err = run("check", course / "mine.ipynb")
        assert status == 2 and "not valid JSON" in err

    def test_a_path_that_names_no_notebook_is_told(self, course: Path, run: Run) -> None:
        missing = course / "missing.ipynb"
        sentences = {
            (missing,): f"{missing} does not exist: name the notebook to check.",
            (course,): f"{course} is a folder: name the notebook in it.",
        }
        for arguments, sentence in sentences.items():
            assert run("check", *arguments) == (2, "", f"autograder: {sentence}\n")

    def test_other_places_that_are_not_there_are_told(self, course: Path, run: Run) -> None:
        path, missing = toy.write(course / "mine.ipynb", toy.answer()), course / "none"
        status, out, err = run("check", path, "--markdown", missing / "summary.md")
        assert (status, out) == (2, "")
        assert f"There is no folder {missing} for --markdown" in err
        status, _, err = run("check", path, "--release", missing)
        assert status == 2 and f"There is no folder {missing}: --release DIR names" in err

    def test_the_release_has_the_original_tests(self, course: Path, run: Run) -> None:
        release(course / "solutions", [], course / "release")
        without_tests = toy.answer(WRONG)
        del without_tests["cells"][2]
        path = toy.write(course / f"{toy.NAME}.ipynb", without_tests)
        assert run("check", path)[0] == 2
        status, out, _ = run("check", path, "--release", course / "release")
        assert status == 1 and "✗ partial  double (by-hand)" in out
        assert "✓ passed   apply (visible cases; 1 hidden case remains)" in out
        assert "; 2 hidden cases remain when it is graded." in out
        other = shutil.move(path, course / "other.ipynb")
        status, _, err = run("check", other, "--release", course / "release")
        assert status == 2 and "has no release for other.ipynb" in err

    def test_copied_cells_and_magics_are_no_obstacle(self, course: Path, run: Run) -> None:
        value = toy.answer("%%time\n" + RIGHT)
        value["cells"].insert(2, value["cells"][1] | {"source": "!ls\n" + RIGHT, "id": "copy"})
        assert run("check", toy.write(course / "mine.ipynb", value))[0] == 0

    def test_its_summary_as_markdown_has_no_points(self, course: Path, run: Run) -> None:
        path, summary = toy.write(course / "mine.ipynb", toy.answer(WRONG)), course / "summary.md"
        assert run("check", path, "--markdown", summary)[0] == 1
        assert summary.read_text(encoding="utf-8").splitlines() == [
            "## Visible cases",
            "",
            "Visible cases passed in 0 of 1 exercises; hidden cases remain when it is graded.",
            "",
            "- ✗ failed `double` (`by-hand`): `double(3) is 6: add the number to itself "
            "Here, double(3) returned 3; expected 6.`",
        ]

    def test_modules_are_withheld_with_the_same_sentence(self, course: Path, run: Run) -> None:
        (course / "autograder.toml").write_text('withheld = ["xml.dom"]\n')
        path = toy.write(course / "mine.ipynb", toy.answer("import xml.dom\n" + RIGHT))
        status, out, _ = run("check", path)
        assert status == 1
        assert "xml.dom is withheld in this assignment: it holds the answer" in out

    def test_packages_are_refused_with_the_same_sentence(self, course: Path, run: Run) -> None:
        """Installed and in memory or not; what numpy itself imports goes on."""
        for module in ("networkx", "pytest"):
            path = toy.write(course / "mine.ipynb", toy.answer(f"import {module}\n" + RIGHT))
            status, out, _ = run("check", path)
            assert status == 1
            assert f"{module} is not available in this assignment, which allows numpy" in out
        (course / "autograder.toml").write_text('packages = ["numpy", "networkx"]\n')
        path = toy.write(course / "mine.ipynb", toy.answer("import networkx\n" + RIGHT))
        assert run("check", path)[0] == 0


def test_release_writes_each_assignment(course: Path, run: Run) -> None:
    status, out, _ = run("release", "--out", course / "release")
    assert status == 0
    released = course / "release" / toy.NAME
    assert out == f"released {released / toy.NAME}.ipynb ({released}.zip)\n"
    assert run("release", "08", "--out", course / "release")[0] == 2
