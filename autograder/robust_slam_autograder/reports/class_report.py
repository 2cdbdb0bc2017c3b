"""What an instructor needs to know of an assignment: plain data, from the results alone.

Results hold no hidden code and no hidden input. Without names, a report holds neither a
student's name nor text that may hold one: reasons, and students' own words.
"""

import itertools
import statistics
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar

from robust_slam_autograder.grading.entered_by_hand import Entered, with_marks
from robust_slam_autograder.grading.results import CaseResult, ExerciseResult, Result, Status, tidy
from robust_slam_autograder.grading.verdicts import outcome
from robust_slam_autograder.lms.marking import Question
from robust_slam_autograder.markup import one_line, visible
from robust_slam_autograder.reports import versions
from robust_slam_autograder.reports.hints import Hint, Reader, collect
from robust_slam_autograder.reports.misunderstood import (
    Code,
    Misconception,
    Unlabelled,
    discrimination,
    misconceptions,
    unlabelled,
)
from robust_slam_autograder.reports.similar import Alike, Two
from robust_slam_autograder.reports.versions import Version

MOST_BINS = 12
SLOWEST = 5
MANY = 0.4
"""From this share of the submissions on, the class did not understand something."""
FEWEST = 2
"""From this many students on, what all of them have in common says something of a test."""

NEARLY = 0.95
"""From this share on, or this share of failures, a case tells little about most."""
EASY = "everybody passes: too easy?"
NEARLY_EASY = "nearly everybody passes"
NEARLY_BROKEN = "nearly no one passes"
WEAK = "who passes it does no better elsewhere"
BROKEN = "no one passes: is the test right?"


@dataclass(frozen=True)
class Bin:
    """Marks from ``low`` to ``high``, in points."""

    low: float
    high: float
    students: int
    label: str


@dataclass(frozen=True)
class Marks:
    """How the marks of those who were graded are spread, in points."""

    max_score: float
    lowest: float
    lower_quartile: float
    median: float
    upper_quartile: float
    highest: float
    bins: tuple[Bin, ...]
    unit: float
    """The step between marks: 1 where all are whole, else 0."""

    @property
    def students(self) -> int:
        """Return how many marks there are."""
        return sum(found.students for found in self.bins)

    @property
    def has_quartiles(self) -> bool:
        """Tell whether there are enough marks to speak of half of a class."""
        return self.students >= 4

    @property
    def median_place(self) -> float:
        """Return where the median is, in bins from the left: alone in its bin in the middle."""
        n = max(n for n, found in enumerate(self.bins) if found.low <= self.median or n == 0)
        room = self.bins[n].high - self.bins[n].low + self.unit
        return n + ((self.median - self.bins[n].low + self.unit / 2) / room if room else 0.5)


@dataclass(frozen=True)
class CaseStatistics:
    """How one case went."""

    name: str
    hidden: bool
    points: float
    passed: int
    students: int
    discrimination: float | None = None
    """Correlation of passing it with all other points; None where too few students say."""

    @property
    def share(self) -> float:
        """Return the share of the students who pass it."""
        return self.passed / self.students

    @property
    def remark(self) -> str:
        """Return what should make an instructor look at the test; empty for most."""
        if self.students < FEWEST:
            return ""
        if self.passed in (0, self.students):
            return EASY if self.passed else BROKEN
        if max(self.share, 1 - self.share) >= NEARLY:
            return NEARLY_EASY if self.share >= NEARLY else NEARLY_BROKEN
        is_weak = self.discrimination is not None and self.discrimination <= 0
        return WEAK if is_weak else ""


@dataclass(frozen=True)
class ExerciseStatistics:
    """How one exercise went."""

    name: str
    share: float | None
    """Of its points, over all students; None where it has none."""
    students: int
    whole: int
    partly: int
    none: int
    missing: int
    """The four numbers of students: all of the points, some, none, and nothing written at all."""
    timeouts: int
    deaths: int
    cases: tuple[CaseStatistics, ...]
    hints: tuple[Hint, ...]

    @property
    def limits(self) -> int:
        """Return how many students ran into a limit here."""
        return self.timeouts + self.deaths

    @property
    def remarks(self) -> Counter[str]:
        """Return how many of its cases have which remark."""
        return Counter(case.remark for case in self.cases if case.remark)


@dataclass(frozen=True)
class Named:
    """A submission that somebody should look at, or that took long."""

    student: str
    link: str
    """Address of the feedback page; empty without one."""
    reason: str
    seconds: float


