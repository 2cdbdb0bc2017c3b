"""A small class through formgrader in JupyterLab: its button gives the command line's marks.

``nbgrader autograde`` is tested beside it.
"""

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest
from playwright.sync_api import FrameLocator, Page, expect
from robust_slam_autograder import cli
from robust_slam_autograder.grading import journal
from robust_slam_autograder.publishing.student_release import release

from autograder.tests import toy
from autograder.tests.kernel import working
from autograder.tests.nbgrader import course as course_of
from tests import jupyterlab

pytestmark = [pytest.mark.long, pytest.mark.rest]

STUDENTS = {"broken": {"cells": "none"}, "half": toy.answer(toy.DOUBLE.replace("2 *", "3 *"))}
"""Submissions whose marks come about in another way each."""


@dataclass(frozen=True)
class Class:
    """A course with submissions, and where the command line graded them."""

    course: Path
    alone: Path


@pytest.fixture(scope="module")
def sample(tmp_path_factory, wall_name):
    working(wall_name)
    course = tmp_path_factory.mktemp("class")
    toy.make_tree(course)
    (course / "autograder").mkdir()
    shutil.copy(course_of.GRADER / "nbgrader_config.py", course / "autograder")
    release(course / "solutions", [], course / "build" / "release")
    paths = [course_of.hand_in(course, student, value) for student, value in STUDENTS.items()]
    where = ("--out", course / "alone", "--seed", course_of.SEED, "--sandbox", wall_name)
    command = ("--solutions", course / "solutions", "grade", *paths, *where)
    assert cli.main([*map(str, command)]) == 0
    journal.open_journal(course / "class" / "graded", course_of.SEED)
    return Class(course, course / "alone")


@pytest.fixture
def lab(sample):
    """The address of a JupyterLab in the course, started as the grader's README says."""
    with jupyterlab.running(sample.course, course_of.environment(sample.course)) as address:
        yield address


@pytest.fixture
def page(browser):
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
def test_formgraders_button_gives_the_command_lines_marks(sample, lab, page, tmp_path):
    """JupyterLab starts with formgrader, in which two submissions are graded after each other."""
    formgrader = open_formgrader(page, lab)
    formgrader.locator("tr", has_text=toy.NAME).locator(".num-submissions a").click()
    for student in STUDENTS:
        assert "Successfully autograded" in autograde(formgrader, student)
    page.screenshot(path=tmp_path / "submissions.png")
    found = course_of.rows(course_of.database(sample.course), "score")
    assert found == course_of.rows(sample.alone / "gradebook.db", "score")
    totals = {student: sum(cases.values()) for student, cases in found.items()}
    assert totals.keys() == set(STUDENTS)
    assert 0 < totals["half"] < toy.MOST
    assert totals["broken"] == 0
    for student, total in totals.items():
        row = formgrader.locator("tr", has_text=student)
        expect(row.locator(".status")).to_have_text("graded")
        expect(row.locator(".score")).to_have_text(f"{total:g} / {toy.MOST}")
    formgrader.locator("tr", has_text="half").locator(".student-name a").click()
    formgrader.locator("tr a", has_text=toy.NAME).first.click()
    expect(formgrader.get_by_text("✓ passed").first).to_be_visible()
    expect(formgrader.get_by_text("✗ failed").first).to_be_visible()
    assert "HIDDEN TESTS" not in formgrader.locator("body").inner_text()
    page.screenshot(path=tmp_path / "submission.png")
