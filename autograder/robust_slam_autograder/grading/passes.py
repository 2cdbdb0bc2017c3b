"""Grades one submission: visible tests with their messages, then hidden ones with hints.

The hidden pass yields one ``Ending`` a case and no text. So nothing that student code
says there can reach the result: its messages are the instructor's hints and constants.
A batch runs the visible passes of all its submissions before the first hidden one.
"""

import contextlib
import functools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from robust_slam_autograder.executor import guarded, seeds
from robust_slam_autograder.executor.budget import Meter
from robust_slam_autograder.executor.guarded import Overrun
from robust_slam_autograder.executor.session import Session
from robust_slam_autograder.grading import explain, messages
from robust_slam_autograder.grading.cases import Cases, Endings, silence
from robust_slam_autograder.grading.messages import FAULT_SENTENCES, NO_HINT, Told
from robust_slam_autograder.grading.results import (
    CaseResult,
    Ending,
    ExerciseResult,
    ExerciseStatus,
    Result,
    by_grade_id,
    tidy,
)
from robust_slam_autograder.grading.submissions import Outcome
from robust_slam_autograder.reading.assignment import Assignment, Case
from robust_slam_autograder.reading.submission import Code
from robust_slam_autograder.sandbox import Sandbox

Report = Callable[[ExerciseResult], None]
"""Called with each exercise as it ends."""
Shown = Mapping[str, CaseResult]
"""By grade id how a case went in the visible pass."""


Ended = tuple[CaseResult, frozenset[int], float]
"""How a case ended, which cells of the student's are left out by then, and the seconds used."""
Run = guarded.Run[Ended]
"""What runs the test cells."""


@dataclass
class Pass:
    """A submission, and what runs it: for one pass, in which it is used up."""

    student: str
    assignment: Assignment
    code: Code
    sandbox: Sandbox
    """Where student code runs."""
    town: int | None = seeds.SHARED_TOWN
    """The number of the student's data; None where the notebook's own counts."""
    run: Run = guarded.plain
    """What runs the test cells."""
    _seed: int = seeds.PUBLIC_SEED
    _is_visible: bool = False
    _faults: Endings = field(default_factory=dict)
    """Cases that are known to hang or die."""
    _skip: frozenset[int] = frozenset()
    """Cells of the student's that hung or died: they are left out."""
    _seconds: float = 0.0
    """How much of the submission's limit is used up."""
    _doubtful: bool = False
    _overran: bool = False
    _start: float = field(default_factory=time.monotonic)

    def look(self, report: Report | None = None) -> Outcome:
        """Run what students can see, and explain what fails; report each exercise as it ends.

        Raises:
            GraderFailure: the sandbox or the instructor's set-up cells do not work.
        """
        self._is_visible = True
        last = {case.exercise: case.grade_id for case in self.assignment.cases}
        seen: dict[str, CaseResult] = {}
        for case, ended in self._cases():
            seen[case.grade_id] = ended
            if report is not None and last[case.exercise] == case.grade_id:
                report(_exercise(case.exercise, self.assignment, self.code, seen, {}))
        return self._outcome(seen, {}, " ".join(self.code.notes), 0)

    def finish(self, before: Outcome, seed: int) -> Outcome:
        """Run all cases whole, but for those where student code hung or died already.

        Args:
            before: from ``look``; a case that it does not have is judged by this pass alone.
            seed: of this submission, and secret; hidden inputs follow from it and the grade id.

        Raises:
            GraderFailure: as ``look``.
        """
        self._seed = seed
        seen = by_grade_id(before.result, self.assignment)
        self._skip, self._seconds = frozenset(before.skip), before.seconds
        self._faults = {key: case.ending for key, case in seen.items() if case.ending.is_fault}
        endings = {case.grade_id: ended.ending for case, ended in self._cases()}
        return self._outcome(seen, endings, before.result.reason, before.result.seconds)

    def _cases(self) -> Iterator[tuple[Case, CaseResult]]:
        """Run the cases in order.

        What cannot be interrupted is ended by the kernel. Then the case at which that happened
        has timed out, and the pass begins again for those that follow.
        """
        cases = self.assignment.cases
        known: dict[str, Ending] = {}
        while len(known) < len(cases):
            reached = 0
            faults = {**self._faults, **known}
            try:
                for ended, skip, seconds in self.run(functools.partial(self._run_cases, faults)):
                    case = cases[reached]
                    reached += 1
                    if case.grade_id not in known:
                        known[case.grade_id] = ended.ending
                        self._note(case, ended.ending, skip)
                        self._skip, self._seconds = skip, seconds
                        yield case, ended
            except Overrun:
                told = replace(messages.own(FAULT_SENTENCES[Ending.TIMEOUT]), returned=())
                for case in self._ended(cases[reached], known):
                    known[case.grade_id] = Ending.TIMEOUT
                    yield case, _case(case, Ending.TIMEOUT, told)

    def _run_cases(self, known: Endings) -> Iterator[Ended]:
        faults = {key: ending for key, ending in known.items() if ending.is_fault}
        used, limits = self._seconds, self.assignment.config.limits
        total = Meter().start(limits.notebook_seconds - used)
        texts = {
            case.grade_id: case.visible if self._is_visible else case.full
            for case in self.assignment.cases
        }
        calls = explain.Calls() if self._is_visible else None
        lost: dict[str, Told] = {}
        numbers = seeds.environment(self._seed, self.town)
        session = Session(self.sandbox, self.assignment, self.code.pieces, total, set(self._skip))
        with contextlib.closing(session), numbers, silence():
            cases = Cases(self.assignment, session, texts, self._seed, calls, self.code.python)
            for case, ending, error in cases.run(faults):
                told = cases.explain(case, ending, error) if self._is_visible else Told()
                if ending.is_fault:
                    told = lost.setdefault(case.exercise, told)
                yield _case(case, ending, told), frozenset(session.skip), used + total.used()

    def _note(self, case: Case, ending: Ending, skip: frozenset[int]) -> None:
        """Note where a case ended by a limit that a busy machine may be to blame for."""
        first = len(self.assignment.setup)
        own = any(self.code.pieces[number - first].own for number in skip - self._skip)
        lost = {key.rpartition("-")[0] for key in self._faults}
        self._doubtful |= own or (ending.is_fault and case.exercise not in lost)

    def _ended(self, case: Case, known: Endings) -> list[Case]:
        """Find the cases that end with one that the kernel has ended.

        Where that one was lost before, it is not the student's call that cannot be
        interrupted, and no case after it can be reached.
        """
        self._overran = True
        self._seconds += self.assignment.config.limits.cell_seconds
        if case.grade_id not in known and case.grade_id not in self._faults:
            return [case]
        return [one for one in self.assignment.cases if one.grade_id not in known]

    def _outcome(self, seen: Shown, hidden: Endings, reason: str, seconds: float) -> Outcome:
        """Put the result together; ``seconds`` are those of the passes before."""
        names = self.assignment.exercises
        exercises = [_exercise(one, self.assignment, self.code, seen, hidden) for one in names]
        result = Result(
            student=self.student,
            assignment=self.assignment.name,
            score=tidy(sum(exercise.score for exercise in exercises)),
            max_score=tidy(self.assignment.max_score),
            status="graded",
            reason=reason,
            sandbox=self.sandbox.name,
            seconds=round(seconds + time.monotonic() - self._start, 3),
            exercises=tuple(exercises),
        )
        doubtful = self._doubtful and not self._overran
        return Outcome(result, doubtful, round(self._seconds, 3), tuple(sorted(self._skip)))


