"""What a student reads about a submission: a page's content, from the result alone.

Results hold no hidden code and no hidden input, and a page takes over neither
seconds nor the sandbox. All text that somebody chose is made fit to be read here.
"""

import math
import re
import unicodedata
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from urllib.parse import quote

from robust_slam_autograder.grading.entered_by_hand import Entries, Entry, with_marks
from robust_slam_autograder.grading.messages import NOT_WRITTEN
from robust_slam_autograder.grading.results import (
    CaseResult,
    Compared,
    ExerciseResult,
    Result,
)
from robust_slam_autograder.grading.verdicts import ADVICE, SIGNS, meaning, outcome, sign, verdict
from robust_slam_autograder.markup import visible
from robust_slam_autograder.reading.assignment import Config
from robust_slam_autograder.reports import clicks, documents

NOT_RUN = "✗ not run"
CURVE = 90.0
"""Height of a picture of numbers, in pixels."""


@dataclass(frozen=True)
class Reading:
    """Where to read again."""

    text: str
    address: str
    """Empty where the book's address is not known."""


@dataclass(frozen=True)
class Curves:
    """Two rows of numbers, as pairs of per cent from the left and pixels from the top."""

    yours: tuple[tuple[float, float], ...]
    expected: tuple[tuple[float, float], ...]
    lowest: str
    highest: str


@dataclass(frozen=True)
class ShownCase:
    """One case on the page."""

    name: str
    outcome: str
    passed: bool
    points: str
    other_inputs: bool
    """Whether it was checked with inputs that the student does not have."""
    message: str
    as_above: bool
    """Whether the message is that of a case before, and is not repeated."""
    sentence: str
    """The message without the values."""
    values: Compared | None
    """Of a visible check; the message has them too."""
    curves: Curves | None
    """Both values as a picture; None where a picture says no more."""


@dataclass(frozen=True)
class ShownMark:
    """What a person gave or took, or has still to mark."""

    name: str
    anchor: str
    """Of the exercise that it is about; empty where no exercise is shown."""
    points: str
    words: str


@dataclass(frozen=True)
class ShownExercise:
    """One exercise on the page."""

    name: str
    anchor: str
    outcome: str
    kind: str
    """Its style: "passed", "partial" or "lost"."""
    passed: bool
    points: str
    meaning: str
    advice: str
    message: str
    """What no case says already."""
    misconception: str
    """What it looks like, as a sentence; empty where that is not known."""
    hints: tuple[tuple[str, str], ...]
    """Each with what its click says; it tells more than the one before."""
    reading: Reading | None
    cases: tuple[ShownCase, ...]


@dataclass(frozen=True)
class Page:
    """All that a page shows."""

    student: str
    assignment: str
    title: str
    score: float
    max_score: float
    verdict: str
    note: str
    note_kind: str
    """"Reason" or "Note"."""
    start: ShownExercise | None
    """The first exercise that lost points."""
    next: str
    exercises: tuple[ShownExercise, ...]
    by_hand: tuple[ShownMark, ...]
    """What a person said of it; it is in the points already."""

    @property
    def share(self) -> float:
        """Return the share of the points; more than all of them, by hand, is all."""
        return min(max(self.score / self.max_score, 0), 1) if self.max_score else 0


def html(page: Page, notice: str = "") -> str:
    """Return the page as one self-contained file, with a notice at its top where there is one."""
    return documents.html("feedback", page=page, notice=notice)


def markdown(page: Page) -> str:
    """Return the page as Markdown, as GitHub shows it: others' text is in code spans alone."""
    return documents.template("feedback.md").render(page=page)


def reading(config: Config, exercise: str, site: str) -> Reading | None:
    """Return where an exercise's matter stands; None for an assignment without a chapter."""
    if not config.chapter:
        return None
    heading = config.sections.get(exercise, "")
    text = config.place(exercise)
    if not site:
        return Reading(text, "")
    address = f"{site.rstrip('/')}/chapters/{quote(config.chapter)}.html"
    return Reading(text, address + (f"#{anchor(heading)}" if heading else ""))


def anchor(heading: str) -> str:
    """Return the id that the built book gives a heading's section (the rule of docutils)."""
    plain = unicodedata.normalize("NFKD", heading.lower()).encode("ascii", "ignore").decode()
    return re.sub(r"^[-0-9]+|-+$", "", re.sub(r"[^a-z0-9]+", "-", plain))


