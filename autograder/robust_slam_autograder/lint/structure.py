"""How an assignment is put together: exercises, cases, points, solution cells."""

import ast
import re
from collections.abc import Iterator, Sequence
from itertools import pairwise

from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import (
    BEGIN_SOLUTION,
    END_SOLUTION,
    Code,
    Found,
    Subject,
    last_name,
    regions,
)
from robust_slam_autograder.reading.assignment import Case
from robust_slam_autograder.reading.notebook import Cell
from robust_slam_autograder.reading.source import defined_names

LEAST_HIDDEN = 2


@rule("unreadable", "error", "A test cell or set-up cell must be Python.")
def _unreadable(subject: Subject) -> Iterator[Found]:
    yield from subject.unreadable
    for cell in subject.cells:
        if cell.kind != "code" and cell.grade != cell.solution:
            yield Found(cell.grade_id or "", f"This cell is {cell.kind}: press Y to make it code.")


@rule("few-hidden-cases", "error", "An exercise needs two cases with hidden checks.")
def _few_hidden_cases(subject: Subject) -> Iterator[Found]:
    for cell, cases in _exercises(subject):
        hidden = sum(case.has_hidden for case in cases)
        if cases and hidden < LEAST_HIDDEN:
            said = f"Cases with hidden checks: {hidden}. Make it {LEAST_HIDDEN} at least, so that"
            yield Found(cell.grade_id or "", f"{said} an answer fitted to what is visible loses.")


def _exercises(subject: Subject) -> Iterator[tuple[Cell, list[Case]]]:
    """Solution cells with the cases that are named after them."""
    owner = subject.assignment.owner
    for cell in subject.solutions:
        cases = subject.assignment.cases
        yield cell, [case for case in cases if owner(case.exercise) == cell.grade_id]


@rule("orphan-case", "warning", "A case is named after its exercise.")
def _orphan_case(subject: Subject) -> Iterator[Found]:
    known = {cell.grade_id for cell, cases in _exercises(subject) for _ in cases}
    for case in subject.assignment.cases:
        if subject.assignment.owner(case.exercise) not in known:
            said = "This case counts as an exercise of its own: name it <exercise>-<case>."
            yield Found(case.grade_id, said)


@rule("no-points", "error", "An exercise needs a case that gives points.")
def _no_points(subject: Subject) -> Iterator[Found]:
    texts = (case.full for case in subject.assignment.cases)
    used = {name for text in texts for name in re.findall(r"[^\W\d]\w*", text)}
    for cell, cases in _exercises(subject):
        names = set(defined_names(cell.source))
        # A tree with names of another kind, or a helper that another exercise's cases call.
        if not cases and not names & used:
            said = f"No case gives points for this cell: add test cells {cell.grade_id}-<case>."
            yield Found(cell.grade_id or "", said)


@rule("odd-points", "error", "A case has whole points, 1 or more.")
def _odd_points(subject: Subject) -> Iterator[Found]:
    for case in subject.assignment.cases:
        if case.points <= 0 or not float(case.points).is_integer():
            said = f"This case has {case.points:g} points: give it a whole number, 1 or more."
            yield Found(case.grade_id, said)


@rule("no-check", "error", "A case, and its hidden region, must assert something.")
def _no_check(subject: Subject) -> Iterator[Found]:
    for code in subject.tests:
        checks = _checks(code, subject)
        if not checks:
            yield Found(code.grade_id, "Nothing is asserted here: whatever runs earns points.")
        elif code.regions and not any(code.is_hidden(node) for node in checks):
            said = "Nothing is asserted in the hidden region: add it."
            yield Found(code.grade_id, said, code.regions[0].start)


def _checks(code: Code, subject: Subject) -> Sequence[ast.AST]:
    """What can fail: asserts, raises, functions that assert."""
    found: list[ast.AST] = []
    for node in code.nodes:
        if isinstance(node, ast.Assert | ast.Raise):
            found.append(node)
        elif isinstance(node, ast.Call):
            name = last_name(node.func)
            helper = subject.helpers.get(name)
            inside = ast.walk(helper) if helper else ()
            asserts = any(isinstance(part, ast.Assert | ast.Raise) for part in inside)
            if asserts or name.startswith("assert") or name in ("fail", "raises", "eq_", "ok_"):
                found.append(node)
    return found


@rule("no-solution-region", "error", "A solution cell marks what the release leaves out.")
def _no_solution_region(subject: Subject) -> Iterator[Found]:
    for cell in subject.solutions:
        if not regions(cell.source, BEGIN_SOLUTION, END_SOLUTION):
            said = (
                f"Put the answer between ### {BEGIN_SOLUTION} and ### {END_SOLUTION}: without them"
            )
            yield Found(cell.grade_id or "", f"{said} the release has a stub for the whole cell.")


@rule("late-picture", "warning", "What draws a student's function stands above its checks.")
def _late_picture(subject: Subject) -> Iterator[Found]:
    for cell, below in pairwise(subject.cells):
        is_own = below.kind == "code" and below.grade_id is None
        used = set(re.findall(r"\w+", below.source)) & set(subject.assignment.names)
        if cell.grade and is_own and used:
            said = f"The cell below uses {min(used)}, and JupyterLab stops at a check that fails: "
            yield Found(cell.grade_id or "", f"{said}move it directly below the function's cell.")