@dataclass(frozen=True)
class Time:
    """How long grading took, in seconds."""

    median: float
    longest: float
    total: float
    slowest: tuple[Named, ...]
    """Empty without names."""


@dataclass(frozen=True)
class Asked:
    """A student's question about a mark."""

    student: Named
    """With the question, in place of a reason."""
    answer: str
    marker: str
    """Who marks this student; empty where that is not said."""


@dataclass(frozen=True)
class Kind:
    """Submissions that somebody should look at for the same reason."""

    name: str
    students: int
    list: tuple[Named, ...]
    """These submissions; empty without names."""


@dataclass(frozen=True)
class OtherVersion:
    """Submissions that were graded by other tests than most."""

    students: int
    differences: tuple[str, ...]


@dataclass(frozen=True)
class Report:
    """All that a page shows."""

    assignment: str
    title: str
    page: str
    """Address of its page from the index; empty without one."""
    names: bool
    handed_in: int
    graded: int
    refused: int
    failed: int
    marks: Marks | None
    """None where nothing was graded."""
    exercises: tuple[ExerciseStatistics, ...]
    """Hardest first."""
    misunderstood: tuple[tuple[str, Hint], ...] | None
    """What many students were told by an exercise's check or its hint, most students first.

    None where too few submissions speak for a class.
    """
    unwritten: tuple[tuple[str, int], ...]
    missed: tuple[tuple[str, int], ...]
    """Exercises that many students did not write, or wrote without any points, with how many;
    none where too few submissions speak for a class."""
    misconceptions: tuple[tuple[Misconception, tuple[Named, ...]], ...]
    """What wrong answers look like, and whose they are; without names no one is there."""
    unlabelled: tuple[tuple[Unlabelled, tuple[Named, ...]], ...]
    """Wrong answers that return the same, and that have no label."""
    time: Time | None
    attention: tuple[Kind, ...]
    """Submissions that somebody should look at, the most pressing first."""
    others: tuple[OtherVersion, ...]
    """What was graded by other tests than most, and is in ``attention`` alone."""
    by_hand: tuple[tuple[Named, str, str], ...]
    """What people entered: whose it is with the reason, the exercise, and the points."""
    markers: tuple[tuple[str, tuple[Named, ...]], ...]
    """Who marks, and whose work, with its points; empty without names."""
    questions: tuple[Asked, ...]
    """Open ones first."""
    alike: tuple[tuple[Two, tuple[Named, Named]], ...] | None
    """Answers that are nearly one text, and whose; None where that was not looked for."""
    common: tuple[tuple[str, int], ...]
    """Exercises that many wrote in one way, with how many."""

    @property
    def open_questions(self) -> int:
        """Return how many questions have no answer yet."""
        return sum(not one.answer for one in self.questions)


@dataclass(frozen=True)
class Source:
    """Where a report comes from.

    Attributes:
        assignment: its name.
        title: its title; empty where it has none.
        results: one per student, as the tests found it.
        by_hand: what people entered in the gradebook; its points count here too.
        names: whether students may be named.
        page: address of its page from the index; empty without one.
        links: by student, the address of the feedback page from there, where there is one.
        students: everybody whose name must not be shown without names.
        markers: by student who marks, where several do.
        questions: what students ask about their marks here.
        alike: answers that are nearly one text; None where that was not looked for.
        code: a student's text for an exercise, where it may be shown.
    """

    assignment: str
    title: str
    results: Sequence[Result]
    names: bool = True
    page: str = ""
    links: Mapping[str, str] = field(default_factory=dict)
    students: frozenset[str] = frozenset()
    by_hand: Entered = field(default_factory=Entered)
    markers: Mapping[str, str] = field(default_factory=dict)
    questions: Sequence[Question] = ()
    alike: Alike | None = None
    code: Code = lambda student, exercise: ""

    @property
    def marks(self) -> list[Result]:
        """Return the results with the points that count."""
        return [with_marks(one, self.by_hand.of(one.student)) for one in self.results]

    def named(self, result: Result, reason: str = "") -> Named:
        """Return a submission with its student's name."""
        link = self.links.get(result.student, "")
        return Named(one_line(result.student), link, reason, result.seconds)


