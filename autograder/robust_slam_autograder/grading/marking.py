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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor.session import (
    Program,
    Session,
    SessionFault,
    StudentError,
    shows_answers,
)
from robust_slam_autograder.executor.untrusted import Notebook
from robust_slam_autograder.executor.wire import WireError
from robust_slam_autograder.grading.results import (
    CaseResult,
    ExerciseResult,
    ExerciseStatus,
    Result,
    tidy,
)
from robust_slam_autograder.reading.assignment import Assignment, Case, Piece
from robust_slam_autograder.reading.source import plain_python, used_names
from robust_slam_autograder.reading.submission import Submission
from robust_slam_autograder.sandbox import Sandbox

SEED_VARIABLE = "ROBUST_SLAM_SEED"
PUBLIC_SEED = 0
"""Visible tests draw what students draw themselves: their messages tell nothing secret."""
ALARM_GRACE = 0.5
"""The pipe's own deadline comes first; the alarm is for tests that compute on this side."""
MAX_MESSAGE = 600
NO_HINT = "A hidden check of this case did not pass."
LEFT_OUT = "A cell of your own ran longer than it may, or ended the process, and is left out"
NOT_WRITTEN = "Not written yet: the function still raises NotImplementedError."


@dataclass(frozen=True)
class Outcome:
    """How one case went in one pass."""

    passed: bool
    message: str = ""
    fault: str = ""
    """"timeout" or "died" where student code hung or died."""


Outcomes = Mapping[str, Outcome]
"""By grade id."""


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
    run = _Passes(assignment, submission, sandbox)
    visible = run.visible()
    hidden = run.hidden(visible, seed) if any(case.passed for case in visible.values()) else {}
    return run.result(student, visible, hidden)


def check(assignment: Assignment, submission: Submission, *, sandbox: Sandbox) -> Result:
    """Run the visible tests alone, for the student's own use.

    Raises:
        GraderFailure: the set-up cells do not work.
    """
    run = _Passes(assignment, submission, sandbox)
    visible = run.visible()
    return run.result("", visible, visible)


@dataclass(frozen=True)
class _Passes:
    """The passes of one submission; a cell that hung in one is left out of the next."""

    assignment: Assignment
    submission: Submission
    sandbox: Sandbox
    start: float = field(default_factory=time.monotonic)
    skip: set[int] = field(default_factory=set)

    def visible(self) -> Outcomes:
        sources = {case.grade_id: case.visible for case in self.assignment.cases}
        return self._run(sources, PUBLIC_SEED, {})

    def hidden(self, visible: Outcomes, seed: int) -> Outcomes:
        """Run all cases whole, but for those where student code hung or died already."""
        sources = {case.grade_id: case.full for case in self.assignment.cases}
        return self._run(sources, seed, {key: o for key, o in visible.items() if o.fault})

    def result(self, student: str, visible: Outcomes, hidden: Outcomes) -> Result:
        exercises = tuple(
            _exercise(name, self.assignment, self.submission, visible, hidden)
            for name in self.assignment.exercises
        )
        return Result(
            student=student,
            assignment=self.assignment.name,
            score=tidy(sum(exercise.score for exercise in exercises)),
            max_score=tidy(self.assignment.max_score),
            status="graded",
            reason=" ".join(self.submission.notes),
            sandbox=self.sandbox.name,
            seconds=round(time.monotonic() - self.start, 3),
            exercises=exercises,
        )

    def _run(self, sources: Mapping[str, str], seed: int, faults: Outcomes) -> Outcomes:
        config = self.assignment.config
        program = Program(
            setup=self.assignment.setup,
            pieces=self.submission.pieces,
            names=self.assignment.names,
            withheld=config.withheld,
        )
        end = self.start + config.limits.notebook_seconds
        session = Session(self.sandbox, program, config.limits, end, self.skip)
        try:
            with _environment(seed), _silence():
                return _Cases(self.assignment, session, sources, seed).run(faults)
        finally:
            session.close()


