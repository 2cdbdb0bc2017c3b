"""Looks at an instructor's assignment for tests that can be passed wrongly, or fail correct work.

A rule is a function from a ``Subject`` to what it finds, under ``@rule``, in a module of its
family. A new family of rules is a new module and its name here.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from robust_slam_autograder.lint import asserts, beside, compare, hidden, structure, text
from robust_slam_autograder.lint.allow import allowances
from robust_slam_autograder.lint.rule import Finding, Rule, rule, rules_of
from robust_slam_autograder.lint.subject import Found, Subject, load

__all__ = ["RULES", "Finding", "lint"]

_ABOUT_TESTS = rules_of(compare, structure, hidden, asserts, beside, text)


@rule(
    "allow-comment",
    "error",
    "# lint: allow RULE (reason) has a reason, and stands where no student sees it.",
)
def _bad_comments(subject: Subject) -> Iterator[Found]:
    yield from allowances(subject, _ABOUT_TESTS)[1]


@rule("allow-unused", "warning", "What a comment allows is there.")
def _unused_comments(subject: Subject) -> Iterator[Found]:
    for allowed in allowances(subject, _ABOUT_TESTS)[0]:
        found = _ABOUT_TESTS[allowed.rule].check(subject)
        if not any(allowed.covers(allowed.rule, place) for place in found):
            what = f"Nothing here breaks {allowed.rule}: delete the comment."
            yield Found(allowed.cell, what, allowed.line)


RULES: tuple[Rule, ...] = (*_ABOUT_TESTS.values(), _bad_comments, _unused_comments)


def lint(notebook: Path, answers: Path | None = None, book: Path | None = None) -> list[Finding]:
    """Run every rule on an assignment.

    Args:
        notebook: the instructor's.
        answers: folder of right and wrong answers, ``<assignment>/<exercise>.toml``.
        book: folder of the book's pages.

    Returns:
        what was found and is not allowed, in the order of the cells.

    Raises:
        WrongUse: the notebook or its ``autograder.toml`` cannot be used.
    """
    subject = load(notebook, answers, book)
    allowed, _ = allowances(subject, _ABOUT_TESTS)
    kept = [
        Finding(str(notebook), place.grade_id, place.line, rule.name, rule.severity, place.message)
        for rule in RULES
        for place in dict.fromkeys(rule.check(subject))
        if not any(one.covers(rule.name, place) for one in allowed)
    ]
    order = ["", *(cell.grade_id or "" for cell in subject.cells)]
    # A set-up cell, a cell of text and a file beside the notebook have no place: they come first.
    places = {name: order.index(name) for name in order}
    return sorted(kept, key=lambda one: (places.get(one.grade_id, 0), one.grade_id, one.line))
