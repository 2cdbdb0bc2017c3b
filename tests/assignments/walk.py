"""Does an assignment in JupyterLab as a student would: wrong first, then right.

    python -m tests.assignments.walk 03-irls --release build/release --shots build/walk

A wrong answer is typed into every exercise of the released notebook, every cell is run, and what
the checks say is printed. Then the right answers: every check must pass, and every picture be
drawn. Screenshots show both as the student sees them. The notebook is saved and handed in.
"""

from __future__ import annotations

import argparse
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, sync_playwright
from robust_slam_autograder.lint.answers import Answer

from tests import jupyterlab
from tests.assignments import answers
from tests.chromium import CHROMIUM

ANSI = re.compile(r"\x1b\[[0-9;]*m")


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
    found.sort(key=lambda answer: not answer.is_visible)
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
    notebook = jupyterlab.Notebook(page, address, path)
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
