"""Comments that allow a finding: ``# lint: allow RULE (reason)``.

They are read where no student sees them: in a hidden region, for its case, and
in a solution region, for its exercise and the cases of it. A release holds neither.
"""

from __future__ import annotations

import re
from collections.abc import Container, Iterator
from dataclasses import dataclass

from robust_slam_autograder.lint.subject import (
    BEGIN_SOLUTION,
    END_SOLUTION,
    Found,
    Subject,
    regions,
)
from robust_slam_autograder.reading.assignment import BEGIN_HIDDEN, END_HIDDEN

_COMMENT = re.compile(r"#\s*lint:\s*(.*)")
_ALLOW = re.compile(r"allow\s+([\w-]+)\s*\(\s*(\S[^)]*)\)\s*")


@dataclass(frozen=True)
class Allowance:
    """One such comment."""

    cell: str
    """Grade id of the cell that it stands in."""
    line: int
    rule: str
    grade_ids: frozenset[str]
    """Where it holds."""

    def covers(self, rule: str, found: Found) -> bool:
        """Return whether it allows a finding."""
        return rule == self.rule and found.grade_id in self.grade_ids


def allowances(subject: Subject, rules: Container[str]) -> tuple[list[Allowance], list[Found]]:
    """Read the comments.

    Args:
        subject: the assignment.
        rules: names of all rules.

    Returns:
        those that hold, and what is wrong with the others.
    """
    good, bad = [], []
    for cell, line, text, is_secret in _comments(subject):
        match = _ALLOW.fullmatch(text)
        if not is_secret:
            fix = "move it into the hidden region, or into the exercise's solution region"
            bad.append(Found(cell, f"Students would read this comment: {fix}.", line))
        elif match is None:
            bad.append(Found(cell, "Say # lint: allow RULE (reason), with a reason.", line))
        elif match.group(1) not in rules:
            bad.append(Found(cell, f"There is no rule {match.group(1)}: see lint --rules.", line))
        else:
            good.append(Allowance(cell, line, match.group(1), _scope(subject, cell)))
    return good, bad


def _comments(subject: Subject) -> Iterator[tuple[str, int, str, bool]]:
    """Grade id, line, text after ``lint:``, and whether students do not see it."""
    hidden, solution = (BEGIN_HIDDEN, END_HIDDEN), (BEGIN_SOLUTION, END_SOLUTION)
    cells = [
        *((case.grade_id, case.full, hidden) for case in subject.assignment.cases),
        *((cell.grade_id or "", cell.source, solution) for cell in subject.solutions),
        *((piece.label, piece.source, hidden) for piece in subject.assignment.setup),
    ]
    for grade_id, source, marks in cells:
        secret = regions(source, *marks)
        for number, line in enumerate(source.split("\n"), start=1):
            if match := _COMMENT.search(line):
                yield grade_id, number, match.group(1), any(number in one for one in secret)


def _scope(subject: Subject, cell: str) -> frozenset[str]:
    """The cell itself; of a solution cell the exercise's cases too."""
    owner = subject.assignment.owner
    cases = subject.assignment.cases
    return frozenset({cell, *(c.grade_id for c in cases if owner(c.exercise) == cell)})
