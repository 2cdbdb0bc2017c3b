"""Live pictures outside the site: in JupyterLab with a kernel, and in an export without one."""

import json
import subprocess
from pathlib import Path

import nbformat
import pytest
from playwright.sync_api import expect
from robust_slam_course import pictures as course

from autograder.tests import kernel
from tests import jupyterlab
from tests.book.conftest import ROOT
from tests.book.taking_hold import PICTURE, follows, pictures

pytestmark = [pytest.mark.browser, pytest.mark.rest]

CHAPTER = ROOT / "chapters" / "02-four-costs.ipynb"
QUIZ = """from robust_slam_course.quiz import Option, Question, Quiz
quiz = Quiz([Question("Which?", [Option("one", "Yes.", correct=True), Option("two", "No.")])])
quiz"""
SHOWN = "shown = pictures.opening().widget()\nshown"


@pytest.fixture(scope="module", autouse=True)
def exporting(tmp_path_factory):
    """A chapter is run and exported as a reader would; the function waits for its page.

    It runs beside the test of JupyterLab, which mostly waits.
    """
    folder = tmp_path_factory.mktemp("export")
    command = [jupyterlab.SCRIPTS / "jupyter", "nbconvert", "--execute", "--to", "html", CHAPTER]
    with subprocess.Popen([*command, "--output-dir", folder], stderr=subprocess.PIPE) as running:

        def wait() -> Path:
            _, said = running.communicate()
            assert running.returncode == 0, said.decode()
            return folder / f"{CHAPTER.stem}.html"

        yield wait
        running.kill()


def notebook_of(names: list[str], path: Path) -> None:
    """Write a notebook that shows pictures, and a quiz twice."""
    shown = [f"pictures.{name}()" for name in names]
    sources = ["from robust_slam_course import pictures", *shown, SHOWN, QUIZ, "quiz"]
    cells = [nbformat.v4.new_code_cell(source) for source in sources]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    nbformat.write(nbformat.v4.new_notebook(cells=cells, metadata=kernel), path)


def test_with_a_kernel_pictures_follow_the_hand_and_each_quiz_its_own(browser, tmp_path, request):
    """JupyterLab and a kernel start. Some pictures, which have one frame; in ``make soak`` all."""
    path = tmp_path / "pictures.ipynb"
    names = sorted(set(course.__all__))[:: 1 if kernel.is_soak(request.config) else 5]
    notebook_of(names, path)
    variables = jupyterlab.environment(tmp_path / "home")
    with jupyterlab.running(tmp_path, variables) as address, jupyterlab.page_of(browser) as page:
        page.emulate_media(reduced_motion="reduce")
        notebook = jupyterlab.Notebook(page, address, path)
        notebook.run_all()
        for number, name in enumerate(names, start=1):
            picture = notebook.cells.nth(number).locator(PICTURE)
            expect(picture).to_have_count(1)
            assert follows(picture), f"{name}: nothing follows in JupyterLab"
        first, second = (notebook.cells.nth(len(names) + number) for number in (2, 3))
        first.locator("input").first.check()
        second.locator("input").first.press("Space")
        page.keyboard.press("ArrowDown")
        expect(first.locator("p:visible")).to_have_text("✓ Right. Yes.")
        expect(second.locator("p:visible")).to_have_text("✗ No. No.")
        expect(second.locator("input").nth(1)).to_be_focused()
        assert not page.locator(".jp-OutputArea-output[data-mime-type*=stderr]").count()


def test_an_export_needs_no_kernel(exporting, open_page):
    page = open_page(exporting().as_uri(), reduced_motion="reduce").page
    assert pictures(page)
    for picture in pictures(page):
        assert follows(picture)
    assert page.locator(".jupyter-widgets, .widget-subarea").count() == 0
    option = page.locator(".rs-quiz .rs-option").first
    option.locator("label").click()
    assert option.locator("p").is_visible()


def test_python_reads_the_state_that_the_hand_made():
    """The widget's state is the picture's, of JSON's values, and follows what is sent."""
    picture = course.opening()
    widget = picture.widget()
    assert widget.state == picture.state
    moved = {**widget.state, "robust": True}
    widget.set_state({"state": moved})
    assert widget.state == moved
    assert json.loads(json.dumps(widget.data)) == widget.data
