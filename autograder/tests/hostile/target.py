"""An assignment as an attacker sees it: the release, right answers, and one exercise to fake."""

import ast
import json
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from robust_slam_autograder.publishing import student_release
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.assignment import Assignment, Case
from robust_slam_autograder.reading.source import used_names

Notebook = dict[str, Any]


@dataclass(frozen=True)
class Target:
    """One assignment and the exercise of it that every submission attacks."""

    assignment: Assignment
    """The instructor's, hidden tests included: for whoever judges, never for an attack."""
    released: Notebook
    answers: dict[str, str]
    """Right sources by the grade id of their solution cell."""
    victim: str
    """Grade id of the solution cell that is attacked; all others are answered rightly."""

    @property
    def name(self) -> str:
        return self.assignment.name

    @property
    def file(self) -> str:
        return f"{self.assignment.notebook}.ipynb"

    @property
    def reference(self) -> str:
        """The victim's right source."""
        return self.answers[self.victim]

    @property
    def functions(self) -> tuple[str, ...]:
        return functions_of(self.reference)

    @property
    def victim_cases(self) -> tuple[Case, ...]:
        """The cases that the victim's points hang on."""
        cases = self.assignment.cases
        return tuple(c for c in cases if self.assignment.owner(c.exercise) == self.victim)

    def solved(self, victim: str | None = None) -> Notebook:
        """The release with every exercise answered, the victim by this source if one is given."""
        notebook = deepcopy(self.released)
        for cell in notebook["cells"]:
            owner = grade_id_of(cell)
            if owner in self.answers:
                right = victim is None or owner != self.victim
                cell["source"] = self.answers[owner] if right else victim
        return notebook

    def index(self, notebook: Notebook) -> int:
        """Where the victim's solution cell stands."""
        return [grade_id_of(cell) for cell in notebook["cells"]].index(self.victim)


def load(tree: Path, name: str, releases: Path) -> Target:
    """Read an assignment of a source tree, and its release, which is made in a folder."""
    path = assignments.notebook_path(tree / name)
    student_release.release(tree, [name], releases)
    found = assignments.load(path)
    answers = {
        grade_id_of(cell): _clean("".join(cell["source"]))
        for cell in _read(path)["cells"]
        if grade_id_of(cell) in {solution.grade_id for solution in found.solutions}
    }
    return Target(found, _read(releases / name / path.name), answers, _victim(found, answers))


def _victim(assignment: Assignment, answers: dict[str, str]) -> str:
    """Grade id of a solution cell whose hidden cases stand alone: nothing else reads its names."""
    hidden = {assignment.owner(c.exercise) for c in assignment.cases if c.has_hidden}
    return next(
        owner
        for owner, source in answers.items()
        if owner in hidden and functions_of(source) and not _is_read(owner, assignment, answers)
    )


def _is_read(owner: str, assignment: Assignment, answers: dict[str, str]) -> bool:
    others = [source for other, source in answers.items() if other != owner]
    others += [c.full for c in assignment.cases if assignment.owner(c.exercise) != owner]
    read_elsewhere = set[str]().union(*(used_names(*ast.parse(text).body) for text in others))
    return bool(read_elsewhere.intersection(functions_of(answers[owner])))


def functions_of(source: str) -> tuple[str, ...]:
    """Names of the functions that a source defines at its top level."""
    return tuple(n.name for n in ast.parse(source).body if isinstance(n, ast.FunctionDef))


def _clean(source: str) -> str:
    """An instructor's solution as a student would write it, without nbgrader's marks."""
    marks = ("### BEGIN SOLUTION", "### END SOLUTION")
    lines = source.split("\n")
    return "\n".join(line for line in lines if line.strip() not in marks).strip("\n") + "\n"


def _read(path: Path) -> Notebook:
    return json.loads(path.read_text(encoding="utf-8"))


def grade_id_of(cell: dict[str, Any]) -> str:
    """A cell's grade id; empty where it has none."""
    return str(cell["metadata"].get("nbgrader", {}).get("grade_id", ""))
