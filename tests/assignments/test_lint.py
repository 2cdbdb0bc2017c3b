"""The course's own assignments pass every rule of `autograder lint`; a planted defect does not."""

from pathlib import Path

import pytest
from robust_slam_autograder.lint import lint

from solutions.classes import answers

pytestmark = pytest.mark.long

NAMES = answers.assignments()


@pytest.mark.parametrize("name", NAMES)
def test_an_assignment_has_no_finding(name: str) -> None:
    found = lint(
        answers.SOLUTIONS / name / f"{name}.ipynb", answers.ANSWERS, answers.ROOT / "chapters"
    )
    assert not [str(one) for one in found]


@pytest.mark.parametrize("name", NAMES)
def test_a_comparison_that_broadcasts_is_found_wherever_it_is_planted(
    name: str, tmp_path: Path
) -> None:
    notebook = answers.source_notebook(name)
    changed = set()
    for cell in notebook["cells"]:
        fields = cell["metadata"].get("nbgrader", {})
        text = "".join(cell["source"])
        if fields.get("grade") and "close(" in text:
            cell["source"] = text.replace("close(", "np.testing.assert_allclose(")
            changed.add(fields["grade_id"])
    found = lint(answers.write(tmp_path / name / f"{name}.ipynb", notebook))
    assert len(changed) > 3
    assert {one.grade_id for one in found if one.rule == "by-close"} == changed
