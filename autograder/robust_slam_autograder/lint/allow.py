"""Comments that allow a finding: ``# lint: allow RULE (reason)``.

They are read where no student sees them: in a hidden region, for its case, and
in a solution region, for its exercise and the cases of it. A release holds neither.
"""

import re
from collections.abc import Iterator

from robust_slam_autograder.lint.subject import BEGIN_SOLUTION, END_SOLUTION, Subject, regions
from robust_slam_autograder.reading.assignment import BEGIN_HIDDEN, END_HIDDEN

_COMMENT = re.compile(r"#\s*lint:\s*(.*)")
_ALLOW = re.compile(r"allow\s+([\w-]+)\s*\(\s*\S[^)]*\)\s*")


def comments(subject: Subject) -> Iterator[tuple[str, str, int]]:
    """Yield the rule, the cell and the line of each comment; no rule where it allows nothing."""
    for cell in (cell for cell in subject.cells if cell.kind == "code"):
        marks = (BEGIN_HIDDEN, END_HIDDEN) if cell.grade else (BEGIN_SOLUTION, END_SOLUTION)
        secret = [number for one in regions(cell.source, *marks) for number in one]
        for number, line in enumerate(cell.source.split("\n"), start=1):
            if comment := _COMMENT.search(line):
                asked = _ALLOW.fullmatch(comment[1]) if number in secret else None
                yield asked[1] if asked else "", cell.grade_id or "own cell", number
