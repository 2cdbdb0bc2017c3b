"""Grades one submission: visible tests with their messages, then hidden ones with hints.

Tests run here, in the trusted process. The student's functions are proxies that call
across the pipe. A case earns its points only when this side reached the end of its cell.

The hidden pass yields one ``Ending`` a case and no text. So nothing that student code
says there can reach the result: its messages are the instructor's hints and the
constants of this module.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import signal
import time
import types
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor import memory
from robust_slam_autograder.executor.budget import Deadline, Meter
from robust_slam_autograder.executor.session import (
    Program,
    Session,
    SessionFault,
    StudentError,
    shows_answers,
)
from robust_slam_autograder.grading import causes, explain, wording
from robust_slam_autograder.grading.explain import Returned
from robust_slam_autograder.grading.results import (
    CaseResult,
    Ending,
    ExerciseResult,
    ExerciseStatus,
    Result,
    tidy,
)
from robust_slam_autograder.grading.wording import FAULT_SENTENCES, NO_HINT, Told
from robust_slam_autograder.reading.assignment import Assignment, Case, Piece
from robust_slam_autograder.reading.source import compiled, names_read, plain_python
from robust_slam_autograder.reading.submission import Submission
from robust_slam_autograder.sandbox import Sandbox
from robust_slam_autograder.student.untrusted import Notebook

SEED_VARIABLE = "ROBUST_SLAM_SEED"
PUBLIC_SEED = 0
"""Visible tests draw what students draw themselves: their messages tell nothing secret."""
ALARM_GRACE = 0.5
"""The pipe's own deadline comes first; the alarm is for tests that compute on this side."""


@dataclass(frozen=True)
class Outcome:
    """How one case went in the visible pass."""

    ending: Ending
    told: Told


Outcomes = Mapping[str, Outcome]
"""By grade id."""
Endings = Mapping[str, Ending]
"""By grade id."""
_Event = tuple[Case, Ending, Exception | None]
"""A case, how it ended, and what it raised, which may hold a student's words."""


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
    passed = any(outcome.ending is Ending.PASSED for outcome in visible.values())
    return run.result(student, visible, run.hidden(visible, seed) if passed else {})


def check(
    assignment: Assignment,
    submission: Submission,
    *,
    sandbox: Sandbox,
    report: Callable[[ExerciseResult], None] | None = None,
) -> Result:
    """Run the visible tests alone, for the student's own use.

    Args:
        assignment: the tests.
        submission: the student's code.
        sandbox: where the student's code runs.
        report: called with each exercise as it ends.

    Raises:
        GraderFailure: the set-up cells do not work.
    """
    run = _Passes(assignment, submission, sandbox)
    visible = run.visible(report)
    return run.result("", visible, _endings(visible))


def _endings(outcomes: Outcomes) -> Endings:
    return {key: outcome.ending for key, outcome in outcomes.items()}


@dataclass(frozen=True)
class _Passes:
    """The passes of one submission; a cell that hung in one is left out of the next."""

    assignment: Assignment
    submission: Submission
    sandbox: Sandbox
    skip: set[int] = field(default_factory=set)
    start: float = field(default_factory=time.monotonic)

    @cached_property
    def total(self) -> Deadline:
        """The time that all passes have together."""
        return Meter().start(self.assignment.config.limits.notebook_seconds)

    def visible(self, report: Callable[[ExerciseResult], None] | None = None) -> Outcomes:
        """Run what students can see, and explain what fails; ``report`` as in ``check``."""
        last = {case.exercise: case for case in self.assignment.cases}
        sources = {case.grade_id: case.visible for case in self.assignment.cases}
        found: dict[str, Outcome] = {}
        lost: dict[str, Told] = {}
        with self._session() as session, _environment(PUBLIC_SEED), _silence():
            cases = _Cases(self.assignment, session, sources, PUBLIC_SEED, explain.Calls())
            for case, ending, error in cases.run({}):
                outcome = cases.explain(case, ending, error)
                if ending.is_fault:
                    outcome = Outcome(ending, lost.setdefault(case.exercise, outcome.told))
                found[case.grade_id] = outcome
                if report is not None and case is last[case.exercise]:
                    report(self._exercise(case.exercise, found, _endings(found)))
        return found

    def hidden(self, visible: Outcomes, seed: int) -> Endings:
        """Run all cases whole, but for those where student code hung or died already."""
        sources = {case.grade_id: case.full for case in self.assignment.cases}
        known = {key: o.ending for key, o in visible.items() if o.ending.is_fault}
        with self._session() as session, _environment(seed), _silence():
            cases = _Cases(self.assignment, session, sources, seed)
            return {case.grade_id: ending for case, ending, _ in cases.run(known)}

    def result(self, student: str, visible: Outcomes, hidden: Endings) -> Result:
        names = self.assignment.exercises
        exercises = tuple(self._exercise(name, visible, hidden) for name in names)
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

    def _exercise(self, name: str, visible: Outcomes, hidden: Endings) -> ExerciseResult:
        return _exercise(name, self.assignment, self.submission, visible, hidden)

    @contextlib.contextmanager
    def _session(self) -> Iterator[Session]:
        config = self.assignment.config
        program = Program(
            setup=self.assignment.setup,
            pieces=self.submission.pieces,
            names=self.assignment.names,
            withheld=config.withheld,
            packages=config.packages,
            libraries=self.assignment.libraries,
        )
        session = Session(self.sandbox, program, config.limits, self.total, self.skip)
        try:
            yield session
        finally:
            session.close()


