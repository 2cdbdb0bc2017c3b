"""One pass over an assignment's cases: each test cell runs here, beside the student's functions.

Tests run in the trusted process. The student's functions are proxies that call across the
pipe. A case earns its points only when this side reached the end of its cell.
"""

import contextlib
import os
import signal
import types
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor import guarded, memory
from robust_slam_autograder.executor.seeds import case_generator
from robust_slam_autograder.executor.session import (
    Session,
    SessionFault,
    StudentError,
    shows_answers,
)
from robust_slam_autograder.grading import explain, likely_causes, messages, pythons, returned
from robust_slam_autograder.grading.explain import Returned
from robust_slam_autograder.grading.messages import FAULT_SENTENCES, Told
from robust_slam_autograder.grading.results import Ending
from robust_slam_autograder.protocol.notebook import Notebook
from robust_slam_autograder.reading.assignment import Assignment, Case, Piece
from robust_slam_autograder.reading.source import compiled, names_read, plain_python
from robust_slam_autograder.reading.submission import OWN

ALARM_GRACE = 0.5
"""The pipe's own deadline comes first; the alarm is for tests that compute on this side."""
KERNEL_GRACE = 1.0
"""Then the kernel ends what no alarm interrupts."""
Endings = Mapping[str, Ending]
"""By grade id."""
_Event = tuple[Case, Ending, Exception | None]
"""A case, how it ended, and what it raised, which may hold a student's words."""


