"""The sample class through nbgrader: formgrader's button in JupyterLab, and its command.

Both give the marks that the command line gives.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import Browser, FrameLocator, Page, expect
from robust_slam_autograder.grading import journal

from tests import jupyterlab, kernel, sample_class
from tests.assignments import answers
from tests.autograder.nbgrader import course as course_of
from tests.test_secrets import plain_lines, secret_lines

pytestmark = pytest.mark.long

BY_BUTTON, BY_COMMAND = "02-four-costs", "03-irls"

Marks = dict[str, dict[str, float]]


@dataclass(frozen=True)
class Class:
    """A course with the sample class's submissions, and where the command line graded them."""

    course: Path
    alone: Path


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory, wall_name: str) -> Class:
    kernel.working(wall_name)
    course = tmp_path_factory.mktemp("class")
    shutil.copytree(answers.SOLUTIONS, course / "solutions")
    (course / "solutions" / "course.toml").unlink()  # what students install is not tested here
    (course / "autograder").mkdir()
    shutil.copy(course_of.ROOT / "autograder" / "nbgrader_config.py", course / "autograder")
    used = [BY_BUTTON, BY_COMMAND]
    assert course_of.autograder(course, "release", *used).returncode == 0
    released, submitted = course / "build" / "release", course / "class" / "submitted"
    paths = sample_class.write(released, submitted, used)
    where = ("--out", "alone", "--seed", course_of.SEED, "--sandbox", wall_name)
    done = course_of.autograder(course, "grade", *paths, *where)
    assert done.returncode == 0, done.stderr
    journal.open_run(course / "class" / "graded", course_of.SEED)
    return Class(course, course / "alone")


def marks(database: Path, assignment: str) -> Marks:
    return course_of.rows(database, "score", assignment)


def check_marks(sample: Class, assignment: str) -> None:
    """The gradebook has the whole class, with the command line's marks, case by case."""
    found = marks(course_of.database(sample.course), assignment)
    assert found == marks(sample.alone / "gradebook.db", assignment)
    totals = {student: sum(cases.values()) for student, cases in found.items()}
    assert totals.keys() == set(sample_class.STUDENTS)
    results = sample.alone / "sample-solutions" / f"{assignment}.json"
    assert totals["sample-solutions"] == json.loads(results.read_text("utf-8"))["max_score"] > 0
    assert 0 < totals["sample-half"] < totals["sample-solutions"]
    assert totals["sample-untouched"] == totals["sample-broken"] == 0


@pytest.mark.sandbox
def test_the_command_gives_the_command_lines_marks(sample: Class, wall_name: str) -> None:
    for arguments in (
        ("generate_assignment", BY_COMMAND, "--force"),
        ("autograde", BY_COMMAND, f"--SafeExporter.sandbox={wall_name}"),
        ("generate_feedback", BY_COMMAND),
    ):
        done = course_of.nbgrader(sample.course, *arguments)
        assert done.returncode == 0, done.stderr
    check_marks(sample, BY_COMMAND)
    for student in ("sample-untouched", "sample-broken"):
        name = f"{BY_COMMAND}.html"
        page = sample.course / "class" / "feedback" / student / BY_COMMAND / name
        lines = plain_lines(page, page.read_text("utf-8"))
        assert len(lines) > 100 and not lines & secret_lines(BY_COMMAND)


@pytest.fixture
def lab(sample: Class) -> Iterator[str]:
    """The address of a JupyterLab in the course, started as the grader's README says."""
    with jupyterlab.running(sample.course, course_of.environment(sample.course)) as address:
        yield address


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    with jupyterlab.page_of(browser) as made:
        yield made


def open_formgrader(page: Page, lab: str) -> FrameLocator:
    page.goto(f"{lab}/lab?token={jupyterlab.TOKEN}")
    page.get_by_role("menuitem", name="Nbgrader").click()
    page.get_by_role("menuitem", name="Formgrader", exact=True).first.click()
    return page.frame_locator("iframe")


def autograde(formgrader: FrameLocator, student: str) -> str:
    """Press a student's button; gives what formgrader says."""
    formgrader.locator("tr", has_text=student).locator(".autograde a").click()
    modal = formgrader.locator(".modal")
    modal.locator("pre").first.wait_for()
    said = modal.inner_text()
    modal.get_by_role("button", name="OK").click()
    modal.wait_for(state="detached")
    return said


@pytest.mark.browser
@pytest.mark.sandbox
def test_formgraders_button_gives_the_command_lines_marks(
    sample: Class, lab: str, page: Page, tmp_path: Path
) -> None:
    formgrader = open_formgrader(page, lab)
    formgrader.locator("tr", has_text=BY_BUTTON).locator(".num-submissions a").click()
    for student in sample_class.STUDENTS:
        assert "Successfully autograded" in autograde(formgrader, student)
    page.screenshot(path=tmp_path / "submissions.png")
    check_marks(sample, BY_BUTTON)

    found = marks(course_of.database(sample.course), BY_BUTTON)
    most = sum(found["sample-solutions"].values())
    for student, cases in found.items():
        row = formgrader.locator("tr", has_text=student)
        expect(row.locator(".status")).to_have_text("graded")
        expect(row.locator(".score")).to_have_text(f"{sum(cases.values()):g} / {most:g}")
    formgrader.locator("tr", has_text="sample-half").locator(".student-name a").click()
    formgrader.locator("tr a", has_text=BY_BUTTON).first.click()
    expect(formgrader.get_by_text("✓ passed").first).to_be_visible()
    expect(formgrader.get_by_text("✗ failed").first).to_be_visible()
    assert "HIDDEN TESTS" not in formgrader.locator("body").inner_text()
    page.screenshot(path=tmp_path / "submission.png")