@dataclass(frozen=True)
class _Cases:
    """One pass over an assignment's cases."""

    assignment: Assignment
    session: Session
    sources: Mapping[str, str]
    seed: int
    calls: explain.Calls | None = None
    """Calls of the student's functions, recorded in the visible pass alone."""

    def run(self, faults: Endings) -> Iterator[_Event]:
        """Run the cases in order; after a fault the rest of its exercise is lost.

        Args:
            faults: cases that are known to hang or die.

        Raises:
            GraderFailure: the sandbox or the instructor's cells do not work.
        """
        tests = self._compiled()
        try:
            namespace = self._namespace(names_read(*tests.values()))
        except SessionFault as fault:
            yield from ((case, Ending(fault.kind), None) for case in self.assignment.cases)
            return
        lost: dict[str, Ending] = {}
        for case in self.assignment.cases:
            known = lost.get(case.exercise) or faults.get(case.grade_id)
            ending, error = self._run_case(case, tests[case.grade_id], namespace, known)
            if ending.is_fault:
                lost[case.exercise] = ending
            yield case, ending, error

    def explain(self, case: Case, ending: Ending, error: Exception | None) -> Outcome:
        """Say to the student how a case ended in the visible pass.

        What is explained came from student code, so the explanation itself may fail.
        """
        try:
            with self._bounded():
                return Outcome(ending, self._explained(case, ending, error))
        except (Exception, SessionFault):
            return Outcome(ending, wording.own(FAULT_SENTENCES.get(ending, wording.UNEXPLAINED)))

    @contextlib.contextmanager
    def _bounded(self) -> Iterator[None]:
        """Bound the time and the memory of what runs on this side with what student code sent."""
        with _alarm(self.session), memory.for_tests():
            yield

    def _explained(self, case: Case, ending: Ending, error: Exception | None) -> Told:
        errors, owner = self.session.errors, self.assignment.owner
        cell_error = errors.get(owner(case.exercise))
        if error is None or isinstance(cell_error, SessionFault):
            return wording.own(FAULT_SENTENCES[ending]) if ending.is_fault else Told()
        if isinstance(error, NameError) and ending.is_fault:
            return wording.left_out(error)
        if isinstance(error, NameError) and not isinstance(error, StudentError):
            cell_error = errors.get(owner(error.name or ""), cell_error)
            told = wording.undefined(error, cell_error)
            return told.further(self._cause(case, cell_error))
        told = wording.message(error, self.sources[case.grade_id], case)
        if cause := self._cause(case, error):
            return told.further(cause)
        returned = self._returned(case, error)
        return told.further(returned.text, returned.compared)

    def _returned(self, case: Case, error: Exception) -> Returned:
        """What a function returned and what was expected; it may be empty."""
        if self.calls is None or isinstance(error, StudentError):
            return Returned()
        # A function that the student handed over must not be called again.
        fault, self.session.fault = self.session.fault, SessionFault("died")
        try:
            return explain.returned(error, plain_python(self.sources[case.grade_id]), self.calls)
        except SessionFault:
            return Returned()
        finally:
            self.session.fault = fault

    def _cause(self, case: Case, error: object) -> str:
        """A line that says what most often causes a student's exception; it may be empty."""
        if not isinstance(error, StudentError) or isinstance(error, NotImplementedError):
            return ""
        owner = self.assignment.owner(case.exercise)
        cells = {piece.label: piece.source for piece in self.session.program.pieces}
        return causes.of(error, cells.get(owner, ""), self.assignment.config.causes)

    def _compiled(self) -> dict[str, types.CodeType]:
        found = {}
        for case in self.assignment.cases:
            try:
                found[case.grade_id] = compiled(self.sources[case.grade_id], wording.label(case))
            except (SyntaxError, ValueError) as error:
                what = f"The test cell {case.grade_id} is no Python: {error}."
                raise GraderFailure(what) from error
        return found

    def _namespace(self, used: Collection[str]) -> dict[str, Any]:
        """What test cells see: the set-up's names, as far as they are used, then the student's."""
        notebook = Notebook(types.ModuleType("autograder_tests"), used)
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
        bindings = self.session.bindings()
        notebook.names.update(self.calls.watched(bindings) if self.calls else bindings)
        return notebook.names

    @contextlib.contextmanager
    def _setup_errors(self, piece: Piece) -> Iterator[None]:
        try:
            yield
        except Exception as error:
            if not shows_answers(error, self.assignment.names):
                what = f"{piece.label}, fails: {error}"
                raise GraderFailure(f"The instructor's cell, {what}") from error

    def _run_case(
        self, case: Case, test: types.CodeType, namespace: dict[str, Any], known: Ending | None
    ) -> tuple[Ending, Exception | None]:
        """Run a case's cell.

        A case that is lost already still runs, because later cases use its variables.
        """
        session = self.session
        try:
            if known:
                session.fault = SessionFault("died")
            else:
                session.begin()
        except SessionFault as fault:
            return Ending(fault.kind), None
        namespace["rng"] = case_generator(self.seed, case.grade_id)
        if self.calls is not None:
            self.calls.begin(wording.label(case), namespace)
        before = dict(namespace)
        try:
            with self._bounded():
                exec(test, namespace)
        except SessionFault as fault:
            return known or Ending(fault.kind), None
        except Exception as error:  # a test fails by raising, whatever it raises
            if isinstance(error, MemoryError):
                namespace.clear()  # what the test gathered is not to cost the cases that follow
                namespace.update(before)
            ending = known or self._ending(case, error)
            return ending, None if known else error
        if known or session.fault is None:
            return known or Ending.PASSED, None
        # A test may have swallowed the fault with a bare except.
        return Ending(session.fault.kind), None

    def _ending(self, case: Case, error: Exception) -> Ending:
        """How a case ended whose test raised."""
        cell_error = self.session.errors.get(self.assignment.owner(case.exercise))
        if isinstance(cell_error, SessionFault):
            return Ending(cell_error.kind)
        if isinstance(error, NameError) and self.session.lacks_own_cells:
            return Ending.TIMEOUT  # so that the batch grades it once more, alone
        return Ending.FAILED


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
def _alarm(session: Session) -> Iterator[None]:
    """End what computes too long on this side; a browser has no alarms."""
    if not hasattr(signal, "setitimer"):
        yield
        return

    def look(signum: int, frame: object) -> None:
        left = session.time_left()
        if left <= 0:
            raise session.fail("timeout")
        signal.setitimer(signal.ITIMER_REAL, left + ALARM_GRACE)

    before = signal.signal(signal.SIGALRM, look)
    signal.setitimer(signal.ITIMER_REAL, session.time_left() + ALARM_GRACE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def _exercise(
    name: str,
    assignment: Assignment,
    submission: Submission,
    visible: Outcomes,
    hidden: Endings,
) -> ExerciseResult:
    cases = [case for case in assignment.cases if case.exercise == name]
    results = tuple(_case(case, visible, hidden) for case in cases)
    score = sum(case.earned for case in results)
    owner = assignment.owner(name)
    fault, message = _fault(cases, visible, hidden)
    message = message or next((case.message for case in results if case.message), "")
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


def _fault(cases: Sequence[Case], visible: Outcomes, hidden: Endings) -> tuple[Ending | None, str]:
    """The first fault of an exercise, and what to say of it."""
    for outcome in (visible[case.grade_id] for case in cases):
        if outcome.ending.is_fault:
            return outcome.ending, outcome.told.message
    for case in cases:
        ending = hidden.get(case.grade_id)
        if ending and ending.is_fault:
            return ending, FAULT_SENTENCES[ending]
    return None, ""


def _status(cases: Sequence[CaseResult], fault: Ending | None) -> ExerciseStatus:
    if fault:
        return "timeout" if fault is Ending.TIMEOUT else "died"
    if all(case.passed for case in cases):
        return "passed"
    return "partial" if any(case.earned for case in cases) else "failed"


def _case(case: Case, visible: Outcomes, hidden: Endings) -> CaseResult:
    shown = visible[case.grade_id]
    ending, told = shown.ending, shown.told
    if ending is Ending.PASSED and case.has_hidden:
        ending = hidden[case.grade_id]
        # The instructor's sentence alone: a hidden check's own words may hold its inputs.
        told = Told(case.hint) if case.hint else wording.own(NO_HINT)
    passed = ending is Ending.PASSED
    return CaseResult(
        name=case.name,
        points=tidy(case.points),
        earned=tidy(case.points) if passed else 0,
        visible=not case.has_hidden,
        ending=ending,
        **vars(Told() if passed else told),
    )
