"""The reference solutions in this process, so that one case runs in milliseconds.

Nothing here is a sandbox: run only the instructor's own code with it.
"""

import contextlib
import io
import sys
import types
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from robust_slam_autograder.executor.seeds import PUBLIC_SEED, case_generator, environment
from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment, Case
from robust_slam_autograder.reading.source import compiled

from solutions.classes import answers

Functions = Mapping[str, Callable[..., Any]]
"""What stands in for the student's functions, by name."""


@dataclass(frozen=True)
class Reference:
    """An assignment, and the names that its test cells see after the reference solutions ran."""

    assignment: Assignment
    names: Mapping[str, Any]

    @property
    def functions(self) -> Functions:
        """Return the reference's functions, by the names that students are asked to define."""
        return {name: self.names[name] for name in self.assignment.names}

    def run(self, case: Case, seed: int, functions: Functions | None = None) -> None:
        """Run a whole case, hidden checks included; it fails by raising.

        Args:
            case: one of the assignment's.
            seed: of the batch, as for the grader.
            functions: replace the reference's in the test cell, and nowhere else.
        """
        names = {**self.names, **(functions or {})}
        names["rng"] = case_generator(seed, case.grade_id)
        with quiet():
            exec(compiled(case.full, f"<{case.grade_id}>"), names)


@cache
def load(name: str, tree: Path = answers.SOLUTIONS) -> Reference:
    """Read an assignment of a source tree and run its set-up and solution cells."""
    path = tree / name / f"{name}.ipynb"
    assignment = assignment_module.load(path)
    code = submission.collect(notebook.read(path), assignment)
    module = types.ModuleType(f"solutions_{abs(hash(str(path)))}")
    sys.modules[module.__name__] = module  # dataclasses look their module up by name
    with quiet(), environment(PUBLIC_SEED):
        for piece in (*assignment.setup, *code.pieces):
            if not piece.own:
                exec(compiled(piece.source, f"<{piece.label}>"), module.__dict__)
    return Reference(assignment, module.__dict__)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress warnings and what the code prints."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield
