"""The doors of the Makefile leave a real class alone, and say what they do.

Those that workflows go through are there, and open.
"""

import os
import re
import shutil
import subprocess
from collections.abc import Mapping
from pathlib import Path

import pytest
from robust_slam.files import datasets
from robust_slam_autograder import cli
from robust_slam_autograder.ci.workflows import WORKFLOWS, template

from autograder.tests import toy
from autograder.tests.as_user import ROOT
from autograder.tests.ci.running import Runner, repository, scripts
from solutions.classes import answers, sample_class
from tests import needs


@pytest.fixture
def course(tmp_path, monkeypatch):
    """A small course with the doors of this one."""
    for name in ("Makefile", "instructor.mk", ".gitignore"):
        shutil.copy(ROOT / name, tmp_path)
    toy.make_tree(tmp_path)
    repository(tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def make(course: Path, *goals: str) -> subprocess.CompletedProcess[str]:
    options = {"capture_output": True, "text": True, "timeout": 60}
    return subprocess.run(["make", *goals], cwd=course, check=False, **options)


def contents(folder: Path) -> Mapping[str, bytes]:
    files = (path for path in sorted(folder.rglob("*")) if path.is_file())
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def test_a_graded_class_survives_make_clean_and_git_ignores_it(course):
    toy.hand_in(course / "class" / "submitted", "ada", toy.answer())
    grade = ["grade", f"class/submitted/ada/{toy.NAME}", *toy.quickly()]
    for command in (grade, ["feedback"], ["report"], ["release"]):
        assert cli.main(command) == 0
    before = contents(course / "class")
    assert before.keys() >= {
        f"submitted/ada/{toy.NAME}/{toy.NAME}.ipynb",
        f"graded/ada/{toy.NAME}.json",
        "graded/.run.json",
        "graded/gradebook.db",
        f"feedback/ada/{toy.NAME}.html",
        "report/index.html",
    }
    assert list((course / "build").iterdir()) == [course / "build" / "release"]
    untracked = ["git", "ls-files", "--others", "--exclude-standard", "class", "build"]
    assert subprocess.run(untracked, cwd=course, capture_output=True, check=True).stdout == b""
    done = make(course, "clean")
    assert done.returncode == 0, done.stderr
    assert not (course / "build").exists()
    assert contents(course / "class") == before


def test_make_clean_refuses_to_delete_results_of_the_old_layout(course):
    (course / "build" / "graded" / "ada").mkdir(parents=True)
    (course / "build" / "graded" / "ada" / "07-toy.json").write_text("{}")
    (course / "build" / "submitted").mkdir()
    (course / ".venv").mkdir()
    before = contents(course)
    done = make(course, "clean")
    assert done.returncode != 0 and contents(course) == before and (course / ".venv").exists()
    (move,) = re.findall(r"^  (mkdir .+)$", done.stdout, re.M)
    subprocess.run(["sh", "-ec", move], cwd=course, check=True)
    assert make(course, "clean").returncode == 0
    assert (course / "class" / "graded" / "ada" / "07-toy.json").read_text() == "{}"
    assert (course / "class" / "submitted").is_dir() and not (course / "build").exists()


@pytest.mark.parametrize(
    ("goal", "made"),
    [("grade-sample", "build/sample/.submitted"), ("build/shown/.pages", "build/.misconceptions")],
)
def test_the_sample_classes_reach_no_shared_gradebook(course, goal, made):
    """Were its address not emptied, the sample's marks would stand among real ones."""
    probe = course / "probe.mk"
    probe.write_text(f"include Makefile\n{goal}: ; @echo [$$ROBUST_SLAM_GRADEBOOK]\n")
    environment = os.environ | {"ROBUST_SLAM_GRADEBOOK": "postgresql://db.example.edu/grades"}
    (course / "build" / "shown").mkdir(parents=True)
    # What comes before is not made, and what this small course lacks is not missed.
    others = ["build/.sandbox", made, "solutions/classes/shown_class.py", "_config.yml"]
    done = subprocess.run(
        ["make", "-f", "probe.mk", *(word for name in others for word in ("-o", name)), goal],
        cwd=course, env=environment, capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("works", [True, False])
def test_the_sample_is_graded_without_a_sandbox_only_where_none_works(course, works):
    tool = course / ".venv" / "bin" / "autograder"
    tool.parent.mkdir(parents=True)
    tool.write_text(f"#!/bin/sh\nexit {0 if works else 1}\n")
    tool.chmod(0o755)
    done = make(course, "-o", ".venv/.ready", "build/.sandbox")
    assert done.returncode == 0, done.stderr
    assert (course / "build" / ".sandbox").read_text() == ("" if works else "--unsandboxed\n")
    assert ("No sandbox works here" in done.stdout) != works


def test_the_table_of_the_sample_has_a_line_for_each_student():
    marks = [
        {"student": "ada", "assignment": "00-one", "status": "graded", "score": 5, "max_score": 9},
        {"student": "ada", "assignment": "01-two", "status": "refused", "score": 0},
        {"student": "ben", "assignment": "01-two", "status": "graded", "score": 7, "max_score": 7},
    ]
    lines = sample_class.table({"submissions": marks}).splitlines()
    table = [["00", "01"], ["ada", "5/9", "refused"], ["ben", "7/7"]]
    assert [line.split() for line in lines] == table
    assert len({len(line) for line in lines}) == 1


@pytest.mark.parametrize("uid", [0, 1000])
def test_what_apt_would_install_is_said_before_it_runs(tmp_path, uid):
    for name in ("sh", "ls"):
        (tmp_path / name).symlink_to(shutil.which(name) or "")
    commands = {"id": f"echo {uid}", "sudo": "exit 1", "apt-get": f"touch {tmp_path}/ran"}
    for name, script in commands.items():
        (tmp_path / name).write_text(f"#!/bin/sh\n{script}\n")
        (tmp_path / name).chmod(0o755)
    done = subprocess.run(
        [tmp_path / "sh", ROOT / "tests" / "system-packages.sh", "plan", "all"],
        env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=True, timeout=60,
    )  # fmt: skip
    assert "chromium-headless-shell gnupg" in done.stdout
    assert ("installs with apt" in done.stdout) == (uid == 0)
    assert ("sudo apt-get install" in done.stdout) == (uid != 0)
    assert not (tmp_path / "ran").exists()


def test_make_test_says_what_it_installs_before_it_does():
    said = make(ROOT, "--dry-run", "test").stdout
    first = said.index("make test sets up")
    assert first < said.index("It installs the") < said.index("system-packages setup-dev")
    assert said.index("system-packages setup-dev") < said.index("tests.needs test")
    packages = make(ROOT, "--dry-run", "system-packages").stdout
    assert packages.index("system-packages.sh plan") < packages.index("system-packages.sh install")


def test_strict_ends_at_once_where_something_is_missing(monkeypatch, capsys):
    monkeypatch.setenv("PATH", os.devnull)
    monkeypatch.setattr(datasets, "is_here", lambda name: False)
    missing = {"quick": ["graphs"], "test": ["chromium"], "rest": ["firefox", "gpg"]}
    for depth, words in missing.items():
        assert needs.main([depth]) == 0
        said = capsys.readouterr().out
        assert all(word in said for word in words) and "graphs" in said
        assert ("firefox" in said) == (depth == "rest")
        assert needs.main([depth, "--strict"]) == 1
        assert "nothing was run" in capsys.readouterr().out


OWN = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
TEMPLATES = [template("github-course.yml"), template("github-grading.yml")]


@pytest.mark.parametrize("text", [*TEMPLATES, *(path.read_text("utf-8") for path in OWN)])
def test_every_make_target_that_a_workflow_names_is_there(text):
    doors = re.findall(r'(?:run:|then) make (-C (?:build/public|"\$site") )?([\w-]+)', text)
    makefiles = [(ROOT / file).read_text("utf-8") for file in ("Makefile", "instructor.mk")]
    assert doors
    for in_public, door in doors:
        # The public course has no instructor's doors.
        found = "".join(makefiles[:1] if in_public else makefiles)
        assert re.search(rf"^{door}:", found, re.MULTILINE), door


@pytest.mark.soak
@pytest.mark.sandbox
def test_this_course_grades_and_publishes_in_a_fresh_clone(tmp_path, wall_name):
    """It installs everything anew."""
    name = answers.assignments()[0]
    known = {"inputs.submitted": "submitted", "inputs.assignment": name}
    machine = Runner(tmp_path / "machine", offline=False, known=known)
    machine.check_out(ROOT)
    submission = machine.clone / "submitted" / "ada" / name
    shutil.copytree(answers.SOLUTIONS / name, submission)
    said = []
    for target, job in (("github-grading", "grade"), ("github-course", "build")):
        command = ["--solutions", str(answers.SOLUTIONS), "init-ci", target]
        assert cli.main([*command, "--out", str(machine.clone)]) == 0
        for step in scripts(machine.clone / WORKFLOWS[target].place, job).values():
            script = step["run"]
            # Root's alone, the network's, or said by tests of their own.
            if re.search("sudo|exit 1$|make data|make test|marks.asc|book$", script.strip()):
                continue
            done = machine.run(step)
            assert done.returncode == 0, done.stdout + done.stderr
            said.append(script)
    assert {"make setup", "make public", ".venv/bin/autograder doctor"} < set(said)
    summary = machine.summary.read_text("utf-8")
    assert "✓ All checks passed" in summary and "ada" not in summary
    assert (machine.clone / "build" / "public" / "assignments" / name).is_dir()