def page(result: Result, config: Config, site: str, entries: Entries = ()) -> Page:
    """Make the content of a submission's page.

    Args:
        result: what the tests found.
        config: the assignment's.
        site: the built book's address, absolute or relative to the page; empty if unknown.
        entries: what people entered in the gradebook; its points count on the page too.
    """
    result = with_marks(result, entries)
    exercises = tuple(
        _exercise(number, exercise, config, site)
        for number, exercise in enumerate(result.exercises, start=1)
    )
    start = next((exercise for exercise in exercises if not exercise.passed), None)
    return Page(
        student=visible(result.student),
        assignment=visible(result.assignment),
        title=config.title or visible(result.assignment),
        score=result.score,
        max_score=result.max_score,
        verdict=verdict(result),
        # Why the grader failed is told to the instructor alone.
        note="" if result.status == "failed" else visible(result.reason),
        note_kind="Note" if result.status == "graded" else "Reason",
        start=start,
        next=_next(result, start),
        exercises=exercises,
        by_hand=tuple(_by_hand(result, entries)),
    )


def _by_hand(result: Result, entries: Entries) -> Iterator[ShownMark]:
    names = [exercise.name for exercise in result.exercises]
    for entry in entries if result.status != "failed" else ():
        at = f"exercise-{names.index(entry.name) + 1}" if entry.name in names else ""
        yield ShownMark(visible(entry.name), at, _given(entry), visible(entry.words))


def _given(entry: Entry) -> str:
    if entry.waits:
        return "not marked yet"
    if entry.max_score:
        return _points(entry.points, entry.max_score)
    points = f"{entry.points:+} {'point' if abs(entry.points) == 1 else 'points'}"
    return points if entry.points else ""


def _next(result: Result, start: ShownExercise | None) -> str:
    if result.status == "refused":
        return "Fix that, make sure that JupyterLab opens the notebook, and hand it in again."
    if result.status == "failed":
        return "You need do nothing: your instructor is told, and your notebook is kept."
    if start is None:
        return "Nothing is left to do."
    return "If you may hand in again, run autograder check on your notebook first."


def _exercise(number: int, exercise: ExerciseResult, config: Config, site: str) -> ShownExercise:
    told = {case.message for case in exercise.cases}
    passed = exercise.status == "passed"
    return ShownExercise(
        name=visible(exercise.name),
        anchor=f"exercise-{number}",
        outcome=sign(outcome(exercise)),
        kind=exercise.status if exercise.status in SIGNS else "lost",
        passed=passed,
        points=_points(exercise.score, exercise.max_score),
        meaning=meaning(exercise, config.limits),
        advice=ADVICE[outcome(exercise)],
        message="" if exercise.message in told else visible(exercise.message),
        misconception="" if passed else visible(exercise.misconception),
        hints=() if passed else tuple(clicks.named(config.hints.get(exercise.name, ()))),
        reading=None if passed else reading(config, exercise.name, site),
        cases=tuple(_case(case, exercise.cases[:n]) for n, case in enumerate(exercise.cases)),
    )


def _points(score: float, most: float) -> str:
    return f"{score} of {most} {'point' if most == 1 else 'points'}"


def _case(case: CaseResult, before: Sequence[CaseResult]) -> ShownCase:
    """Show a case after those before: after a fault the others of an exercise do not run."""
    passed = case.passed
    again = not passed and case.message in {each.message for each in before if not each.passed}
    not_run = again and case.ending.is_fault
    compared = None if passed or again else case.compared
    message = "" if again else visible(case.message)
    return ShownCase(
        name=visible(case.name),
        outcome=NOT_RUN if not_run else sign("passed" if passed else "failed"),
        passed=passed,
        points=_points(case.earned, case.points),
        other_inputs=not (case.visible or not_run or case.message == NOT_WRITTEN),
        message=message,
        as_above=again and not not_run,
        sentence=visible(case.sentence) if compared else message,
        values=compared,
        curves=_curves(*compared.curves) if compared and compared.curves else None,
    )


def _curves(yours: Sequence[float], expected: Sequence[float]) -> Curves | None:
    """Draw two or more finite numbers beside as many expected; None where they range too far."""
    low, high = min(*yours, *expected), max(*yours, *expected)
    if not math.isfinite(high - low):
        return None

    def placed(row: Sequence[float]) -> tuple[tuple[float, float], ...]:
        step = 100 / (len(row) - 1)
        shares = ((value - low) / (high - low) if high > low else 0.5 for value in row)
        return tuple((n * step, CURVE * (1 - share)) for n, share in enumerate(shares))

    return Curves(placed(yours), placed(expected), f"{low:.6g}", f"{high:.6g}")
