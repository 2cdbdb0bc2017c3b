"""What grading again changes, as a table and as JSON; no message of a check is in either."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from robust_slam_autograder.grading.regrading import Regraded
from robust_slam_autograder.grading.results import ExerciseResult, Result, tidy
from robust_slam_autograder.markup import one_line, visible
from robust_slam_autograder.reports.terminal import aligned

if TYPE_CHECKING:
    from robust_slam_autograder.nbgrader.totals import Effect

SCHEMA = 1
ANEW = "handed in anew since it was graded"
NOTHING = "–"


@dataclass(frozen=True)
class Regrade:
    """One assignment, graded again."""

    assignment: str
    again: Sequence[Regraded]
    """What was graded again."""
    kept: int
    """How many had been graded with these tests already."""
    failed: Sequence[str]
    """Students on whose submission the grader failed now."""
    left_out: Sequence[str]
    """Students whose submission is not there."""
    effects: Mapping[str, Effect]
    """By student what becomes of the gradebook's total."""
    applied: bool

    @property
    def changed(self) -> list[Regraded]:
        """Return whose marks change."""
        return [one for one in self.again if one.is_changed]


def table(regrade: Regrade) -> str:
    """Return per exercise and in total: before, after, and the difference."""
    rows = [("student", "exercise", "before", "after", "change", "")]
    for one in regrade.changed:
        rows += _rows(one)
    return "\n".join([*(aligned(rows) if len(rows) > 1 else []), *_summary(regrade)])


def _rows(one: Regraded) -> Iterator[tuple[str, str, str, str, str, str]]:
    student = one_line(one.before.student)
    for change in one.exercises:
        yield student, change.name, *_three(change.before, change.after), ""
    remarks = [ANEW] if one.is_newer else []
    if one.before.status != one.after.status:
        remarks.append(f"{one.before.status} → {one.after.status}")
    yield student, "total", *_three(one.before, one.after), "; ".join(remarks)


def _three(
    before: ExerciseResult | Result | None, after: ExerciseResult | Result | None
) -> tuple[str, str, str]:
    old, new = (0 if one is None else one.score for one in (before, after))
    return _of(before), _of(after), f"{tidy(new - old):+}"


def _of(one: ExerciseResult | Result | None) -> str:
    return NOTHING if one is None else f"{one.score}/{one.max_score}"


def _summary(regrade: Regrade) -> Iterator[str]:
    changed = regrade.changed
    up = sum(one.after.score > one.before.score for one in changed)
    down = sum(one.after.score < one.before.score for one in changed)
    yield (
        f"{regrade.assignment}: {len(regrade.again)} graded again, {len(changed)} changed "
        f"({up} up, {down} down); {regrade.kept} had these tests already."
    )
    for student in regrade.failed:
        yield f"the grader failed on {one_line(student)}: the mark stays as it is"
    if regrade.left_out:
        names = ", ".join(map(one_line, regrade.left_out))
        yield f"left out, for there is no submission of theirs: {names}"
    verb = "gradebook" if regrade.applied else "gradebook would change"
    for student, effect in sorted(regrade.effects.items()):
        yield f"{verb}: {one_line(student)} {_effect(effect)}"
    if regrade.applied:
        yield "Applied: results and gradebook are as shown."
    elif regrade.again or regrade.effects:
        yield "Nothing was changed; --apply does it."


def _effect(effect: Effect) -> str:
    old = NOTHING if effect.before is None else f"{tidy(effect.before.score)}"
    waits = ", waits for a person" if effect.after.waits else ""
    return f"{old} → {tidy(effect.after.score)}{waits}"


def as_json(regrade: Regrade) -> str:
    """Return the same for other programs."""
    value = {
        "schema": SCHEMA,
        "assignment": regrade.assignment,
        "applied": regrade.applied,
        "counts": {
            "regraded": len(regrade.again),
            "changed": len(regrade.changed),
            "kept": regrade.kept,
            "failed": len(regrade.failed),
            "left_out": len(regrade.left_out),
        },
        "changes": [_entry(one) for one in regrade.changed],
        "gradebook": [
            {
                "student": visible(student),
                "before": None if effect.before is None else tidy(effect.before.score),
                "after": tidy(effect.after.score),
                "waits": effect.after.waits,
            }
            for student, effect in sorted(regrade.effects.items())
        ],
        "failed": list(map(visible, regrade.failed)),
        "left_out": list(map(visible, regrade.left_out)),
    }
    return json.dumps(value, indent=1, ensure_ascii=False) + "\n"


def _entry(one: Regraded) -> dict[str, Any]:
    return {
        "student": visible(one.before.student),
        "before": _mark(one.before),
        "after": _mark(one.after),
        "change": tidy(one.after.score - one.before.score),
        "handed_in_anew": one.is_newer,
        "exercises": [
            {"name": each.name, "before": _mark(each.before), "after": _mark(each.after)}
            for each in one.exercises
        ],
    }


def _mark(one: ExerciseResult | Result | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {"score": one.score, "max_score": one.max_score, "status": one.status}
