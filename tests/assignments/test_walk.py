"""A released assignment in JupyterLab: wrong answers are told so, right ones pass every check."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Browser
from robust_slam_autograder.publishing.student_release import release

from tests import jupyterlab
from tests.assignments import answers, walk
from tests.assignments.walk import check

pytestmark = pytest.mark.long

NAME = "03-irls"


@pytest.mark.browser
def test_wrong_answers_are_told_and_right_ones_pass(browser: Browser, tmp_path: Path) -> None:
    release(answers.SOLUTIONS, [NAME], tmp_path / "release")
    place = tmp_path / "release" / NAME
    variables = jupyterlab.environment(tmp_path / "home")
    with jupyterlab.running(place, variables) as address, jupyterlab.page_of(browser) as page:
        *said, last = walk.walk(page, address, place / f"{NAME}.ipynb", tmp_path)
    wrong = walk.wrong_answers(NAME).values()
    stopped = {answer.caught_by for answer in wrong if answer.is_visible}
    told = {line.split(":")[0].strip() for line in said if line.startswith("  ")}
    assert stopped and stopped <= told
    assert last.startswith("right answers: every check passes")
    assert check(place / f"{NAME}.ipynb").startswith("All visible cases passed; ")
