"""Does an assignment in JupyterLab as a student would: wrong first, then right.

    python -m tests.assignments.walk 03-irls --release build/release --shots build/walk

A wrong answer is typed into every exercise of the released notebook, every cell is run, and what
the checks say is printed. Then the right answers: every check must pass, and every picture be
drawn. Screenshots show both as the student sees them. The notebook is saved and handed in.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright

from tests import jupyterlab
from tests.assignments import answers
from tests.assignments.answers import Answer
from tests.chromium import CHROMIUM

NOTEBOOK_MILLISECONDS = 300_000
ANSI = re.compile(r"\x1b\[[0-9;]*m")


class Notebook:
    """A notebook that is open in JupyterLab."""

    def __init__(self, page: Page, address: str, path: Path) -> None:
        self.page, self.path = page, path
        page.goto(f"{address}/lab/tree/{path.name}?token={jupyterlab.TOKEN}")
        self.cells = page.locator(".jp-Notebook .jp-Cell")
        page.locator(".jp-Notebook-ExecutionIndicator[data-status='idle']").wait_for(
            timeout=NOTEBOOK_MILLISECONDS
        )

    def read(self) -> list[dict[str, Any]]:
        """The cells of the file as it was last saved."""
        found: list[dict[str, Any]] = json.loads(self.path.read_text("utf-8"))["cells"]
        return found

    def save(self) -> list[dict[str, Any]]:
        """Save, and give the cells."""
        with self.page.expect_response(
            lambda answer: answer.request.method == "PUT" and "/api/contents/" in answer.url
        ):
            self.page.keyboard.press("Control+s")
        return self.read()

    def type_in(self, texts: Mapping[str, str]) -> None:
        """Replace the text of solution cells."""
        for number, cell in enumerate(self.read()):
            text = texts.get(cell["metadata"].get("nbgrader", {}).get("grade_id", ""))
            if text is not None:
                self.cells.nth(number).locator(".cm-content").click()
                self.page.keyboard.press("Control+a")
                self.page.keyboard.insert_text(text)
                self.page.keyboard.press("Escape")

    def run_all(self) -> list[dict[str, Any]]:
        """Run each cell with Shift and Enter, also past errors; gives the cells.

        One after the other: an error drops the cells that wait behind it.
        """
        self.cells.first.click()
        self.page.keyboard.press("Escape")
        cells = self.read()
        for number, cell in enumerate(cells):
            is_last = number == len(cells) - 1  # it gets no new cell below
            keys = "Control+Enter" if is_last else "Shift+Enter"
            if cell["cell_type"] == "code":
                self._run(number, keys)
            else:
                self.page.keyboard.press(keys)
        return self.save()

    def _run(self, number: int, keys: str) -> None:
        """Run the selected code cell, and wait until it has a new number."""
        prompt = self.cells.nth(number).locator(".jp-InputPrompt")
        before = prompt.text_content()
        self.page.keyboard.press(keys)
        self.page.wait_for_function(
            "([prompt, before]) => /[0-9]/.test(prompt.textContent)"
            " && prompt.textContent !== before",
            arg=[prompt.element_handle(), before],
            timeout=NOTEBOOK_MILLISECONDS,
        )

    def shoot(self, folder: Path, name: str, grade_ids: list[str]) -> None:
        """Photograph cells as they stand on the screen."""
        for number, cell in enumerate(self.read()):
            known = cell["metadata"].get("nbgrader", {}).get("grade_id", cell["id"])
            if known in grade_ids:
                self.cells.nth(number).scroll_into_view_if_needed()
                self.cells.nth(number).screenshot(path=folder / f"{name}-{known}.png")


def said(cell: Mapping[str, Any]) -> list[str]:
    """What a cell's outputs say: what was printed, and the last line of an error."""
    streams = [out for out in cell.get("outputs", []) if out["output_type"] == "stream"]
    return ["".join(out["text"]).strip() for out in streams] + errors(cell)


def errors(cell: Mapping[str, Any]) -> list[str]:
    """The last line of each error among a cell's outputs."""
    found = [out for out in cell.get("outputs", []) if out["output_type"] == "error"]
    return [f"{out['ename']}: {ANSI.sub('', out['evalue'])}" for out in found]


