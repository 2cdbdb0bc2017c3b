"""The command line: what a path means, exit statuses, and messages that name the remedy."""

import json
import shutil
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import pytest
from nbgrader.api import Gradebook
from robust_slam_autograder import cli, sandbox
from robust_slam_autograder.nbgrader import database, recording
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading.submission import DATABASE_NAME

from .. import toy

WRONG = "def double(x):\n    return x\n"
NONE = "def apply(f, x, times):\n    raise NotImplementedError\n"
ADA = f"submitted/ada/{toy.NAME}"


@pytest.fixture(autouse=True)
def in_the_course(course, monkeypatch):
    monkeypatch.chdir(course)


@pytest.fixture
def grade(autograder, monkeypatch):
    monkeypatch.setattr(recording, "record_new", lambda *arguments: None)
    where = ("--out", "out", *toy.quickly(), "--seed", 1)
    return lambda *arguments: autograder("grade", *where, *arguments)


def score(student: str) -> int:
    return toy.result(Path("out"), student)["score"]


def test_it_tells_its_version(autograder, monkeypatch):
    version = metadata.version(cli.DISTRIBUTION)
    assert autograder("--version") == (0, f"autograder {version}\n", "")
    monkeypatch.setattr(cli, "DISTRIBUTION", "no-such-distribution")
    assert autograder("--version") == (0, "autograder (not installed)\n", "")


def test_a_folder_says_student_and_assignment(course, grade, monkeypatch):
    assert grade(f"{ADA}/", course / ADA).worked("1 graded")
    assert score("ada") == toy.MOST and toy.result(Path("out"), "ada")["sandbox"] in toy.quickly()
    monkeypatch.chdir(ADA)
    assert grade(".", "--out", course / "here")[0] == 0
    assert toy.result(course / "here", "ada")["score"] == toy.MOST


def test_a_notebook_is_the_work_of_the_student_in_its_name(course, grade):
    path = toy.write(course / "inbox" / "Grace Hopper.ipynb", toy.answer())
    assert grade(path)[0] == grade(path, "--student", "grace")[0] == 0
    assert score("Grace Hopper") == score("grace") == toy.MOST


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["submitted/eve/07-toy"], "does not exist"),
        (["submitted/ada"], "name folders <student>/<assignment>/, or add --assignment"),
        ([ADA, "--assignment", "08"], "no assignment 08; it has 07-toy"),
        ([f"{ADA}/07-toy.ipynb"], "name that folder, or add --student"),
        ([ADA, "--student", "../eve"], "is no name for a student"),
        ([ADA, "--student", "gradebook.db-wal"], "is no name for a student"),
        ([ADA, "copy.ipynb", "--student", "ada"], "is handed in twice"),
        ([ADA, "--seed", "-1"], "a seed is a whole number"),
        ([ADA, "--seed", "x"], "a seed is a whole number"),
        ([ADA, "--jobs", "0"], "a whole number, 1 or more"),
        ([ADA, "--json", "-", "--markdown", "-"], "want two places"),
        ([ADA, "--json", "maks/marks"], "There is no folder maks for --json maks/marks"),
        ([ADA, "--markdown", "submitted"], "is a folder: name a file in it"),
        ([ADA, "--solutions", "none"], "unrecognized arguments"),
        ([], "the following arguments are required: PATH"),
    ],
)
def test_wrong_use_grades_nothing(course, grade, arguments, sentence):
    toy.write(course / "copy.ipynb", toy.answer())
    assert grade(*arguments).refused(sentence)
    assert not Path("out").exists() and not Path("maks").exists()


