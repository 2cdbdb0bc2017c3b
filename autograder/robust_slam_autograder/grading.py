"""Grades one submission: visible tests with their messages, then hidden ones with hints.

Tests run here, in the trusted process; the student's functions are proxies
that call across the pipe. A case earns its points only when this side reached
the end of its cell.
"""

from __future__ import annotations

import ast
import contextlib
import hashlib
import os
import signal
import time
import traceback
import types
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from robust_slam_autograder.assignment import Assignment, Case
from robust_slam_autograder.results import (
    CaseResult,
    ExerciseResult,
    ExerciseStatus,
    Result,
    tidy,
)
from robust_slam_autograder.sandbox import Sandbox
from robust_slam_autograder.session import Program, Session, SessionFault, StudentError
from robust_slam_autograder.submission import Submission

SEED_VARIABLE = "ROBUST_SLAM_SEED"
MAX_MESSAGE = 600
NO_HINT = "A hidden check of this case did not pass."
NOT_WRITTEN = "Not written yet: the function still raises NotImplementedError."


@dataclass(frozen=True)
class Outcome:
    """How one case went in one pass."""

    passed: bool
    message: str = ""
    fault: str = ""
    """"timeout" or "died" where student code hung or died."""


def grade(
    assignment: Assignment, submission: Submission, *, student: str, seed: int, sandbox: Sandbox
) -> Result:
    """Grade a submission in two passes, each with an untrusted process of its own.

    Args:
        assignment: the instructor's tests.
        submission: the student's code.
        student: whose it is.
        seed: the batch's secret seed; hidden inputs follow from it and the case's grade id.
        sandbox: where student code runs.

    Raises:
        GraderFailure: the sandbox or the instructor's set-up cells do not work.
    """
    start = time.monotonic()
    end = start + assignment.config.limits.notebook_seconds
    run = _Passes(assignment, submission, seed, sandbox, end)
    visible = run.visible()
    hidden = run.hidden(visible) if any(outcome.passed for outcome in visible.values()) else {}
    exercises = tuple(
        _exercise(name, assignment, submission, visible, hidden) for name in assignment.exercises
    )
    return Result(
        student=student,
        assignment=assignment.name,
        score=tidy(sum(exercise.score for exercise in exercises)),
        max_score=tidy(assignment.max_score),
        status="graded",
        reason=" ".join(submission.notes),
        sandbox=sandbox.name,
        seconds=round(time.monotonic() - start, 3),
        exercises=exercises,
    )


def check(assignment: Assignment, submission: Submission, *, sandbox: Sandbox) -> Result:
    """Run the visible tests alone, for the student's own use."""
    start = time.monotonic()
    end = start + assignment.config.limits.notebook_seconds
    visible = _Passes(assignment, submission, 0, sandbox, end).visible()
    exercises = tuple(
        _exercise(name, assignment, submission, visible, visible) for name in assignment.exercises
    )
    score, seconds = sum(exercise.score for exercise in exercises), time.monotonic() - start
    return Result(
        student="",
        assignment=assignment.name,
        score=tidy(score),
        max_score=tidy(assignment.max_score),
        status="graded",
        reason=" ".join(submission.notes),
        sandbox=sandbox.name,
        seconds=round(seconds, 3),
        exercises=exercises,
    )


@dataclass(frozen=True)
class _Passes:
    assignment: Assignment
    submission: Submission
    seed: int
    sandbox: Sandbox
    end: float

    def visible(self) -> dict[str, Outcome]:
        return self._run({case.grade_id: case.visible for case in self.assignment.cases}, {})

    def hidden(self, visible: Mapping[str, Outcome]) -> dict[str, Outcome]:
        """Run all cases whole, but for the exercises that hung or died already."""
        faults = {
            case.exercise: visible[case.grade_id]
            for case in self.assignment.cases
            if visible[case.grade_id].fault
        }
        return self._run({case.grade_id: case.full for case in self.assignment.cases}, faults)

    def _run(
        self, sources: Mapping[str, str], faults: Mapping[str, Outcome]
    ) -> dict[str, Outcome]:
        session = Session(self.sandbox, self._program(), self.assignment.config.limits, self.end)
        try:
            return self._run_cases(session, sources, dict(faults))
        finally:
            session.close()

    def _program(self) -> Program:
        return Program(
            setup=self.assignment.setup,
            pieces=self.submission.pieces,
            names=self.assignment.names,
            withheld=self.assignment.config.withheld,
        )

    def _run_cases(
        self, session: Session, sources: Mapping[str, str], faults: dict[str, Outcome]
    ) -> dict[str, Outcome]:
        namespace = types.ModuleType("tests").__dict__
        os.environ[SEED_VARIABLE] = str(self.seed)
        for source in self.assignment.setup:
            exec(compile(source, "<set-up>", "exec", dont_inherit=True), namespace)
        try:
            namespace |= session.bindings()
        except SessionFault as fault:
            return {case.grade_id: _fault(fault) for case in self.assignment.cases}
        outcomes: dict[str, Outcome] = {}
        for case in self.assignment.cases:
            if case.exercise not in faults:
                namespace["rng"] = case_generator(self.seed, case.grade_id)
                outcome = self._run_case(session, case, sources[case.grade_id], namespace)
                if outcome.fault:
                    faults[case.exercise] = outcome
            outcomes[case.grade_id] = faults.get(case.exercise) or outcome
        return outcomes

    def _run_case(
        self, session: Session, case: Case, source: str, namespace: dict[str, Any]
    ) -> Outcome:
        label = f"<{case.grade_id}>"
        try:
            with _deadline(self.assignment.config.limits.cell_seconds):
                exec(compile(source, label, "exec", dont_inherit=True), namespace)
        except SessionFault as fault:
            return _fault(fault)
        except Exception as error:  # a test fails by raising, whatever it raises
            cell_error = session.errors.get(case.exercise)
            if isinstance(cell_error, SessionFault):
                return _fault(cell_error)
            return Outcome(False, _message(error, cell_error, source, label))
        return Outcome(True)