def report(source: Source) -> Report:
    """Make the report of an assignment."""
    found = versions.of(source.marks)
    shown = found[0].results if found else ()
    exercises = _exercises(shown, source)
    marks = _marks(shown) if shown else None
    spoken_for = exercises if marks and marks.has_quartiles else ()
    status = Counter(result.status for result in source.results)
    return Report(
        assignment=visible(source.assignment),
        title=source.title or visible(source.assignment),
        page=source.page,
        names=source.names,
        handed_in=len(source.results),
        graded=status["graded"],
        refused=status["refused"],
        failed=status["failed"],
        marks=marks,
        exercises=exercises,
        misunderstood=_misunderstood(exercises) if spoken_for else None,
        unwritten=_many(spoken_for, "missing"),
        missed=_many(spoken_for, "none"),
        misconceptions=tuple(_with_names(source, misconceptions(shown))),
        unlabelled=tuple(_with_names(source, unlabelled(shown, source.code))),
        time=_time(shown, source) if shown else None,
        attention=tuple(_attention(source, found)),
        others=tuple(OtherVersion(len(one.results), one.differences) for one in found[1:]),
        by_hand=tuple(_by_hand(source)),
        markers=tuple(_markers(source)) if source.names else (),
        questions=tuple(_questions(source)),
        alike=None if source.alike is None else tuple(_alike(source, source.alike)),
        common=source.alike.common if source.alike else (),
    )


def _alike(source: Source, alike: Alike) -> Iterator[tuple[Two, tuple[Named, Named]]]:
    results = {result.student: result for result in source.marks}
    for two in alike.two:
        first, second = (results[student] for student in two.students)
        yield two, (source.named(first, _points(first)), source.named(second, _points(second)))


T = TypeVar("T")


def _with_names(
    source: Source, found: Sequence[tuple[T, Sequence[Result]]]
) -> Iterator[tuple[T, tuple[Named, ...]]]:
    yield from ((one, tuple(map(source.named, who)) if source.names else ()) for one, who in found)


def _markers(source: Source) -> Iterator[tuple[str, tuple[Named, ...]]]:
    """Yield who marks, with whose work: of this assignment alone."""
    mine: dict[str, list[Named]] = {}
    for result in sorted(source.marks, key=lambda one: one.student):
        marker = source.markers.get(result.student)
        if marker is not None:
            said = _points(result) if result.status == "graded" else result.status
            mine.setdefault(marker, []).append(source.named(result, said))
    yield from ((one_line(marker), tuple(mine[marker])) for marker in sorted(mine))


def _questions(source: Source) -> Iterator[Asked]:
    results = {result.student: result for result in source.results}
    for one in sorted(source.questions, key=lambda one: bool(one.answer)):
        marker = one_line(source.markers.get(one.student, ""))
        asker = source.named(results[one.student], visible(one.text))
        yield Asked(asker, visible(one.answer), marker)


def _by_hand(source: Source) -> Iterator[tuple[Named, str, str]]:
    """Yield what people entered: whose it is with the reason, the exercise, and the points."""
    for result in sorted(source.results, key=lambda one: one.student):
        for entry in source.by_hand.of(result.student):
            said = f"{entry.points} of {entry.max_score}" if entry.max_score else ""
            points = "waits" if entry.waits else said or f"{entry.points:+}"
            yield source.named(result, visible(entry.words)), visible(entry.name), points


def _marks(results: Sequence[Result]) -> Marks:
    scores, most = sorted(result.score for result in results), results[0].max_score
    # Of one mark there are no quartiles but itself.
    quarters = statistics.quantiles(scores * (2 if len(scores) == 1 else 1), method="inclusive")
    whole = all(float(score).is_integer() for score in [*scores, most])
    return Marks(
        max_score=tidy(most),
        lowest=tidy(scores[0]),
        lower_quartile=tidy(quarters[0]),
        median=tidy(statistics.median(scores)),
        upper_quartile=tidy(quarters[2]),
        highest=tidy(scores[-1]),
        bins=_bins(scores, most, whole=whole),
        unit=1 if whole else 0,
    )


