"""Runs an exercise's visible test cells on functions of the instructor's, in this process.

Nothing here is a sandbox: what runs is the instructor's solution, changes of it, and answers
that the instructor wrote down as wrong.
"""

from __future__ import annotations

import contextlib
import copy
import functools
import io
import sys
import types
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from robust_slam_autograder.executor.seeds import PUBLIC_SEED, case_generator, environment
from robust_slam_autograder.misconceptions import facts, shapes
from robust_slam_autograder.misconceptions.facts import Fact
from robust_slam_autograder.misconceptions.prints import Trace
from robust_slam_autograder.misconceptions.shapes import Seen, Shape
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reading.assignment import Assignment, Case
from robust_slam_autograder.reading.source import plain_python

Names = dict[str, Any]
Right = Mapping[str, frozenset[str]]
"""By grade id, digests of what the solution had returned after each call."""


@dataclass(frozen=True)
class Setting:
    """An assignment whose test cells run."""

    path: Path
    """The instructor's notebook."""
    assignment: Assignment
    """The same, read."""


@dataclass
class Bench:
    """An assignment's test cells, and what they see after the solutions ran."""

    setting: Setting
    names: Names
    cells: Mapping[str, str]
    """By grade id, the instructor's solution."""
    _facts: dict[str, dict[str, Fact]] = field(default_factory=dict)

    def functions(self, exercise: str) -> dict[str, Callable[..., Any]]:
        """Return the instructor's functions that an exercise asks for."""
        assignment = self.setting.assignment
        owner = assignment.owner(exercise)
        (mine,) = [one for one in assignment.solutions if one.grade_id == owner]
        return {name: self.names[name] for name in mine.names if callable(self.names.get(name))}

    def facts(self, exercise: str) -> dict[str, Fact]:
        """Return by number and sentence the facts of an exercise's functions."""
        if exercise not in self._facts:
            found = facts.facts(self.functions(exercise))
            self._facts[exercise] = {f"{n} {one.sentence}": one for n, one in enumerate(found)}
        return self._facts[exercise]

    def with_cell(self, exercise: str, source: str) -> Names:
        """Return what test cells see with other text in an exercise's solution cell.

        Raises:
            Exception: what the cell raises.
        """
        names = dict(self.names)
        with quiet():
            exec(compiled(source, exercise), names)
        return names

    def shape(self, exercise: str, names: Names, right: Right) -> Shape:
        """Run the cases of an exercise, and note how those end that fail.

        A case that ends at the solution's own values says nothing, and ends the search.
        """
        shape = Shape()
        with quiet(), environment(PUBLIC_SEED):
            for case in self._cases(exercise):
                trace = Trace()
                if not self._passes(case, names, trace):
                    seen = shapes.seen_by(trace)
                    is_right = not right[case.grade_id].isdisjoint(seen.digests)
                    shape.failed[case.grade_id] = Seen() if is_right else seen
                if shape.lost:
                    break
        return shape

    def right(self, exercise: str) -> Right:
        """Return what the solution returns, call by call.

        Raises:
            ValueError: the solution itself loses a case.
        """
        found: dict[str, frozenset[str]] = {}
        with quiet(), environment(PUBLIC_SEED):
            for case in self._cases(exercise):
                trace = Trace()
                if not self._passes(case, self.names, trace):
                    raise ValueError(f"the solution itself loses {case.grade_id}")
                found[case.grade_id] = shapes.of_beginnings(trace)
        return found

    def _cases(self, exercise: str) -> list[Case]:
        cases = self.setting.assignment.cases
        return [case for case in cases if case.exercise == exercise and not case.has_town]

    def _passes(self, case: Case, names: Names, trace: Trace) -> bool:
        asked = {name: names[name] for name in self.setting.assignment.names if name in names}
        seen = {**names, **trace.watched(_apart(asked))}
        seen["rng"] = case_generator(PUBLIC_SEED, case.grade_id)
        try:
            exec(compiled(case.visible, case.grade_id), seen)
        except Exception:  # a test fails by raising, whatever it raises
            return False
        return True


def bench(setting: Setting) -> Bench:
    """Run the instructor's notebook."""
    code = submission.collect(notebook.read(setting.path), setting.assignment)
    module = types.ModuleType(f"solutions_{abs(hash(str(setting.path)))}")
    sys.modules[module.__name__] = module  # dataclasses look their module up by name
    with quiet(), environment(PUBLIC_SEED):
        for piece in (*setting.assignment.setup, *code.pieces):
            if not piece.own:
                exec(compiled(piece.source, piece.label), module.__dict__)
    cells = {piece.label: piece.source for piece in code.pieces if not piece.own}
    return Bench(setting, module.__dict__, cells)


def _apart(names: Names) -> Names:
    """Return functions that get copies of their arguments, as across a pipe."""

    def apart(function: Callable[..., Any]) -> Callable[..., Any]:
        return lambda *args, **kwargs: function(
            *map(_copied, args), **{name: _copied(one) for name, one in kwargs.items()}
        )

    return {name: apart(one) if callable(one) else one for name, one in names.items()}


def _copied(value: Any) -> Any:  # noqa: ANN401
    return value if callable(value) else copy.deepcopy(value)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Suppress warnings and what the code prints."""
    with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
        warnings.simplefilter("ignore")
        yield


@functools.cache
def compiled(source: str, label: str) -> types.CodeType:
    """Return a cell's code, of which an error names the cell."""
    return compile(plain_python(source), f"<{label}>", "exec", dont_inherit=True, optimize=0)
