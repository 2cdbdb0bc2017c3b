"""Looks at an instructor's assignment for tests that can be passed wrongly, or fail correct work.

A rule is a function from a ``Subject`` to what it finds, under ``@rule``, in a module of its
family. A new family of rules is a new module and its name here.
"""

from collections.abc import Iterator
from pathlib import Path

from robust_slam_autograder.lint import asserts, beside, compare, hidden, structure, text
from robust_slam_autograder.lint.allow import comments
from robust_slam_autograder.lint.rule import Finding, Rule, rule, rules_of
from robust_slam_autograder.lint.subject import Found, Subject, load

__all__ = ["RULES", "Finding", "lint"]

_OTHERS = rules_of(compare, structure, hidden, asserts, beside, text)


@rule("allow-comment", "error", "# lint: allow RULE (reason) stands where no student sees it.")
def _allow_comment(subject: Subject) -> Iterator[Found]:
    for name, cell, line in comments(subject):
        if name not in _OTHERS:
            said = "This allows nothing: give a rule of lint --rules and a reason in brackets, in"
            yield Found(cell, f"{said} a hidden region or the exercise's solution region.", line)


RULES: tuple[Rule, ...] = (*_OTHERS.values(), _allow_comment)


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
    allowed = {(name, cell) for name, cell, _ in comments(subject)}
    owners = {c.grade_id: subject.assignment.owner(c.exercise) for c in subject.assignment.cases}
    kept = [
        Finding(str(notebook), place.grade_id, place.line, rule.name, rule.severity, place.message)
        for rule in RULES
        for place in dict.fromkeys(rule.check(subject))
        if not {(rule.name, place.grade_id), (rule.name, owners.get(place.grade_id))} & allowed
    ]
    order = ["", *(cell.grade_id or "" for cell in subject.cells)]
    # A set-up cell, a cell of text and a file beside the notebook have no place: they come first.
    places = {name: order.index(name) for name in order}
    return sorted(kept, key=lambda one: (places.get(one.grade_id, 0), one.grade_id, one.line))