def _bins(scores: Sequence[float], most: float, *, whole: bool) -> tuple[Bin, ...]:
    """Count marks in bins of 1, 2, 5, 10, … points; full marks end the last one."""
    steps = (digit * 10**power for power in itertools.count() for digit in (1, 2, 5))
    step = next(step for step in steps if most <= MOST_BINS * step)
    number = int(most // step) + 1
    counts = Counter(max(0, min(int(score // step), number - 1)) for score in scores)
    bins = []
    for n in range(number):
        low, after = n * step, (n + 1) * step
        high = tidy(min(after - whole, most))
        to = "–" if whole or n == number - 1 else "–<"
        label = f"{low}{to}{high}" if high > low else f"{low}"
        bins.append(Bin(low, high, counts[n], label))
    return tuple(bins)


def _exercises(results: Sequence[Result], source: Source) -> tuple[ExerciseStatistics, ...]:
    reader = Reader(source.names, source.students)
    whole = [result.score for result in results]
    exercises = [
        _exercise([result.exercises[n] for result in results], reader, whole)
        for n in range(len(results[0].exercises) if results else 0)
    ]
    return tuple(sorted(exercises, key=lambda e: 2.0 if e.share is None else e.share))


def _exercise(
    mine: Sequence[ExerciseResult], reader: Reader, whole: Sequence[float]
) -> ExerciseStatistics:
    most = sum(exercise.max_score for exercise in mine)
    status = Counter(map(outcome, mine))
    missing = status["missing"] + status["not written"]
    partly = sum(e.score > 0 for e in mine if e.status not in ("passed", "missing"))
    return ExerciseStatistics(
        name=visible(mine[0].name),
        share=sum(exercise.score for exercise in mine) / most if most else None,
        students=len(mine),
        whole=status["passed"],
        partly=partly,
        none=len(mine) - status["passed"] - partly - missing,
        missing=missing,
        timeouts=status["timeout"],
        deaths=status["died"],
        cases=tuple(
            _case(outcomes, discrimination(mine, which, whole))
            for which, outcomes in enumerate(zip(*(e.cases for e in mine), strict=True))
        ),
        hints=collect(mine, reader),
    )


def _many(exercises: Sequence[ExerciseStatistics], what: str) -> tuple[tuple[str, int], ...]:
    """Return by exercise of how many students something is true, where they are many."""
    counts = [(each.name, int(getattr(each, what)), each.students) for each in exercises]
    found = [(name, number) for name, number, students in counts if number >= MANY * students]
    return tuple(sorted(found, key=lambda one: -one[1]))


def _case(outcomes: Sequence[CaseResult], discriminates: float | None) -> CaseStatistics:
    first = outcomes[0]
    return CaseStatistics(
        name=visible(first.name),
        hidden=not first.visible,
        points=first.points,
        passed=sum(outcome.passed for outcome in outcomes),
        students=len(outcomes),
        discrimination=discriminates,
    )


def _misunderstood(exercises: Sequence[ExerciseStatistics]) -> tuple[tuple[str, Hint], ...]:
    found = [
        (exercise.name, hint)
        for exercise in exercises
        for hint in exercise.hints
        if hint.is_of_a_check and hint.students >= MANY * exercise.students
    ]
    return tuple(sorted(found, key=lambda one: -one[1].students))


def _time(results: Sequence[Result], source: Source) -> Time:
    seconds = [result.seconds for result in results]
    slowest = sorted(results, key=lambda r: (-r.seconds, r.student))[:SLOWEST]
    return Time(
        median=statistics.median(seconds),
        longest=max(seconds),
        total=sum(seconds),
        slowest=tuple(map(source.named, slowest if source.names else ())),
    )


Reason = Callable[[Result], str]
"""What is to be said of a submission; empty where there is nothing to look at."""


def _without(status: Status) -> Reason:
    """Say why there is no mark."""
    return lambda r: (visible(r.reason) or "no reason is known") if r.status == status else ""


def _stopped(result: Result) -> str:
    said = {"timeout": "ran too long", "died": "ended its process"}
    told = (f"{visible(e.name)} {said[e.status]}" for e in result.exercises if e.status in said)
    return ", ".join(told)


def _nothing(result: Result) -> str:
    lost = result.status == "graded" and result.max_score > 0 and not result.score
    return _points(result) if lost else ""


def _points(result: Result) -> str:
    return f"{tidy(result.score)} of {tidy(result.max_score)} points"


def _attention(source: Source, found: Sequence[Version]) -> Iterator[Kind]:
    """Put each submission under the most pressing reason that it has."""
    others = {result.student for version in found[1:] for result in version.results}
    reasons: Mapping[str, Reason] = {
        "The grader failed": _without("failed"),
        "Refused": _without("refused"),
        "Graded by other tests than most": lambda r: _points(r) if r.student in others else "",
        "Ran into a limit": _stopped,
        "No points": _nothing,
    }
    left = source.marks
    for name, reason in reasons.items():
        mine = [result for result in left if reason(result)]
        left = [result for result in left if not reason(result)]
        shown = sorted(mine, key=lambda result: result.student) if source.names else []
        if mine:
            yield Kind(name, len(mine), tuple(source.named(one, reason(one)) for one in shown))
