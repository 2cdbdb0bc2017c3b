"""A chapter's canvases outside the site: in an export without a kernel, and in JupyterLab."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, expect

from tests import jupyterlab
from tests.book.conftest import ROOT
from tests.book.moving import by_keyboard, controls, picture, size
from tests.chromium import Opener

pytestmark = pytest.mark.browser

CHAPTER = ROOT / "chapters" / "03-irls.ipynb"


@pytest.fixture(scope="module", autouse=True)
def exporting(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[], Path]]:
    """A chapter is run and exported as anybody would; the function waits for its page.

    It runs beside the test of JupyterLab, which mostly waits.
    """
    folder = tmp_path_factory.mktemp("export")
    command = [jupyterlab.SCRIPTS / "jupyter", "nbconvert", "--execute", "--to", "html", CHAPTER]
    with subprocess.Popen([*command, "--output-dir", folder], stderr=subprocess.PIPE) as running:

        def wait() -> Path:
            _, said = running.communicate()
            assert running.returncode == 0, said.decode()
            return folder / "03-irls.html"

        yield wait
        running.kill()


def test_a_kernel_draws_it_anew(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / CHAPTER.name
    shutil.copy(CHAPTER, path)
    variables = jupyterlab.environment(tmp_path / "home")
    with (
        jupyterlab.running(tmp_path, variables) as address,
        jupyterlab.page_of(browser) as page,
    ):
        notebook = jupyterlab.Notebook(page, address, path)
        cells = notebook.run_all()
        for number, cell in enumerate(cells):
            if any("Canvas: " in text for text in texts(cell)):
                moves(notebook.cells.nth(number))
                assert not page.locator(".jp-OutputArea-output[data-mime-type*=stderr]").count()


def test_an_export_needs_no_kernel(exporting: Callable[[], Path], open_page: Opener) -> None:
    page = open_page(exporting().as_uri()).page
    canvases = page.locator(".rs-canvas").all()
    assert canvases
    for canvas in canvases:
        for control in controls(canvas):
            by_keyboard(control, 0)
            first = picture(canvas)
            by_keyboard(control, size(control) - 1)
            assert picture(canvas) != first
    assert page.locator(".jupyter-widgets, .widget-subarea").count() == 0
    answer = page.locator(".rs-quiz details").first
    answer.locator("summary").click()
    assert answer.locator("p").is_visible()


def texts(cell: dict[str, object]) -> list[str]:
    return [json.dumps(output) for output in cell.get("outputs", [])]


def moves(cell: Locator) -> None:
    """Move each widget of a live canvas; the picture must follow."""
    image = cell.locator(".jupyter-widgets img")
    kinds = ("select", ".noUi-handle", "input[type=checkbox]", "button")
    for widget in cell.locator(", ".join(f".jupyter-widgets {kind}" for kind in kinds)).all():
        before = image.get_attribute("src")
        match widget.evaluate("w => w.localName"):
            case "select":
                widget.select_option(index=1)
            case "div":
                widget.press("ArrowRight")
            case _:
                widget.click()
        expect(image).not_to_have_attribute("src", str(before))
