"""Lists each hint with the wrong answers that get it, to read whether it is true of each.

python -m tests.assignments.hints [NAME…]
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

from robust_slam_autograder.reading import assignment as assignment_module

from tests.assignments import answers


def lines(name: str) -> Iterator[str]:
    """Yield an assignment's hints, each with the misconceptions that its case is to catch."""
    assignment = assignment_module.load(answers.SOLUTIONS / name / f"{name}.ipynb")
    for case in assignment.cases:
        caught = [one for one in answers.answers(name) if one.caught_by == case.grade_id]
        stories = [f"    {one.name}: {one.story}" for one in caught if not one.is_visible]
        if stories:
            yield f"{case.grade_id}: {case.hint}"
            yield from stories


if __name__ == "__main__":
    for name in sys.argv[1:] or answers.assignments():
        print("\n".join(lines(name)))