def test_odd_folder_names_are_refused_and_the_batch_goes_on(course, grade):
    names = ("two\nlines", ".hidden", "a\u202eb", "ä" * 101, "a" * 129, "gradebook.db")
    odd = [toy.hand_in(course / "submitted", name, toy.answer()) for name in names]
    assert grade(*odd, ADA).worked(f"1 graded, {len(names)} refused")
    stand_ins = [path.name for path in Path("out").glob("student-*")]
    reasons = [toy.result(Path("out"), stand_in)["reason"] for stand_in in stand_ins]
    assert len(reasons) == len(names)
    assert all("is no name for a student" in reason for reason in reasons)
    assert grade(odd[0], "--student", "ben")[0] == 0
    assert score("ada") == score("ben") == toy.MOST


def test_names_that_look_alike_are_two_students_and_are_named(course, grade):
    names = ("Zo\u00eb", "Zoe\u0308", "Zoe")
    paths = [toy.hand_in(course / "submitted", name, toy.answer()) for name in names]
    status, out, err = grade(*paths)
    assert status == 0 and "3 graded" in out
    assert "note: 'Zoe\\u0308' and 'Zo\\xeb' look alike" in err and err.count("note:") == 1
    err = grade(*paths, "--no-names")[2]
    assert "note: 2 students' names look alike" in err and "Zo" not in err
    assert "note:" not in grade(*paths[1:])[2]


@pytest.mark.parametrize(
    ("paths", "complaint"),
    [
        (["ada/07-toy", "eve/07-toy"], "path 2 of 2 does not exist"),
        (["ada"], "path 1 of 1 does not say its assignment, or misspells it"),
        (["more/ada.ipynb"], "path 1 of 1 is beside the folders"),
        (["ada/07-toy/07-toy.ipynb"], "path 1 of 1 is in a submission's folder"),
    ],
)
def test_without_names_a_complaint_numbers_the_paths(course, grade, paths, complaint):
    toy.write(course / "submitted" / "more" / "ada.ipynb", toy.answer())
    status, out, err = grade(*(course / "submitted" / path for path in paths), "--no-names")
    assert status == 2 and complaint in err
    assert not [name for name in ("ada", "eve") if name in out + err]


def test_a_reader_that_closes_the_pipe_causes_no_traceback():
    command = [sys.executable, "-m", "robust_slam_autograder.cli", "doctor"]
    # The pipe's reading end is closed before anything is written.
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        assert process.stderr.read() == b""
    assert process.returncode == 1


def test_without_a_sandbox_nothing_is_graded(autograder, monkeypatch):
    monkeypatch.setattr(sandbox, "BACK_ENDS", {"broken": toy.Broken()})
    assert autograder("grade", ADA, "--out", "out").refused("--unsandboxed")


def test_a_place_that_cannot_be_written_is_named(course, grade):
    (course / "file").touch()
    assert grade(ADA, "--out", course / "file").refused(str(course / "file"))


def test_a_failure_of_the_grader_is_status_1(course, grade):
    toy.make_tree(course, value=toy.source_notebook(setup="1 / 0\n"))
    status, out, _ = grade(ADA)
    assert status == 1
    assert "failed: The instructor's cell, set-up 1, fails: division by zero" in out


