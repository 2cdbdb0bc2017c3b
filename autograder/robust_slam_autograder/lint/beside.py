"""What is beside the notebook: ``autograder.toml``, and answers to test the tests with."""

import ast
import re
from collections.abc import Iterator
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

from robust_slam_autograder.lint.rule import rule
from robust_slam_autograder.lint.subject import Found, Subject
from robust_slam_autograder.reading import labelled
from robust_slam_autograder.reading.assignment import CONFIG_NAME, Config
from robust_slam_autograder.reading.labelled import Answer
from robust_slam_autograder.reading.source import imported_modules, tree_of
from robust_slam_autograder.sandbox import packages
from robust_slam_autograder.student.imports import refusal, withheld_sentence

_LEAST = {"right_": (2, "accept"), "wrong_": (3, "catch")}
"""How many answers of a kind an exercise needs, and what its tests do with them."""
_GOES_ON = re.compile(
    r"(Never [a-z]+s|[A-Z][a-z]+s) (?!(only )?(it|them|both|those|all of)\b).*\."
)


@rule("no-module", "error", "Packages and withheld modules must be installed.")
def _no_module(subject: Subject) -> Iterator[Found]:
    for problem in packages.missing(subject.assignment.config.packages):
        yield Found(CONFIG_NAME, problem)
    for name in subject.assignment.config.withheld:
        if packages.spec_of(name) is None:
            said = f"withheld names {name}, which is not installed here"
            yield Found(CONFIG_NAME, f"{said}: correct it, or install it.")


@rule("not-allowed", "error", "Solutions and set-up import only what packages allows.")
def _not_allowed(subject: Subject) -> Iterator[Found]:
    for grade_id, node in _imports(subject):
        for module in imported_modules(ast.unparse(node)):
            sentence = _refusal(module, subject.assignment.config)
            if sentence is not None:
                yield Found(grade_id, sentence, node.lineno)
                break


def _refusal(module: str, config: Config) -> str | None:
    withheld = [name for name in config.withheld if f"{module}.".startswith(f"{name}.")]
    if withheld:
        return f"{withheld_sentence(withheld[0])} The solution must do without it."
    sentence = refusal(module, config.packages)
    return sentence and f"{sentence} Add it to packages in {CONFIG_NAME}, or do without it."


def _imports(subject: Subject) -> Iterator[tuple[str, ast.Import | ast.ImportFrom]]:
    """Imports that run in the student's process: of the set-up's functions those of none."""
    for cell in subject.solutions:
        for node in ast.walk(tree_of(cell.source)):
            if isinstance(node, ast.Import | ast.ImportFrom):
                yield cell.grade_id or "", node
    for piece in subject.assignment.setup:
        for node in [] if piece.own else tree_of(piece.source).body:
            if isinstance(node, ast.Import | ast.ImportFrom):
                yield piece.label, node


@rule("limits", "error", "A limit is at most the one around it.")
def _limits(subject: Subject) -> Iterator[Found]:
    limits = asdict(subject.assignment.config.limits)
    for inner, outer in pairwise(("call_seconds", "cell_seconds", "notebook_seconds")):
        if limits[inner] > limits[outer]:
            said = f"{inner} ({limits[inner]:g}) is more than {outer} ({limits[outer]:g}), and so "
            yield Found(CONFIG_NAME, f"{said}never counts: make it less.")


@rule("no-mutant", "error", "With --answers: each exercise has two right answers and three wrong.")
def _no_mutant(subject: Subject) -> Iterator[Found]:
    for path, found in _answers(subject):
        if isinstance(found, ValueError):
            continue
        for kind, (least, shall) in _LEAST.items():
            count = sum(answer.name.startswith(kind) for answer in found)
            if count < least:
                said = f"{path} has {count} of the {least} answers {kind}… that the tests must "
                yield Found(path.stem, f"{said}{shall}: write the others.")


@rule("bad-answer", "error", "With --answers: an answer can be read, and names a case of its own.")
def _bad_answer(subject: Subject) -> Iterator[Found]:
    for path in strangers(subject):
        yield Found(path.name, f"{path} answers no exercise: delete it, or name it after one.")
    for path, found in _answers(subject):
        if isinstance(found, ValueError):
            yield Found(path.name, f"The answers cannot be read: {found}.")
            continue
        cases = [one.grade_id for one in subject.assignment.cases if one.exercise == path.stem]
        for answer in found:
            if answer.caught_by not in (None, *cases):
                what = f"names {answer.caught_by}, not one of its cases: give one of "
                yield Found(path.name, f"{path}: {answer.name} {what}{', '.join(cases)}.")
            if not answer.is_right and not _GOES_ON.fullmatch(answer.story):
                what = "has no misconception that goes on after “It looks as if your function”"
                yield Found(path.name, f"{path}: {answer.name} {what}, as “Takes σ² for σ.” does.")


def strangers(subject: Subject) -> list[Path]:
    """List files of answers to exercises that the assignment does not have."""
    known = {cell.grade_id for cell in subject.solutions}
    if subject.answers is None:
        return []
    files = labelled.files(subject.answers / subject.assignment.name)
    return [path for path in files if path.stem not in known]


def _answers(subject: Subject) -> Iterator[tuple[Path, list[Answer] | ValueError]]:
    """Yield the file of each exercise with its answers, or with why it cannot be read."""
    if subject.answers is None:
        return
    folder = subject.answers / subject.assignment.name
    for cell in subject.solutions:
        path = folder / f"{cell.grade_id}.toml"
        try:
            yield path, labelled.read(path) if path.is_file() else []
        except ValueError as error:
            yield path, error
