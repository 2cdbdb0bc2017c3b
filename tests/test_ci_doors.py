"""The workflows of the private repository go through doors that are there, and that open."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.ci.workflows import WORKFLOWS, template

from tests.as_user import ROOT
from tests.assignments import answers
from tests.autograder.ci import running

OWN = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
TEMPLATES = [template("github-course.yml"), template("github-grading.yml")]


@pytest.mark.parametrize("text", [*TEMPLATES, *(path.read_text("utf-8") for path in OWN)])
def test_every_make_target_that_a_workflow_names_is_there(text: str) -> None:
    doors = re.findall(r'(?:run:|then) make (-C (?:build/public|"\$site") )?([\w-]+)', text)
    makefiles = [(ROOT / file).read_text("utf-8") for file in ("Makefile", "instructor.mk")]
    assert doors
    for in_public, door in doors:
        # The public course has no instructor's doors.
        found = "".join(makefiles[:1] if in_public else makefiles)
        assert re.search(rf"^{door}:", found, re.MULTILINE), door


@pytest.mark.soak
@pytest.mark.sandbox
def test_this_course_grades_and_publishes_in_a_fresh_clone(tmp_path: Path, wall_name: str) -> None:
    """It installs everything anew."""
    name = answers.assignments()[0]
    known = {"inputs.submitted": "submitted", "inputs.assignment": name}
    machine = running.Runner(tmp_path / "machine", offline=False, known=known)
    machine.check_out(ROOT)
    submission = machine.clone / "submitted" / "ada" / name
    shutil.copytree(answers.SOLUTIONS / name, submission)
    said = []
    for target, job in (("github-grading", "grade"), ("github-course", "build")):
        command = ["--solutions", str(answers.SOLUTIONS), "init-ci", target]
        assert cli.main([*command, "--out", str(machine.clone)]) == 0
        for step in running.scripts(machine.clone / WORKFLOWS[target].place, job).values():
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