class TestSummaries:
    """``grade --json``, ``--markdown`` and ``--no-names``."""

    @pytest.fixture
    def both(self, grade):
        """Grade two submissions, of which one is refused."""
        Path("grace.ipynb").write_text("{")
        return lambda *arguments: grade(ADA, "grace.ipynb", *arguments)

    def test_files_are_written_beside_the_table(self, both):
        status, out, _ = both("--json", "out/marks.json", "--markdown", "marks.md")
        assert status == 0 and "1 graded, 1 refused, 0 failed" in out
        assert "refused: grace.ipynb is not valid JSON" in out
        value = json.loads(Path("out/marks.json").read_text("utf-8"))
        assert value["counts"] == {"graded": 1, "refused": 1, "failed": 0, "kept": 0}
        assert [each["student"] for each in value["submissions"]] == ["ada", "grace"]
        assert "| `ada` | `07-toy` | 20/20 |" in Path("marks.md").read_text("utf-8")
        assert toy.result(Path("out"), "grace")["status"] == "refused"

    def test_standard_output_has_the_summary_alone(self, both):
        status, out, err = both("--json", "-")
        assert status == 0 and json.loads(out)["schema"] == 1
        assert "1 graded, 1 refused" in err
        assert both("--json", "-", "--seed", 2)[1] == out, "it depends on the submissions alone"
        assert both("--markdown", "-")[1].startswith("## Grading\n")

    def test_a_place_that_fails_after_grading_is_named(self, both):
        status, _, err = both("--json", "/dev/full")
        assert status == 1 and err.startswith("autograder: /dev/full cannot be written (No space")

    def test_without_names_no_output_has_one(self, course, both):
        status, out, err = both("--json", "marks.json", "--markdown", "marks.md", "--no-names")
        files = [Path(name).read_text("utf-8") for name in ("marks.json", "marks.md")]
        shown = [out.replace(str(course), ""), err, *files]
        assert status == 0
        assert not [text for text in shown for name in ("ada", "grace") if name in text]
        assert "20/20  all passed" in out and "0/20   refused" in out


@pytest.mark.sandbox
def test_marks_reach_the_gradebook_once(autograder, wall_name):
    where = ("grade", ADA, "--out", "out", "--sandbox", wall_name)
    gradebook = Path("out", DATABASE_NAME)
    assert autograder(*where)[0] == 0 and gradebook.is_file()
    before = gradebook.stat().st_mtime_ns
    assert "1 of them unchanged and reused" in autograder(*where)[1]
    assert gradebook.stat().st_mtime_ns == before
    assert toy.result(Path("out"), "ada")["sandbox"] == wall_name


def test_the_gradebook_follows_a_result_that_came_out_otherwise(course, autograder):
    dice, out = course / "dice", course / "out"
    code = f"{toy.RIGHT}if not __import__('os').path.exists({str(dice)!r}):\n    double = abs\n"
    toy.hand_in(course / "submitted", "ada", toy.answer(code))
    for points in (10, 20):
        assert autograder("grade", ADA, "--out", out, "--unsandboxed")[0] == 0
        (out / "ada" / f"{toy.NAME}.json").unlink()
        dice.touch()
        with Gradebook(database.url_of(out / DATABASE_NAME)) as gradebook:
            assert gradebook.find_submission(toy.NAME, "ada").score == points


