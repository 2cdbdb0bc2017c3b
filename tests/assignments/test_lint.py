"""The course's own assignments pass every rule of `autograder lint`; a planted defect does not."""

import pytest
from robust_slam_autograder.lint import lint

from solutions.classes import answers

pytestmark = pytest.mark.long

NAMES = answers.assignments()


@pytest.mark.parametrize("name", NAMES)
def test_an_assignment_has_no_finding(name):
    path = answers.SOLUTIONS / name / f"{name}.ipynb"
    assert not [*map(str, lint(path, answers.ANSWERS, answers.ROOT / "chapters"))]


@pytest.mark.parametrize("name", NAMES)
def test_a_comparison_that_broadcasts_is_found_wherever_it_is_planted(name, tmp_path):
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