@dataclass(frozen=True)
class Cases:
    """One pass over an assignment's cases."""

    assignment: Assignment
    session: Session
    sources: Mapping[str, str]
    seed: int
    calls: explain.Calls | None = None
    """Calls of the student's functions, recorded in the visible pass alone."""
    python: tuple[int, int] | None = None
    """The student's own, where the notebook says it."""
    stopped: dict[str, str] = field(default_factory=dict)
    """By exercise that was not run, a function that its code depends on, and that ran too long."""
    _reached: dict[str, set[str]] = field(default_factory=dict)
    """By a name that students define, in the visible pass, the others that it depends on."""
    _failed: dict[str, None] = field(default_factory=dict)
    """The exercises of which a case did not pass, in their order."""

    def run(self, faults: Endings) -> Iterator[_Event]:
        """Run the cases in order; after a fault the rest of its exercise is lost.

        So is, in the visible pass, a later exercise whose code calls a function that ran longer
        than it may: it would do so there again.

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
                if ending is Ending.TIMEOUT and self.calls is not None:
                    lost |= self._stop_callers(case, lost)
            if ending is not Ending.PASSED:
                self._failed[case.exercise] = None
            yield case, ending, error

    def _stop_callers(self, hung: Case, lost: Endings) -> Endings:
        """Return the exercises that are stopped, because their code calls what has hung."""
        for exercise in self.assignment.exercises:
            called = self._called(exercise, hung.exercise)
            if called and exercise not in lost:
                self.stopped[exercise] = min(called)
        return dict.fromkeys(self.stopped, Ending.TIMEOUT)

    def _called(self, exercise: str, other: str) -> set[str]:
        """Return the functions of another exercise that one depends on."""
        mine, theirs = (set(self.assignment.names_of(one)) for one in (exercise, other))
        found = theirs & {called for name in mine for called in self._reached.get(name, ())}
        return found if mine.isdisjoint(theirs) else set()

    def explain(self, case: Case, ending: Ending, error: Exception | None) -> Told:
        """Say to the student how a case ended in the visible pass.

        What is explained came from student code, so the explanation itself may fail.
        """
        seen: tuple[str, ...] | None = None if case.has_town or ending is Ending.PASSED else ()
        try:
            with self._bounded():
                if seen is not None and ending is Ending.FAILED and self.calls is not None:
                    raised = isinstance(error, StudentError)
                    seen = returned.digests(self.calls.made, raised=raised)
                told = self._explained(case, ending, error)
            guilty = [one for one in self._failed if self._called(case.exercise, one)]
            told = told.beside(*(messages.CALLS.format(case.exercise, one) for one in guilty[:1]))
        except (Exception, SessionFault):
            told = messages.own(FAULT_SENTENCES.get(ending, messages.UNEXPLAINED))
        return replace(told, returned=seen)

    @contextlib.contextmanager
    def _bounded(self) -> Iterator[None]:
        """Bound the time and the memory of what runs on this side with what student code sent."""
        with _alarm(self.session), memory.for_tests():
            yield

    def _explained(self, case: Case, ending: Ending, error: Exception | None) -> Told:
        errors, owner = self.session.errors, self.assignment.owner
        cell_error = errors.get(owner(case.exercise))
        if ending.is_fault and case.exercise in self.stopped:
            return messages.own(messages.STOPPED.format(self.stopped[case.exercise]))
        if error is None or isinstance(cell_error, SessionFault):
            return messages.own(FAULT_SENTENCES[ending]) if ending.is_fault else Told()
        if isinstance(error, NameError) and self.session.lacks_own_cells:
            return messages.left_out(error)
        if isinstance(error, NameError) and not isinstance(error, StudentError):
            cell_error = errors.get(owner(error.name or ""), cell_error)
            told = messages.undefined(error, cell_error)
            return told.further(self._cause(case, cell_error))
        told = messages.message(error, self.sources[case.grade_id], case, self._owners())
        if cause := self._cause(case, error):
            return told.further(cause)
        returned = self._returned(case, error)
        return told.further(returned.text, returned.compared)

    def _returned(self, case: Case, error: Exception) -> Returned:
        """Say what a function returned and what was expected; it may be empty."""
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
        """Find a line that says what most often causes a student's exception; it may be empty."""
        if not isinstance(error, StudentError) or isinstance(error, NotImplementedError):
            return ""
        owner = self.assignment.owner(case.exercise)
        cells = {piece.label: piece.source for piece in self.session.pieces}
        cell = cells.get(messages.elsewhere(error, self._owners()) or owner, "")
        told = likely_causes.of(error, cell, self.assignment.config.causes)
        own = self.session.errors.get(OWN)
        if isinstance(error, NameError) and isinstance(own, StudentError):
            error, told = own, told + messages.lost(own)
        return told + pythons.remark(error, self.python, self.session.pieces)

    def _owners(self) -> dict[str, str]:
        """Return the cell that each function belongs to."""
        return {name: one.grade_id for one in self.assignment.solutions for name in one.names}

    def _compiled(self) -> dict[str, types.CodeType]:
        found = {}
        for case in self.assignment.cases:
            try:
                found[case.grade_id] = compiled(self.sources[case.grade_id], messages.label(case))
            except (SyntaxError, ValueError) as error:
                what = f"The test cell {case.grade_id} is no Python: {error}."
                raise GraderFailure(what) from error
        return found

    def _namespace(self, used: Collection[str]) -> dict[str, Any]:
        """Gather what test cells see: names of the set-up that are used, then the student's."""
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
        if self.calls is not None:
            self._reached.update(self.session.reached())
            bindings = self.calls.watched(bindings)
        notebook.names.update(bindings)
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
            self.calls.begin(messages.label(case), namespace)
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
            return known or self._ending(case), None if known else error
        if known or session.fault is None:
            return known or Ending.PASSED, None
        # A test may have swallowed the fault with a bare except.
        return Ending(session.fault.kind), None

    def _ending(self, case: Case) -> Ending:
        """Say how a case ended whose test raised."""
        cell_error = self.session.errors.get(self.assignment.owner(case.exercise))
        if isinstance(cell_error, SessionFault):
            return Ending(cell_error.kind)
        return Ending.FAILED


@contextlib.contextmanager
def silence() -> Iterator[None]:
    """Send what a test prints nowhere: it may hold hidden inputs."""
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
        with guarded.at_most(session.time_left() + KERNEL_GRACE):
            yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