@dataclass(frozen=True)
class _Cases:
    """One pass over an assignment's cases."""

    assignment: Assignment
    session: Session
    sources: Mapping[str, str]
    seed: int

    def run(self, faults: Outcomes) -> Outcomes:
        """Run the cases in order; after a fault the rest of its exercise is lost.

        Args:
            faults: cases that are known to hang or die.
        """
        try:
            namespace = self._namespace()
        except SessionFault as fault:
            return {case.grade_id: _fault(fault) for case in self.assignment.cases}
        lost: dict[str, Outcome] = {}
        outcomes: dict[str, Outcome] = {}
        for case in self.assignment.cases:
            known = lost.get(case.exercise) or faults.get(case.grade_id)
            outcome = self._run_case(case, namespace, known)
            if outcome.fault:
                lost[case.exercise] = outcome
            outcomes[case.grade_id] = outcome
        return outcomes

    def _namespace(self) -> dict[str, Any]:
        """What test cells see: the set-up's names, then the student's."""
        notebook = Notebook(types.ModuleType("autograder_tests"), self._used())
        for source in self.assignment.imports:
            with contextlib.suppress(Exception):  # only what tests rely on matters
                exec(compile(source, "<imports>", "exec", dont_inherit=True), notebook.names)
        setup = list(enumerate(self.assignment.setup))
        for number, piece in setup:
            with self._setup_errors(piece):
                notebook.read(number, piece.label, piece.source, piece.own)
        for number, piece in setup:
            with self._setup_errors(piece):
                notebook.run(number)
        self.session.begin()
        notebook.names.update(self.session.bindings())
        return notebook.names

    @contextlib.contextmanager
    def _setup_errors(self, piece: Piece) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            if not shows_answers(error, self.assignment.names):
                what = f"{piece.label}, fails: {error}"
                raise GraderFailure(f"The instructor's cell, {what}") from error

    def _used(self) -> list[str]:
        used: set[str] = set()
        for grade_id, source in self.sources.items():
            try:
                used |= used_names(*ast.parse(plain_python(source)).body)
            except SyntaxError as error:
                raise GraderFailure(f"The test cell {grade_id} is no Python: {error}.") from error
        return sorted(used)

    def _run_case(self, case: Case, namespace: dict[str, Any], known: Outcome | None) -> Outcome:
        """Run a case's cell; one whose outcome is known runs for its variables alone."""
        namespace["rng"] = case_generator(self.seed, case.grade_id)
        session = self.session
        try:
            if known:
                session.fault = SessionFault("died")
            else:
                session.begin()
            with _alarm(session, self.assignment.config.limits.cell_seconds):
                exec(_compiled(self.sources[case.grade_id], case), namespace)
        except SessionFault as fault:
            return known or _fault(fault)
        except Exception as error:  # a test fails by raising, whatever it raises
            return known or self._failed(case, error)
        # A test may have swallowed the fault with a bare except.
        return known or (_fault(session.fault) if session.fault else Outcome(True))

    def _failed(self, case: Case, error: Exception) -> Outcome:
        cell_error = self.session.errors.get(self.assignment.owner(case.exercise))
        if isinstance(cell_error, SessionFault):
            return _fault(cell_error)
        if isinstance(error, NameError) and self.session.lacks_own_cells:
            return Outcome(False, f"{LEFT_OUT}: {error}.", "timeout")
        if isinstance(error, NameError) and not isinstance(error, StudentError):
            cell_error = self.session.errors.get(
                self.assignment.owner(error.name or ""), cell_error
            )
            return Outcome(False, _clip(_undefined(error, cell_error)))
        return Outcome(False, _clip(_message(error, self.sources[case.grade_id], case)))


def case_generator(seed: int, grade_id: str) -> np.random.Generator:
    """The generator that a case finds as ``rng``: it follows from seed and grade id alone."""
    digest = hashlib.sha256(grade_id.encode()).digest()
    return np.random.default_rng([seed, int.from_bytes(digest[:8], "big")])


@contextlib.contextmanager
def _environment(seed: int) -> Iterator[None]:
    """Hand the seed to the set-up cell, which plain nbgrader runs without one."""
    before = os.environ.get(SEED_VARIABLE)
    os.environ[SEED_VARIABLE] = str(seed)
    try:
        yield
    finally:
        os.environ.pop(SEED_VARIABLE)
        if before is not None:
            os.environ[SEED_VARIABLE] = before


