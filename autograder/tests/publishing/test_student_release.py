"""A release holds what students need and no answer; where it would, nothing is written."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.nbgrader.settings import STUB
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading import notebook

from .. import toy

SOLUTION_CANARY = "canary-of-the-solution-9b2"
LINE = "history.append(f(history[-1]))"


@pytest.fixture
def tree(tmp_path):
    """The toy's source tree, with a canary in a solution and outputs that tell."""
    double = toy.DOUBLE.replace("    return", f"    # {SOLUTION_CANARY}\n    return")
    value = toy.source_notebook(double=double)
    told = {"output_type": "stream", "name": "stdout", "text": SOLUTION_CANARY}
    value["cells"][1]["outputs"] = [told]
    return toy.make_tree(tmp_path, 'title = "Toy"\n', value)


def change(tree: Path, what: Callable[[list[dict[str, Any]]], object]) -> None:
    path = tree / toy.NAME / f"{toy.NAME}.ipynb"
    value = json.loads(path.read_text())
    what(value["cells"])
    toy.write(path, value)


def texts(folder: Path) -> str:
    """All that a folder holds, as text; in archives nothing is compressed."""
    paths = [path for path in folder.rglob("*") if path.is_file()]
    return "\n".join(path.read_text("utf-8", "replace") for path in paths)


def test_a_release_holds_stubs_and_visible_tests_alone(tree, tmp_path):
    (path,) = release(tree, [], tmp_path / "out")
    cells = {cell.grade_id: cell for cell in notebook.read(path)}
    assert list(cells) == [
        *("setup", "double", "double-by-hand", "double-random", "apply", "apply-by-hand"),
        "apply-twice",
    ]
    assert STUB in cells["double"].source and "def double(x):" in cells["double"].source
    assert cells["double-by-hand"].source.strip() == toy.DOUBLE_VISIBLE.strip()
    assert cells["double-by-hand"].locked and cells["setup"].locked
    text = texts(tmp_path / "out")
    assert text.count("def double(x):") == 2, "in the folder and in the archive"
    for secret in (toy.CANARY, SOLUTION_CANARY, "hint:", "history.append", "HIDDEN", "rng.normal"):
        assert secret not in text
    assert (path.parent / "autograder.toml").is_file()


@pytest.mark.parametrize(
    ("what", "sentence"),
    [
        (lambda tree: (tree / "solution.py").write_text(toy.APPLY), "BEGIN SOLUTION"),
        (lambda tree: (tree / "notes.md").write_text(f"x\n    {LINE}\n"),
         r"a line of a solution or a hidden test \(history\.append"),
        (lambda tree: toy.write(tree / "b.ipynb", toy.notebook([toy.cell("# hint: no")])),
         "# hint:"),
    ],
)  # fmt: skip
def test_a_file_that_tells_stops_the_release(tree, tmp_path, what, sentence):
    what(tree / toy.NAME)
    with pytest.raises(GraderFailure, match=sentence):
        release(tree, [], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_solution_outside_its_region_stops_the_release(tree, tmp_path):
    change(tree, lambda cells: cells[4].update(source=toy.APPLY))
    change(tree, lambda cells: cells.append(toy.cell(f"# {LINE}\n{LINE}\n") | {"id": "b"}))
    # The line now stands in the open: it is no secret any more, and the release goes through.
    assert release(tree, [], tmp_path / "out")
    change(tree, lambda cells: cells.insert(0, toy.cell(toy.APPLY) | {"id": "c"}))
    said = f"nbgrader could not release {toy.NAME}: RuntimeError: Solution region detected"
    with pytest.raises(GraderFailure, match=said):
        release(tree, [], tmp_path / "new")


def test_the_source_tree_is_never_overwritten(tree):
    before = texts(tree)
    for out in (tree, tree / toy.NAME, tree.parent / "x" / ".." / "solutions"):
        with pytest.raises(WrongUse, match="source tree"):
            release(tree, [], out)
    assert texts(tree) == before
