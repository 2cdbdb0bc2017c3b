"""The course's own assignments pass every rule of `autograder lint`; planted defects do not."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from robust_slam_autograder.lint import Finding, lint

from tests.assignments import answers

pytestmark = pytest.mark.long

NAMES = answers.assignments()


def linted(
    name: str, folder: Path, change: Callable[[str], str]
) -> tuple[list[Finding], set[str]]:
    """Findings where every test cell's text is changed so, and the ids of the changed cells."""
    notebook = answers.source_notebook(name)
    changed = set()
    for cell in notebook["cells"]:
        fields = cell["metadata"].get("nbgrader", {})
        text = "".join(cell["source"])
        if fields.get("grade") and change(text) != text:
            cell["source"] = change(text)
            changed.add(fields["grade_id"])
    return lint(answers.write(folder / name / f"{name}.ipynb", notebook)), changed


@pytest.mark.parametrize("name", NAMES)
def test_an_assignment_has_no_finding(name: str) -> None:
    found = lint(answers.SOLUTIONS / name / f"{name}.ipynb", answers.ANSWERS)
    assert not [str(one) for one in found]


def with_negated_comparison(text: str) -> str:
    """The cell with ``not np.any(np.abs(a - b) > tol)`` for each ``np.allclose(a, b)``."""
    changed = text
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "np.allclose":
            left, right = (ast.get_source_segment(text, side) for side in node.args[:2])
            whole = ast.get_source_segment(text, node) or ""
            changed = changed.replace(whole, f"(not np.any(np.abs(({left}) - ({right})) > 1e-9))")
    return changed


@pytest.mark.parametrize("name", NAMES)
def test_a_comparison_that_nan_passes_is_found_wherever_it_is_planted(
    name: str, tmp_path: Path
) -> None:
    found, changed = linted(name, tmp_path, with_negated_comparison)
    assert len(changed) > 5
    assert {one.grade_id for one in found if one.rule == "nan-passes"} == changed


def without_shape_checks(text: str) -> str:
    """The cell without its shape checks, where it compares with np.allclose."""
    checks = r"^( *)assert (np\.(shape|ndim|ptp)\(|history\.ndim)[^\n]*"
    is_broadcast = "np.allclose" in text
    return re.sub(checks, r"\1pass", text, flags=re.MULTILINE) if is_broadcast else text


@pytest.mark.parametrize("name", NAMES)
def test_a_shape_check_that_is_taken_away_is_missed(name: str, tmp_path: Path) -> None:
    found, changed = linted(name, tmp_path, without_shape_checks)
    assert len(changed) > 5
    missed = {one.grade_id for one in found if one.rule.endswith("-unchecked")}
    assert missed == changed


@pytest.mark.parametrize("name", NAMES)
def test_a_target_made_after_the_call_is_found(name: str, tmp_path: Path) -> None:
    found, changed = linted(name, tmp_path, lambda text: text.replace(".copy()", ""))
    assert changed
    assert {one.grade_id for one in found if one.rule == "reference-after-call"} == changed