class TestCheck:
    @pytest.fixture
    def check(self, autograder):
        """Check a notebook of these cells, under the assignment's name."""

        def run(value: dict[str, object], *arguments: object) -> tuple[int, str, str]:
            if not Path("autograder.toml").exists():
                Path("autograder.toml").write_text(toy.described())
            return autograder("check", toy.write(Path(f"{toy.NAME}.ipynb"), value), *arguments)

        return run

    def test_a_wrong_one_does_not_and_its_summary_says_the_same(self, check):
        status, out, _ = check(toy.answer(WRONG, NONE), "--markdown", "summary.md")
        said = "double(3) is 6: add the number to itself"
        assert (
            status == 1 and "✗ failed   apply (by-hand): " in out
        )  # the hidden case says nothing
        assert out.splitlines()[:3] == [
            f"Checking {toy.NAME}.ipynb: the visible cases of {Path.cwd().name}.",
            f"◐ partial  double (by-hand): {said}",
            "    Here, double(3) returned 3; expected 6.",
        ]
        summary = Path("summary.md").read_text("utf-8")
        assert f"◐ partial `double` (`by-hand`): `{said}`  \n  `Here, double(3)" in summary

    @pytest.mark.parametrize(
        ("arguments", "sentence"),
        [
            (["missing.ipynb"], "missing.ipynb does not exist: name the notebook to check."),
            (["."], "is a folder: name the notebook in it."),
            (["broken.ipynb"], "not valid JSON"),
            (["mine.ipynb", "--markdown", "none/x.md"], "There is no folder none for --markdown"),
            (["mine.ipynb", "--release", "none"], "There is no folder none: --release DIR names"),
            (["mine.ipynb"], "mine.ipynb stands alone: "),
            (["mine.ipynb", "--release", "solutions"], "solutions has none for it"),
        ],
    )
    def test_wrong_use_names_the_remedy(self, course, autograder, arguments, sentence):
        (course / "broken.ipynb").write_text("{")
        toy.write(course / "mine.ipynb", toy.answer())
        assert autograder("check", *arguments).refused(sentence)

    def test_the_release_has_the_original_tests(self, course, check, autograder):
        release(course / "solutions", [], course / "release")
        without_tests = toy.answer(WRONG)
        del without_tests["cells"][2]
        Path("autograder.toml").write_text("")
        assert check(without_tests)[0] == 2
        status, out, _ = check(without_tests, "--release", course / "release")
        assert status == 1 and "◐ partial  double (by-hand)" in out
        assert "✓ passed   apply (visible cases; 1 hidden case remains)" in out
        other = toy.write(course / "other.ipynb", without_tests)
        status, _, err = autograder("check", other, "--release", course / "release")
        holds = f"{course / 'release'} holds the releases of {toy.NAME}: name"
        assert status == 2 and holds in err
        assert f"autograder check other.ipynb --release {course / 'release' / toy.NAME}" in err
        assert autograder("check", other, "--release", course / "release" / toy.NAME)[0] == 1

    def test_another_assignments_notebook_is_no_wrong_answer(self, course, check, autograder):
        """Nor is it one in the grade, where it was marked 0 without a word."""
        triple = toy.cell("def triple(x): pass", "triple", solution=True)
        other = toy.notebook([toy.cell(toy.SETUP, "setup", locked=True), triple])
        assert check(other).refused("Nothing in this notebook is of")
        handed = toy.hand_in(course / "submitted", "bo", other)
        status, out, _ = autograder("grade", handed, "--out", "graded", *toy.quickly())
        assert status == 0 and "refused: Nothing in this notebook is of 07-toy, so it may" in out

    def test_a_notebook_whose_ending_is_in_capitals_is_graded(self, course, autograder):
        folder = toy.hand_in(course / "submitted", "bo", toy.answer())
        (file,) = folder.iterdir()
        plain = file.rename(course / "cy.IPYNB")
        shutil.copy(plain, folder / f"{toy.NAME}.IPYNB")
        how = ("--assignment", toy.NAME, "--out", "graded", *toy.quickly())
        status, out, err = autograder("grade", folder, plain, *how)
        assert (status, err) == (0, "") and out.count("20/20") == 2

    @pytest.mark.parametrize(
        ("module", "config", "said"),
        [
            ("xml.dom.pulldom", 'withheld = ["xml.dom"]', "xml.dom is withheld in this assi"),
            ("networkx", "", "networkx is not available in this assignment"),
            ("pytest", "", "pytest is not available in this assignment"),  # it is in memory
            ("networkx", 'packages = ["numpy", "networkx"]', None),
        ],
    )
    def test_what_a_notebook_may_import_is_as_when_it_is_graded(self, check, module, config, said):
        settings = toy.described()
        if "packages" in config:
            settings = settings.replace('packages = ["numpy"]', "")
        Path("autograder.toml").write_text(f"{config}\n{settings}")
        status, out, _ = check(toy.answer(f"import {module}\n{toy.RIGHT}"))
        assert status == (0 if said is None else 1) and (said or "") in out


def test_release_writes_each_assignment(course, autograder):
    status, out, _ = autograder("release", "--out", course / "release")
    assert status == 0
    released = course / "release" / toy.NAME
    assert out == f"released {released / toy.NAME}.ipynb ({released}.zip)\n"
    assert autograder("release", "08", "--out", course / "release")[0] == 2