@contextlib.contextmanager
def _silence() -> Iterator[None]:
    """What a test prints may hold hidden inputs: it goes nowhere."""
    with (
        open(os.devnull, "w") as nowhere,
        contextlib.redirect_stdout(nowhere),
        contextlib.redirect_stderr(nowhere),
    ):
        yield


@contextlib.contextmanager
def _alarm(session: Session, seconds: float) -> Iterator[None]:
    """End a test cell that computes too long on this side."""

    def expire(signum: int, frame: object) -> None:
        raise session.fail("timeout")

    before = signal.signal(signal.SIGALRM, expire)
    signal.setitimer(signal.ITIMER_REAL, seconds + ALARM_GRACE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _label(case: Case) -> str:
    return f"<{case.grade_id}>"


def _compiled(source: str, case: Case) -> types.CodeType:
    # optimize=0: under `python -O` asserts would be left out, and every test would pass.
    text = plain_python(source)
    return compile(text, _label(case), "exec", dont_inherit=True, optimize=0)


def _fault(fault: SessionFault) -> Outcome:
    said = "ran longer than it may" if fault.kind == "timeout" else "ended its whole process"
    return Outcome(False, f"Your code {said}; the rest of this exercise was not run.", fault.kind)


def _undefined(error: NameError, cell_error: StudentError | SessionFault | None) -> str:
    """Say why a name that a test uses is not there."""
    if isinstance(cell_error, StudentError):
        return f"Your cell stops with {_told(cell_error)}."
    return f"{error.name} is not defined in your notebook, or is nothing that can be checked."


def _message(error: Exception, source: str, case: Case) -> str:
    """Say what happened, for the student, from a visible test's exception."""
    if isinstance(error, StudentError):
        if isinstance(error, NotImplementedError):
            return NOT_WRITTEN
        if type(error).__name__ == WireError.__name__:
            return f"What your function returned cannot be checked: {str(error).rstrip('.')}."
        return f"Your function raised {_told(error)}."
    if isinstance(error, AssertionError):
        return str(error) or f"This does not hold: {_failing_check(error, source, case)}"
    return f"The check could not use what came back: {type(error).__name__}: {error}"


def _told(error: StudentError) -> str:
    what = f"{type(error).__name__}: {error}".rstrip(" :.")
    return f"{what} (line {error.line} of your cell)" if error.line else what


def _failing_check(error: BaseException, source: str, case: Case) -> str:
    """The statement of a visible test that did not hold."""
    frames = traceback.extract_tb(error.__traceback__)
    lines = [frame.lineno for frame in frames if frame.filename == _label(case)]
    for node in ast.walk(ast.parse(plain_python(source))):
        if isinstance(node, ast.Assert) and lines and node.lineno == lines[-1]:
            return ast.unparse(node.test)
    return "a check of this case"


def _clip(text: str) -> str:
    return text if len(text) <= MAX_MESSAGE else text[: MAX_MESSAGE - 1] + "…"


def _exercise(
    name: str,
    assignment: Assignment,
    submission: Submission,
    visible: Outcomes,
    hidden: Outcomes,
) -> ExerciseResult:
    cases = [case for case in assignment.cases if case.exercise == name]
    results = tuple(_case(case, visible, hidden) for case in cases)
    score = sum(case.earned for case in results)
    owner = assignment.owner(name)
    outcomes = [o for p in (visible, hidden) for case in cases if (o := p.get(case.grade_id))]
    fault = next((outcome for outcome in outcomes if outcome.fault), None)
    message = fault.message if fault else next((c.message for c in results if c.message), "")
    missing = not score and owner in submission.missing
    if missing:
        message = f"There is no cell {owner} in the notebook, and nothing defines its functions."
    return ExerciseResult(
        name=name,
        score=tidy(score),
        max_score=tidy(sum(case.points for case in cases)),
        status="missing" if missing else _status(results, fault),
        message=message,
        cases=results,
    )


def _status(cases: Sequence[CaseResult], fault: Outcome | None) -> ExerciseStatus:
    if fault:
        return "timeout" if fault.fault == "timeout" else "died"
    if not any(case.message for case in cases):
        return "passed"
    return "partial" if any(case.earned for case in cases) else "failed"


def _case(case: Case, visible: Outcomes, hidden: Outcomes) -> CaseResult:
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
