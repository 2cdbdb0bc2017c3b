"""The workflows of the private repository go through doors that are there."""

from __future__ import annotations

import re

import pytest
from robust_slam_autograder.ci.workflows import template

from tests.as_user import ROOT


@pytest.mark.parametrize("name", ["github-course.yml", "github-grading.yml"])
def test_every_door_that_a_workflow_names_is_there(name: str) -> None:
    doors = re.findall(r"run: make (-C build/public )?(\w+)", template(name))
    makefiles = [(ROOT / file).read_text("utf-8") for file in ("Makefile", "instructor.mk")]
    assert doors
    for in_public, door in doors:
        # The public course has no instructor's doors.
        found = "".join(makefiles[:1] if in_public else makefiles)
        assert re.search(rf"^{door}:", found, re.MULTILINE), door