def wrong_answers(assignment: str) -> dict[str, Answer]:
    """A wrong answer for each exercise: one that a visible check stops, where there is one."""
    found = [answer for answer in answers.answers(assignment) if not answer.is_right]
    found.sort(key=lambda answer: "visible case" not in answer.story)
    return _first_of_each(found)


def right_answers(assignment: str) -> dict[str, Answer]:
    """A right answer for each exercise."""
    return _first_of_each([answer for answer in answers.answers(assignment) if answer.is_right])


def _first_of_each(found: list[Answer]) -> dict[str, Answer]:
    chosen: dict[str, Answer] = {}
    for answer in found:
        chosen.setdefault(answer.exercise, answer)
    return chosen


def walk(page: Page, address: str, path: Path, shots: Path) -> Iterator[str]:
    """Do it, and tell it line by line.

    Raises:
        RuntimeError: a right answer does not pass, or a picture is missing.
    """
    name = path.stem
    notebook = Notebook(page, address, path)
    wrong = wrong_answers(name)
    notebook.type_in({exercise: answer.source for exercise, answer in wrong.items()})
    failed = {cell_name(cell): told for cell in notebook.run_all() if (told := said(cell))}
    for exercise, answer in wrong.items():
        yield f"{exercise}: {answer.name}: {answer.story}"
    for known, told in failed.items():
        yield f"  {known}: {' / '.join(told)}"
    ungraded = [cell["id"] for cell in notebook.read() if "nbgrader" not in cell["metadata"]]
    notebook.shoot(shots, "wrong", [*failed, *ungraded])
    chosen = right_answers(name)
    notebook.type_in({exercise: answer.source for exercise, answer in chosen.items()})
    cells = notebook.run_all()
    notebook.shoot(shots, "right", ungraded)
    pictures = [cell for cell in cells if cell["id"].startswith("picture-")]
    drawn = [cell for cell in pictures if "image/" in str(cell["outputs"])]
    told = [f"{cell_name(cell)}: {line}" for cell in cells for line in errors(cell)]
    if told or len(drawn) < len(pictures):
        raise RuntimeError(f"{name} with right answers: {told}, {len(drawn)} pictures")
    yield f"right answers: every check passes, {len(drawn)} of {len(pictures)} pictures drawn"


def cell_name(cell: Mapping[str, Any]) -> str:
    """The grade id of a cell, or its id."""
    known: str = cell["metadata"].get("nbgrader", {}).get("grade_id", cell["id"])
    return known


def check(path: Path) -> str:
    """The student's own check of the saved notebook; gives its last line."""
    command = [str(jupyterlab.SCRIPTS / "autograder"), "check", str(path)]
    done = subprocess.run(command, capture_output=True, text=True, cwd=path.parent)
    if done.returncode != 0:
        raise RuntimeError(f"autograder check: {done.stdout}{done.stderr}")
    return done.stdout.strip().splitlines()[-1]


def main() -> None:
    """Read the arguments and do each assignment."""
    parser = argparse.ArgumentParser(prog="python -m tests.assignments.walk")
    parser.add_argument("names", nargs="*", metavar="NAME", default=answers.assignments())
    parser.add_argument("--release", type=Path, default=Path("build/release"))
    parser.add_argument("--shots", type=Path, default=Path("build/walk"))
    options = parser.parse_args()
    path = shutil.which("chromium")
    if path is None:
        sys.exit("chromium is not installed: apt-get install chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(CHROMIUM))
        for name in options.names:
            shots = options.shots / name
            shots.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(prefix="walk-") as folder:
                place, home = Path(folder, name), Path(folder, "home")
                shutil.copytree(options.release / name, place)
                variables = jupyterlab.environment(home)
                with (
                    jupyterlab.running(place, variables) as address,
                    jupyterlab.page_of(browser) as page,
                ):
                    print(f"## {name}")
                    for line in walk(page, address, place / f"{name}.ipynb", shots):
                        print(line, flush=True)
                print(f"autograder check: {check(place / f'{name}.ipynb')}", flush=True)
        browser.close()


if __name__ == "__main__":
    main()
