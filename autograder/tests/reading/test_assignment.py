"""An instructor's notebook is sorted into set-up, solutions and cases, or the fix is named."""

import json
from pathlib import Path
from typing import Any

import pytest
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook
from robust_slam_autograder.reading.assignment import Assignment, Config

from .. import toy


def from_cells(*cells: dict[str, Any]) -> Assignment:
    data = json.dumps(toy.notebook(list(cells))).encode()
    parsed = notebook.parse(data, "a.ipynb")
    return assignments.from_cells(parsed, Path("a/a.ipynb"), Config())


def solution(text: str, grade_id: str) -> dict[str, Any]:
    return toy.cell(text, grade_id, solution=True)


def test_a_case_belongs_to_the_longest_name_that_fits():
    tests = from_cells(
        solution("def f(): pass\ndef g(): pass\n", "ex-1"),
        solution("def h(): pass\n", "ex-1-b"),
        toy.test_cell("f()", "ex-1-a", 1),
        toy.test_cell("h()", "ex-1-b-c", 1),
        toy.test_cell("g()", "g-x", 1),
        toy.test_cell("pass", "test_7", 1),
    )
    found = [(each.exercise, each.name, tests.owner(each.exercise)) for each in tests.cases]
    assert found == [
        ("ex-1", "a", "ex-1"),
        ("ex-1-b", "c", "ex-1-b"),
        ("g", "x", "ex-1"),
        ("test_7", "tests", "test_7"),
    ]


def test_cells_without_marks_are_set_up_of_which_the_definitions_run():
    tests = from_cells(
        toy.cell("import numpy as np\n"),
        toy.cell("x = 1\n", "setup", locked=True),
        solution("import math\ndef f(): pass\n", "f"),
        toy.test_cell("f()", "f-a", 1),
    )
    assert [piece.own for piece in tests.setup] == [True, False]
    assert tests.imports == ("import math",)
    assert tests.names == ("f",)


@pytest.mark.parametrize(
    ("cells", "sentence"),
    [
        ([toy.cell("x = 1")], "no test cell"),
        ([toy.test_cell("", "a", 1), toy.test_cell("", "a", 1)], "two cells with the grade id a"),
        ([toy.test_cell("### BEGIN HIDDEN TESTS", "a", 1)], "not closed"),
        ([toy.test_cell("### END HIDDEN TESTS", "a", 1)], "open and close in turn"),
        ([toy.cell("") | {"metadata": {"nbgrader": {"grade": True}}}], "without a grade id"),
    ],
)
def test_an_assignment_that_cannot_be_used_is_refused(cells, sentence):
    with pytest.raises(WrongUse, match=sentence):
        from_cells(*cells)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a = ", "not valid TOML"),
        ("colour = 1", "unknown key 'colour'"),
        ("title = 1", "title has a value of the wrong type"),
        ("withheld = ['a/b']", "list of module names"),
        ("withheld = [1]", "list of module names"),
        ("packages = ['a.b']", "packages must be a list of names"),
        ("packages = [1]", "packages must be a list of names"),
        ("packages = 'numpy'", "packages has a value of the wrong type"),
        ("[limits]\ncall = 1", "unknown key 'call'"),
        ("[limits]\ncall_seconds = 0", "more than 0"),
        ("[limits]\ncall_seconds = nan", "more than 0"),
        ("[limits]\ncall_seconds = inf", "more than 0"),
        ("[limits]\ncall_seconds = true", "wrong type"),
    ],
)
def test_a_configuration_that_cannot_be_used_names_the_key(tmp_path, text, sentence):
    path = tmp_path / assignments.CONFIG_NAME
    path.write_text(text)
    with pytest.raises(WrongUse, match=sentence):
        assignments.load_config(path)


@pytest.mark.parametrize(
    ("table", "lost", "told"),
    [
        ("[sections]\ndoubel = 'Heading'", "", "names 'doubel'; the exercises are double, apply"),
        ("[sections]\ndouble = 'A heading'", "def double", "names 'double'; the exercises are d"),
        ("[hints]\ndouble = ['One.']", "def double", f"mark its cells in {toy.NAME}.ipynb again"),
        ("[hints]\ndouble = ['One.', 2]", "", "hints.double.2 has a value of the wrong type (2)"),
        ("[sections]\ndouble = 1", "", "sections.double has a value of the wrong type (1)"),
    ],
)
def test_sections_and_hints_are_of_exercises_or_the_file_is_named(tmp_path, table, lost, told):
    """A cell that lost its marks is none."""
    value = toy.source_notebook()
    for cell in value["cells"]:
        if lost and lost in cell["source"]:
            cell["metadata"] = {}
    folder = toy.make_tree(tmp_path, table, value) / toy.NAME
    with pytest.raises(WrongUse) as caught:
        assignments.load(folder / f"{toy.NAME}.ipynb")
    assert str(caught.value).startswith(f"{folder / 'autograder.toml'}: ")
    assert told in str(caught.value)


def test_a_tree_names_its_assignments_and_nothing_else(tmp_path):
    tree = toy.make_tree(tmp_path)
    toy.write(tree / ".ipynb_checkpoints" / "x.ipynb", toy.answer())
    (tree / "empty").mkdir()
    assert assignments.find_names(tree) == [toy.NAME]
    for folder, sentence in (
        (tmp_path / "missing", "autograder --solutions DIR"),
        (tree / "empty", "no assignment"),
    ):
        with pytest.raises(WrongUse, match=sentence):
            assignments.find_names(folder)


def test_the_one_notebook_of_a_folder_is_found(tmp_path):
    folder = tmp_path / "hw"
    toy.write(folder / "only.ipynb", toy.source_notebook())
    assert assignments.notebook_path(folder).name == "only.ipynb"
    assert assignments.load(folder / "only.ipynb").name == "hw"
    toy.write(folder / "other.ipynb", toy.source_notebook())
    with pytest.raises(WrongUse, match="has 2 notebooks"):
        assignments.notebook_path(folder)
    toy.write(folder / "hw.ipynb", toy.source_notebook())
    assert assignments.notebook_path(folder).name == "hw.ipynb"
