"""A chapter's canvases outside the site: in an export without a kernel, and in JupyterLab."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.book.conftest import ROOT
from tests.book.moving import by_keyboard, controls, picture, size
from tests.chromium import Opener
from tests.jupyterlab import SCRIPTS

pytestmark = pytest.mark.browser

CHAPTER = ROOT / "chapters" / "03-irls.ipynb"


@pytest.fixture(scope="module")
def export(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A chapter, run and exported by nbconvert as anybody would."""
    folder = tmp_path_factory.mktemp("export")
    command = [SCRIPTS / "jupyter", "nbconvert", "--execute", "--to", "html", CHAPTER]
    subprocess.run([*command, "--output-dir", folder], check=True, capture_output=True)
    return folder / "03-irls.html"


def test_an_export_needs_no_kernel(export: Path, open_page: Opener) -> None:
    page = open_page(export.as_uri()).page
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
