"""What a rule is, and what it finds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

from robust_slam_autograder.lint.subject import Subject

Severity = Literal["error", "warning"]


@dataclass(frozen=True)
class Found:
    """One place that a rule does not accept."""

    grade_id: str
    """The cell's, or the file's name where it is in none."""
    line: int
    """In that cell, from 1."""
    message: str
    """What is wrong there, and the fix."""


@dataclass(frozen=True)
class Rule:
    """A rule: its name, how grave a finding is, one sentence, and the function that looks."""

    name: str
    severity: Severity
    summary: str
    check: Callable[[Subject], Iterator[Found]]


@dataclass(frozen=True)
class Finding:
    """What an instructor reads: a place, the rule, and the fix."""

    path: str
    grade_id: str
    line: int
    rule: str
    severity: Severity
    message: str

    def __str__(self) -> str:
        return f"{self.path}: {self.grade_id}:{self.line}: {self.rule}: {self.message}"
