"""From a submission only the text of its solution cells and its own definitions count."""

from typing import Any

import pytest
from robust_slam_autograder.errors import Refused
from robust_slam_autograder.reading.submission import OWN, Code, notebook_in

from .. import toy

DOUBLE, APPLY = "def double(x): pass\n", "def apply(f, x, times): pass\n"


def collect(*cells: dict[str, Any]) -> Code:
    return toy.submission(toy.notebook(list(cells)), toy.assignment())


def labels(found: Code) -> list[tuple[str, bool]]:
    return [(piece.label, piece.own) for piece in found.pieces]


def test_a_grade_id_goes_before_a_name():
    found = collect(toy.cell(DOUBLE), toy.cell("pass\n", "double", solution=True))
    assert labels(found) == [(OWN, True), ("double", False)]


def test_cells_without_their_grade_id_are_matched_by_name():
    found = collect(toy.cell(APPLY + DOUBLE), toy.cell("x = 1\n"))
    assert labels(found) == [("double", False), (OWN, True)] and not found.missing
    words = "was found by its function's name."
    assert found.notes == (f"The cell double {words}", f"The cell apply {words}")


def test_copies_run_in_order_with_a_note():
    copies = [toy.cell(text, "double", solution=True) for text in ("x = 1\n", DOUBLE)]
    found = collect(*copies, toy.cell(APPLY, "apply", solution=True))
    assert [piece.source for piece in found.pieces] == ["x = 1\n", DOUBLE, APPLY]
    assert found.notes == ("double stands in 2 cells: they ran in order.",)


def test_the_instructors_cells_are_not_the_students():
    found = collect(
        toy.cell(toy.SETUP),
        toy.test_cell(toy.DOUBLE_VISIBLE, "double-by-hand", 9),
        toy.cell(toy.DOUBLE_VISIBLE),
        toy.cell("# mine\n", "double", solution=True),
        toy.cell(toy.SETUP + "# edited\n", "setup", locked=True),
    )
    assert labels(found) == [("double", False), (OWN, True)]
    assert found.pieces[1].source.strip() == "# edited"


def test_the_notebook_of_a_folder_is_found_or_its_absence_told(tmp_path):
    with pytest.raises(Refused, match=r"no notebook in the folder: hand in one, named a\.ipynb"):
        notebook_in(tmp_path, "a")
    toy.write(tmp_path / "b\n.ipynb", toy.answer())
    path, notes = notebook_in(tmp_path, "a")
    assert path == tmp_path / "b\n.ipynb" and notes == ("b?.ipynb was taken for a.ipynb.",)
    toy.write(tmp_path / "c.ipynb", toy.answer())
    with pytest.raises(Refused, match="2 notebooks"):
        notebook_in(tmp_path, "a")
    toy.write(tmp_path / "a.ipynb", toy.answer())
    assert notebook_in(tmp_path, "a") == (tmp_path / "a.ipynb", ())
    (tmp_path / "a.ipynb").unlink()
    (tmp_path / "c.ipynb").unlink()
    (tmp_path / "._b.ipynb").touch()  # macOS puts one into its archives beside each file
    assert notebook_in(tmp_path, "a")[0] == tmp_path / "b\n.ipynb"
    with pytest.raises(Refused, match="cannot be read"):
        notebook_in(tmp_path / "missing", "a")
