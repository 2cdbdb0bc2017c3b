"""Answers as students would type them, and submissions made of them.

``robust_slam_autograder.reading.labelled`` says how the files ``<assignment>/<exercise>.toml``
are written.
"""

import functools
import json
from collections.abc import Mapping
from copy import deepcopy
from pathlib import Path
from typing import Any

from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading import labelled
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.reading.labelled import Answer

ROOT = Path(__file__).resolve().parents[2]
SOLUTIONS = ROOT / "solutions"
ANSWERS = SOLUTIONS / "answers"


def assignments() -> list[str]:
    """Return the names of the assignments in solutions/."""
    return sorted(path.parent.name for path in SOLUTIONS.glob("*/*.ipynb"))


def answers(assignment: str) -> list[Answer]:
    """Return all answers to an assignment, in the order of the files and in theirs."""
    return [one for path in labelled.files(ANSWERS / assignment) for one in labelled.read(path)]


@functools.cache
def load(name: str) -> Assignment:
    """Read an assignment as the grader does."""
    return assignment_module.load(SOLUTIONS / name / f"{name}.ipynb")


def source_notebook(assignment: str, tree: Path = SOLUTIONS) -> dict[str, Any]:
    """Return an assignment's notebook as JSON, from the source tree or from a release."""
    path = tree / assignment / f"{assignment}.ipynb"
    notebook: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return notebook


def with_answers(notebook: Mapping[str, Any], sources: Mapping[str, str]) -> dict[str, Any]:
    """Return the notebook with other text in the solution cells that ``sources`` names."""
    changed: dict[str, Any] = deepcopy(dict(notebook))
    left = dict(sources)
    for cell in changed["cells"]:
        grade_id = cell["metadata"].get("nbgrader", {}).get("grade_id")
        if grade_id in left:
            cell["source"] = left.pop(grade_id)
    if left:
        raise KeyError(f"no solution cell {', '.join(left)}")
    return changed


def solutions(assignment: str) -> dict[str, str]:
    """Return the instructor's answers by exercise, in the notebook's order."""
    return {
        cell["metadata"]["nbgrader"]["grade_id"]: "".join(cell["source"])
        for cell in source_notebook(assignment)["cells"]
        if cell["metadata"].get("nbgrader", {}).get("solution")
    }


def solved(assignment: str, release: Path) -> dict[str, Any]:
    """Return the notebook of a release with the instructor's answers typed in."""
    return with_answers(source_notebook(assignment, release), solutions(assignment))


def hand_in(out: Path, student: str, assignment: str, file: str) -> Path:
    """Write a submission's file, and return its folder, ``<out>/<student>/<assignment>``."""
    folder = out / student / assignment
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{assignment}.ipynb").write_text(file, encoding="utf-8")
    return folder


def text(notebook: Mapping[str, Any]) -> str:
    """Return a notebook's file, as JupyterLab would write it."""
    return json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"


def write(path: Path, notebook: Mapping[str, Any]) -> Path:
    """Write a notebook's file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text(notebook), encoding="utf-8")
    return path
