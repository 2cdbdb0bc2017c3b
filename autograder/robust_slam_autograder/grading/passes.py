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


def look(
    student: str,
    assignment: Assignment,
    code: Code,
    town: int | None = seeds.SHARED_TOWN,
    *,
    sandbox: Sandbox,
    run: Run = guarded.plain,
    report: Report | None = None,
) -> Outcome:
    """Run what students can see, and explain what fails.

    Args:
        student: whose code it is.
        assignment: what it answers.
        code: what was written.
        town: the number of the student's data; None where the notebook's own counts.
        sandbox: where student code runs.
        run: what runs the test cells.
        report: called with each exercise as it ends.

    Raises:
        GraderFailure: the sandbox or the instructor's set-up cells do not work.
    """
    one = _Pass(student, assignment, code, town, sandbox, run, seeds.PUBLIC_SEED, is_visible=True)
    last = {case.exercise: case.grade_id for case in assignment.cases}
    seen: dict[str, CaseResult] = {}
    for case, ended in one.cases():
        seen[case.grade_id] = ended
        if report is not None and last[case.exercise] == case.grade_id:
            report(_exercise(case.exercise, assignment, code, seen, {}))
    return one.outcome(seen, {}, " ".join(code.notes), 0)


def finish(
    student: str,
    assignment: Assignment,
    code: Code,
    town: int | None,
    before: Outcome,
    *,
    seed: int,
    sandbox: Sandbox,
    run: Run = guarded.plain,
) -> Outcome:
    """Run all cases whole, but for those where student code hung or died already.

    Args:
        student: as for ``look``, as are those that follow.
        assignment: what it answers.
        code: what was written.
        town: the number of the student's data.
        before: from ``look``; a case that it does not have is judged by this pass alone.
        seed: of this submission, and secret; hidden inputs follow from it and the case's grade id.
        sandbox: where student code runs.
        run: what runs the test cells.

    Raises:
        GraderFailure: as ``look``.
    """
    one = _Pass(student, assignment, code, town, sandbox, run, seed)
    seen = by_grade_id(before.result, assignment)
    one.skip, one.seconds = frozenset(before.skip), before.seconds
    one.faults = {key: case.ending for key, case in seen.items() if case.ending.is_fault}
    endings = {case.grade_id: ended.ending for case, ended in one.cases()}
    return one.outcome(seen, endings, before.result.reason, before.result.seconds)


@dataclass
class _Pass:
    """One pass over a submission.

    Attributes:
        faults: cases that are known to hang or die.
        skip: cells of the student's that hung or died: they are left out.
        seconds: how much of the submission's limit is used up.
    """

    student: str
    assignment: Assignment
    code: Code
    town: int | None
    sandbox: Sandbox
    run: Run
    seed: int
    is_visible: bool = False
    faults: Endings = field(default_factory=dict)
    skip: frozenset[int] = frozenset()
    seconds: float = 0.0
    _doubtful: bool = False
    _overran: bool = False
    _start: float = field(default_factory=time.monotonic)

    def cases(self) -> Iterator[tuple[Case, CaseResult]]:
        """Run the cases in order.

        What cannot be interrupted is ended by the kernel. Then the case at which that happened
        has timed out, and the pass begins again for those that follow.
        """
        cases = self.assignment.cases
        known: dict[str, Ending] = {}
        while len(known) < len(cases):
            reached = 0
            faults = {**self.faults, **known}
            try:
                for ended, skip, seconds in self.run(functools.partial(self._run_cases, faults)):
                    case = cases[reached]
                    reached += 1
                    if case.grade_id not in known:
                        known[case.grade_id] = ended.ending
                        self._note(case, ended.ending, skip)
                        self.skip, self.seconds = skip, seconds
                        yield case, ended
            except Overrun:
                told = replace(messages.own(FAULT_SENTENCES[Ending.TIMEOUT]), returned=())
                for case in self._ended(cases[reached], known):
                    known[case.grade_id] = Ending.TIMEOUT
                    yield case, _case(case, Ending.TIMEOUT, told)

    def _run_cases(self, known: Endings) -> Iterator[Ended]:
        faults = {key: ending for key, ending in known.items() if ending.is_fault}
        used, limits = self.seconds, self.assignment.config.limits
        total = Meter().start(limits.notebook_seconds - used)
        texts = {
            case.grade_id: case.visible if self.is_visible else case.full
            for case in self.assignment.cases
        }
        calls = explain.Calls() if self.is_visible else None
        lost: dict[str, Told] = {}
        numbers = seeds.environment(self.seed, self.town)
        session = Session(self.sandbox, self.assignment, self.code.pieces, total, set(self.skip))
        with contextlib.closing(session), numbers, silence():
            cases = Cases(self.assignment, session, texts, self.seed, calls, self.code.python)
            for case, ending, error in cases.run(faults):
                told = cases.explain(case, ending, error) if self.is_visible else Told()
                if ending.is_fault:
                    told = lost.setdefault(case.exercise, told)
                yield _case(case, ending, told), frozenset(session.skip), used + total.used()

    def _note(self, case: Case, ending: Ending, skip: frozenset[int]) -> None:
        """Note where a case ended by a limit that a busy machine may be to blame for."""
        first = len(self.assignment.setup)
        own = any(self.code.pieces[number - first].own for number in skip - self.skip)
        lost = {key.rpartition("-")[0] for key in self.faults}
        self._doubtful |= own or (ending.is_fault and case.exercise not in lost)

    def _ended(self, case: Case, known: Endings) -> list[Case]:
        """Find the cases that end with one that the kernel has ended.

        Where that one was lost before, it is not the student's call that cannot be
        interrupted, and no case after it can be reached.
        """
        self._overran = True
        self.seconds += self.assignment.config.limits.cell_seconds
        if case.grade_id not in known and case.grade_id not in self.faults:
            return [case]
        return [one for one in self.assignment.cases if one.grade_id not in known]

    def outcome(self, seen: Shown, hidden: Endings, reason: str, seconds: float) -> Outcome:
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
        return Outcome(result, doubtful, round(self.seconds, 3), tuple(sorted(self.skip)))


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
