"""What there is per assignment, as a Markdown table; the release and the solutions are graded.

    python -m tests.assignments.table

A visible case has no hidden region. Seconds are those of grading the solutions, one submission
alone, behind the first wall that works.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

from robust_slam_autograder.grading import marking
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.publishing.student_release import release
from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment
from robust_slam_autograder.sandbox import Sandbox, choose

from tests.assignments import answers

HEADS = (
    "assignment", "exercises", "points", "visible", "hidden", "right", "wrong",
    "release", "solutions", "seconds",
)  # fmt: skip
SEED = 1


def grade(tests: Assignment, handed_in: dict[str, Any], wall: Sandbox) -> Result:
    """Grade one notebook."""
    cells = notebook.parse(answers.text(handed_in).encode(), f"{tests.name}.ipynb")
    code = submission.collect(cells, tests)
    return marking.grade(tests, code, student="a", seed=SEED, sandbox=wall)


def row(name: str, released: Path, wall: Sandbox) -> tuple[object, ...]:
    """One line of the table."""
    tests = assignment_module.load(answers.SOLUTIONS / name / f"{name}.ipynb")
    found = answers.answers(name)
    right = sum(answer.is_right for answer in found)
    hidden = sum(case.has_hidden for case in tests.cases)
    empty = grade(tests, answers.source_notebook(name, released), wall)
    full = grade(tests, answers.solved(name, released), wall)
    return (
        name, len(tests.exercises), f"{full.max_score:g}", len(tests.cases) - hidden, hidden,
        right, len(found) - right, f"{empty.score:g}", f"{full.score:g}", f"{full.seconds:.1f}",
    )  # fmt: skip


def main() -> None:
    """Print the table."""
    wall = choose()
    print(f"| {' | '.join(HEADS)} |\n|{'---|' * len(HEADS)}")
    with tempfile.TemporaryDirectory(prefix="table-") as folder:
        release(answers.SOLUTIONS, answers.assignments(), Path(folder))
        for name in answers.assignments():
            print(f"| {' | '.join(map(str, row(name, Path(folder), wall)))} |", flush=True)


if __name__ == "__main__":
    main()
