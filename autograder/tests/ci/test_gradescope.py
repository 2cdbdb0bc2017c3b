"""The archive for Gradescope: unpacked, set up, run, and its results read as documented."""

import json
import re
import shutil
import sysconfig
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest import mock

import jsonschema
import numpy as np
import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.ci import gradescope
from robust_slam_autograder.ci.gradescope import as_gradescope
from robust_slam_autograder.executor import seeds
from robust_slam_autograder.grading import batch
from robust_slam_autograder.grading.results import ExerciseResult, ExerciseStatus
from robust_slam_autograder.sandbox import Unsandboxed, landlock

from .. import as_user, kernel, toy
from ..as_user import GRADER
from ..kernel import leave_out
from ..publishing import world
from ..reports.samples import case, exercise, result
from . import running

pytestmark = [pytest.mark.long, pytest.mark.rest]

SCHEMA = json.loads(Path(__file__).with_name("gradescope_schema.json").read_text("utf-8"))
"""Gradescope's format: https://gradescope-autograders.readthedocs.io/en/latest/specs/."""
AS_IN_DOCKER = ("setpriv", "--bounding-set=-sys_admin,-sys_ptrace,-sys_resource", "--")
"""Docker's root lacks these rights, and more that the grader does not use."""
CURIOUS = f'''\
import os
from pathlib import Path

def double(x):
    """Look around for what the container holds, and tell."""
    root = Path("ROOT")
    notebook = "source/solutions/{toy.NAME}/{toy.NAME}.ipynb"
    for name in ("source/seed", notebook, "submission_metadata.json"):
        try:
            return len((root / name).read_text())
        except OSError:
            pass
    try:
        (root / "results" / "results.json").write_text('{{"score": 100}}')
    except OSError:
        pass
    return 2 * np.asarray(x)
'''


@pytest.fixture(scope="module")
def archive(tmp_path_factory):
    """The toy's archive, from a course that carries the grader."""
    root = tmp_path_factory.mktemp("course")
    tree = world.make(root)
    done = as_user.ended(["git", "-C", GRADER, "ls-files", "-z"])
    # Where the course is in no repository, as the public one may be, the folder itself.
    known = [name for name in done.stdout.split("\0") if name]
    for name in known or [str(path.relative_to(GRADER)) for path in GRADER.rglob("*")]:
        if (GRADER / name).is_file() and not re.search(r"__pycache__|\.venv", name):
            target = root / "autograder" / name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(GRADER / name, target)
    install = '[install.assignments]\nrobust-slam-autograder = "autograder"\n'
    world.write(root, "solutions/course.toml", install)
    world.track(root)
    out = tmp_path_factory.mktemp("outside")
    labels = ["--misconceptions", str(tmp_path_factory.mktemp("labels"))]
    make = ["init-ci", "gradescope", *labels, "--out", str(out)]
    for command in (["misconceptions", "--to", labels[1]], make):
        assert cli.main(["--solutions", str(tree), *command]) == 0
    return out / f"{toy.NAME}.zip"


@pytest.fixture(scope="module")
def container(archive, request):
    """``/autograder`` when the image is built; in ``make soak`` it installs from the network."""
    offline = not kernel.is_soak(request.config)
    # Not among pytest's own folders, which other users may not enter.
    root = Path(tempfile.mkdtemp(prefix="gradescope-")) / "autograder"
    root.parent.chmod(0o755)
    request.addfinalizer(lambda: shutil.rmtree(root.parent))
    source = root / "source"
    with zipfile.ZipFile(archive) as opened:
        opened.extractall(source)
        for entry in opened.infolist():
            (source / entry.filename).chmod(entry.external_attr >> 16 & 0o777)
    shutil.copy(source / "run_autograder", root)
    for name in ("results", "submission"):
        (root / name).mkdir()
    runner = running.Runner(root.parent / "runner", offline=offline, with_python=False)
    done = as_user.ended(["bash", source / "setup.sh"], cwd=root, env=runner.environment())
    assert done.returncode == 0, done.stdout + done.stderr
    (site,) = (root / "python").glob("lib/python*/site-packages")
    installed = site / "robust_slam_autograder" / "ci" / "templates" / "gradescope" / "setup.sh"
    assert installed.is_file()
    if offline:
        shutil.rmtree(site)
        site.symlink_to(sysconfig.get_path("purelib"))
    return root


@pytest.fixture
def submit(container):
    """Hand in a notebook, and give what Gradescope then reads."""

    def run(value: dict[str, Any], *, before: Sequence[str] = ()) -> dict[str, Any]:
        shutil.rmtree(container / "submission")
        toy.write(container / "submission" / f"{toy.NAME}.ipynb", value)
        (container / "submission_metadata.json").write_text('{"users": [{"name": "Ada"}]}')
        found = container / "results" / "results.json"
        found.unlink(missing_ok=True)
        words = [*before, str(container / "run_autograder")]
        words = as_user.command(words, uid=0) if before else words
        variables = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/"}
        done = as_user.ended(words, cwd=container, env=variables)
        assert done.returncode == 0, done.stderr
        value: dict[str, Any] = json.loads(found.read_text("utf-8"))
        jsonschema.validate(value, SCHEMA)
        return value

    return run


