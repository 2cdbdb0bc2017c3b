"""What a rule is, and what an instructor reads of it."""

import ast
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import ModuleType
from typing import Literal

from robust_slam_autograder.lint.subject import Code, Found, Subject

Severity = Literal["error", "warning"]
Check = Callable[[Subject], Iterator[Found]]
Judge = Callable[[ast.AST, Code, Subject], str]
"""Says what is wrong with a piece of code, and the fix; empty where nothing is."""


@dataclass(frozen=True)
class Rule:
    """A rule: its name, how grave a finding is, one sentence, and the function that looks."""

    name: str
    severity: Severity
    summary: str
    check: Check


def rule(name: str, severity: Severity, summary: str) -> Callable[[Check], Rule]:
    """Make a rule of the function below, which yields the places that it does not accept."""
    return lambda check: Rule(name, severity, summary, check)


def code_rule(name: str, severity: Severity, summary: str) -> Callable[[Judge], Rule]:
    """Make a rule of the function below, which judges each piece of the cells' code."""

    def made(judge: Judge) -> Rule:
        def check(subject: Subject) -> Iterator[Found]:
            for code in subject.codes:
                for node in code.nodes:
                    if message := judge(node, code, subject):
                        yield code.found(node, message)

        return Rule(name, severity, summary, check)

    return made


def rules_of(*modules: ModuleType) -> dict[str, Rule]:
    """Return the rules of some modules by name, in the order in which they are written."""
    members = (value for module in modules for value in vars(module).values())
    return {value.name: value for value in members if isinstance(value, Rule)}


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