def case_generator(seed: int, grade_id: str) -> np.random.Generator:
    """The generator that a case finds as ``rng``: it follows from seed and grade id alone."""
    digest = hashlib.sha256(grade_id.encode()).digest()
    return np.random.default_rng([seed, int.from_bytes(digest[:8], "big")])


@contextlib.contextmanager
def _deadline(seconds: float) -> Iterator[None]:
    """End a test cell that computes too long on this side."""

    def expire(signum: int, frame: object) -> None:
        raise SessionFault("timeout")

    before = signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _fault(fault: SessionFault) -> Outcome:
    said = "ran longer than it may" if fault.kind == "timeout" else "ended its whole process"
    return Outcome(False, f"Your code {said}; the rest of this exercise was not run.", fault.kind)


def _message(error: Exception, cell_error: StudentError | None, source: str, label: str) -> str:
    """Say what happened, for the student, from a visible test's exception."""
    if isinstance(error, NameError) and cell_error is not None:
        return _clip(f"Your cell stops with {_told(cell_error)}.")
    if isinstance(error, StudentError):
        if isinstance(error, NotImplementedError):
            return NOT_WRITTEN
        return _clip(f"Your function raised {_told(error)}.")
    if isinstance(error, AssertionError):
        return _clip(str(error) or f"This does not hold: {_failing_check(error, source, label)}")
    return _clip(f"The check could not use what came back: {type(error).__name__}: {error}")


def _told(error: StudentError) -> str:
    where = f" in line {error.line} of your cell" if error.line else ""
    return f"{type(error).__name__}: {error}{where}"


def _failing_check(error: BaseException, source: str, label: str) -> str:
    """The statement of a visible test that did not hold."""
    frames = [f for f in traceback.extract_tb(error.__traceback__) if f.filename == label]
    line = frames[-1].lineno if frames else None
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Assert) and node.lineno == line:
            return ast.unparse(node.test)
    return "a check of this case"


def _clip(text: str) -> str:
    return text if len(text) <= MAX_MESSAGE else text[: MAX_MESSAGE - 1] + "…"


def _exercise(
    name: str,
    assignment: Assignment,
    submission: Submission,
    visible: Mapping[str, Outcome],
    hidden: Mapping[str, Outcome],
) -> ExerciseResult:
    cases = [case for case in assignment.cases if case.exercise == name]
    results = tuple(_case(case, visible, hidden) for case in cases)
    score, most = sum(c.earned for c in results), sum(c.points for c in results)
    missing = not score and name in submission.missing
    faults = [o.fault for p in (visible, hidden) for c in cases if (o := p.get(c.grade_id))]
    message = next((case.message for case in results if case.message), "")
    if missing:
        message = f"There is no cell {name} in the notebook, and nothing defines its functions."
    return ExerciseResult(
        name=name,
        score=tidy(score),
        max_score=tidy(most),
        status="missing" if missing else _status(score, most, faults),
        message=message,
        cases=results,
    )


def _status(score: float, most: float, faults: list[str]) -> ExerciseStatus:
    if "timeout" in faults:
        return "timeout"
    if "died" in faults:
        return "died"
    if score >= most:
        return "passed"
    return "partial" if score > 0 else "failed"


def _case(case: Case, visible: Mapping[str, Outcome], hidden: Mapping[str, Outcome]) -> CaseResult:
    outcome = visible[case.grade_id]
    message = outcome.message
    if outcome.passed and case.has_hidden:
        outcome = hidden[case.grade_id]
        # One bit and the instructor's sentence: a hidden check's own words may hold its inputs.
        message = "" if outcome.passed else case.hint or NO_HINT
    return CaseResult(
        name=case.name,
        points=tidy(case.points),
        earned=tidy(case.points) if outcome.passed else 0,
        visible=not case.has_hidden,
        message=message,
    )