def _exercise(
    name: str, assignment: Assignment, code: Code, seen: Shown, hidden: Endings
) -> ExerciseResult:
    cases = [case for case in assignment.cases if case.exercise == name]
    results = tuple(_finished(case, seen.get(case.grade_id), hidden) for case in cases)
    score = sum(case.earned for case in results)
    owner = assignment.owner(name)
    fault, message = _fault(cases, seen, hidden)
    message = message or next((case.message for case in results if case.message), "")
    missing = not score and owner in code.missing
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


def _fault(cases: Sequence[Case], seen: Shown, hidden: Endings) -> tuple[Ending | None, str]:
    """Find the first fault of an exercise, and what to say of it."""
    for shown in (seen[case.grade_id] for case in cases if case.grade_id in seen):
        if shown.ending.is_fault:
            return shown.ending, shown.message
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


def _finished(case: Case, shown: CaseResult | None, hidden: Endings) -> CaseResult:
    """Say how a case ended in the end: it keeps the text of the visible pass, if it has one."""
    if shown is not None and (not hidden or not shown.passed or not case.has_hidden):
        return shown
    # The instructor's sentence alone: a hidden check's own words may hold its inputs.
    told = Told(case.hint) if case.hint else messages.own(NO_HINT)
    return _case(case, hidden[case.grade_id], told)


def _case(case: Case, ending: Ending, told: Told) -> CaseResult:
    passed = ending is Ending.PASSED
    return CaseResult(
        name=case.name,
        points=tidy(case.points),
        earned=tidy(case.points) if passed else 0,
        visible=not case.has_hidden,
        ending=ending,
        **vars(Told() if passed else told),
    )