def curious(container: Path) -> dict[str, Any]:
    """A submission that looks around, and is wrong where it finds something."""
    source = CURIOUS.replace("ROOT", str(container))
    names: dict[str, Any] = {"np": np}
    exec(source, names)
    assert names["double"](3) != 6, "without a wall there is something to find"
    return toy.answer(double=source)


@pytest.mark.sandbox
@pytest.mark.parametrize("before", [(), AS_IN_DOCKER], ids=["root", "as in docker"])
def test_student_code_sees_neither_tests_nor_seed_and_writes_no_marks(
    submit, container, wall_name, before
):
    """Its image is set up first: an environment into which pip installs the grader."""
    if before and not as_user.may():
        leave_out("only root can give rights away")
    if before and landlock.version() == 0:
        leave_out("this kernel has no Landlock")
    value = submit(curious(container), before=before)
    assert value["score"] == toy.MOST
    assert sum(test["max_score"] for test in value["tests"]) == toy.MOST
    shown = {test["name"]: test["visibility"] for test in value["tests"]}
    assert shown == {
        "double: by-hand": "visible",
        "double: random": "after_published",
        "apply: by-hand": "visible",
        "apply: twice": "after_published",
    }


@pytest.mark.sandbox
def test_a_wrong_answer_and_a_broken_notebook_are_told_without_a_hidden_input(
    submit, container, wall_name
):
    value = submit(toy.answer(double="def double(x):\n    return np.sqrt(2 * np.abs(x))\n"))
    assert value["score"] == toy.MOST - 10
    seen, failed = [test for test in value["tests"] if test.get("status") == "failed"]
    assert seen["visibility"] == "visible"
    assert failed["visibility"] == "after_published"
    assert failed["output"] == "Try negative numbers."
    (told,) = [test for test in value["tests"] if test["name"] == "double: what it looks like"]
    root = "what comes back is the square root of what it should be"
    assert told["output"] == f"It looks as if {root}."
    assert told["visibility"] == "visible" and "score" not in told
    data = (container / "submission" / f"{toy.NAME}.ipynb").read_bytes()
    seed = seeds.of_submission(int((container / "source" / "seed").read_text()), data)
    assert not [text for text in toy.hidden_inputs(seed) if text in json.dumps(value)]
    assert toy.CANARY not in json.dumps(value)
    refused = submit({"no": "notebook"})
    assert refused["score"] == 0 and refused["tests"] == []
    assert refused["output"].startswith("Not graded: ")


def test_the_archives_secret_is_the_batchs(tmp_path, monkeypatch):
    toy.make_tree(tmp_path / "source")
    (tmp_path / "source" / "seed").write_text("7\n")
    toy.write(tmp_path / "submission" / "a.ipynb", toy.answer())
    monkeypatch.setattr("robust_slam_autograder.sandbox.BACK_ENDS", {"none": Unsandboxed()})
    with mock.patch.object(batch, "grade", side_effect=batch.grade) as graded:
        assert gradescope.main(tmp_path) == 0
    assert graded.call_args.args[1].seed == 7


def test_where_no_sandbox_works_there_is_no_mark(tmp_path, monkeypatch, capsys):
    toy.make_tree(tmp_path / "source")
    (tmp_path / "source" / "seed").write_text("7\n")
    toy.write(tmp_path / "submission" / "a.ipynb", toy.answer())
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "results.json").write_text('{"score": 20}')
    monkeypatch.setattr("robust_slam_autograder.sandbox.BACK_ENDS", {"broken": toy.Broken()})
    assert gradescope.main(tmp_path) == 1
    assert not (tmp_path / "results" / "results.json").exists()
    assert "No sandbox works here (broken: it is not installed)" in capsys.readouterr().err


def double(status: ExerciseStatus, message: str) -> ExerciseResult:
    cases = (
        case("by-hand", points=4, visible=True),
        case("random", "Try \u202enegative numbers.", points=6),
    )
    return exercise("double", status, *cases, message=message)


def test_before_marks_are_published_nothing_of_hidden_inputs_shows():
    value = as_gradescope(result(double("timeout", "Took longer than 10 s."), seconds=3.25))
    jsonschema.validate(value, SCHEMA)
    shown = [test for test in value["tests"] if test["visibility"] == "visible"]
    before = json.dumps([value["output"], shown])
    assert "timeout" not in before and "longer" not in before and "negative" not in before
    assert "3.25" not in json.dumps(value) and "ada" not in json.dumps(value)
    assert "execution_time" not in value and value["stdout_visibility"] == "hidden"
    assert "\\u202enegative" in value["tests"][1]["output"]
    # Students see no total while a test is hidden, says the format.
    assert any(test["visibility"] != "visible" for test in value["tests"])


def test_a_failed_case_of_no_points_is_failed():
    free = exercise("free", "failed", case("first", "Look.", points=0, visible=True))
    (test,) = as_gradescope(result(free))["tests"]
    assert (test["status"], test["score"], test["max_score"]) == ("failed", 0, 0)


def test_an_absent_answer_is_told_at_once():
    absent = result(double("missing", "There is no cell double."))
    output = as_gradescope(absent)["output"]
    assert re.search("^double: The notebook holds no answer", output)
