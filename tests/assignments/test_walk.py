"""A released assignment in JupyterLab: its checks refuse wrong answers and accept right ones."""

import shutil
import subprocess
from collections.abc import Iterable, Mapping
from typing import Any

import pytest
from robust_slam_autograder.reading.labelled import Answer

from solutions.classes import answers
from tests import jupyterlab

pytestmark = [pytest.mark.browser, pytest.mark.long, pytest.mark.soak]


def one_of_each(found: Iterable[Answer]) -> dict[str, Answer]:
    """The first answer to each exercise."""
    chosen: dict[str, Answer] = {}
    for answer in found:
        chosen.setdefault(answer.exercise, answer)
    return chosen


def sources(chosen: Mapping[str, Answer]) -> dict[str, str]:
    return {exercise: answer.source for exercise, answer in chosen.items()}


def failed(cells: Iterable[Mapping[str, Any]]) -> set[str]:
    """The grade ids, or else the ids, of the cells that show an error."""
    return {
        cell["metadata"].get("nbgrader", {}).get("grade_id", cell["id"])
        for cell in cells
        if any(out["output_type"] == "error" for out in cell.get("outputs", []))
    }


@pytest.mark.parametrize("name", answers.assignments())
def test_wrong_answers_are_refused_and_right_ones_pass(name, browser, released, tmp_path):
    path = shutil.copytree(released / name, tmp_path / name) / f"{name}.ipynb"
    visible_first = sorted(answers.answers(name), key=lambda answer: not answer.is_visible)
    wrong = one_of_each(answer for answer in visible_first if not answer.is_right)
    right = one_of_each(answer for answer in visible_first if answer.is_right)
    variables = jupyterlab.environment(tmp_path / "home")
    lab = jupyterlab.running(path.parent, variables)
    with lab as address, jupyterlab.page_of(browser) as page:
        notebook = jupyterlab.Notebook(page, address, path)
        notebook.type_in(sources(wrong))
        with_wrong = notebook.run_all()
        notebook.type_in(sources(right))
        with_right = notebook.run_all()
    stopped = {answer.caught_by for answer in wrong.values() if answer.is_visible}
    assert stopped and stopped <= failed(with_wrong)
    assert not failed(with_right)
    pictures = [cell for cell in with_right if cell["id"].startswith("picture-")]
    assert pictures
    assert not [cell["id"] for cell in pictures if "image/" not in str(cell["outputs"])]
    command = [str(jupyterlab.SCRIPTS / "autograder"), "check", str(path)]
    checked = subprocess.run(command, capture_output=True, text=True, cwd=path.parent)
    assert checked.returncode == 0, checked.stdout + checked.stderr
    assert checked.stdout.strip().splitlines()[-1].startswith("All visible cases passed; ")
