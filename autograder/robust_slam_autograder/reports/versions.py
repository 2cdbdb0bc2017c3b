"""Results of one assignment that were made by different tests are not to be mixed."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

from robust_slam_autograder.grading.results import Result, tidy
from robust_slam_autograder.markup import visible

Shape = tuple[float, tuple[tuple[str, tuple[tuple[str, float, bool], ...]], ...]]
"""Points in all; per exercise its name, and per case its name, points and visibility."""


@dataclass(frozen=True)
class Version:
    """The results that one version of an assignment's tests made."""

    results: tuple[Result, ...]
    differences: tuple[str, ...]
    """From the most common version; none for that one itself."""


def of(results: Sequence[Result]) -> tuple[Version, ...]:
    """Tell the graded results apart by the tests that made them, the most common first."""
    groups: dict[Shape, list[Result]] = {}
    for result in results:
        if result.status == "graded":
            groups.setdefault(_shape(result), []).append(result)
    ordered = sorted(groups.items(), key=lambda group: (-len(group[1]), -group[0][0]))
    return tuple(
        Version(tuple(group), tuple(_differences(ordered[0][0], shape)))
        for shape, group in ordered
    )


def _shape(result: Result) -> Shape:
    exercises = (
        (exercise.name, tuple((case.name, case.points, case.visible) for case in exercise.cases))
        for exercise in result.exercises
    )
    return result.max_score, tuple(exercises)


def _differences(usual: Shape, other: Shape) -> Iterator[str]:
    if usual == other:
        return
    if usual[0] != other[0]:
        yield f"{tidy(other[0])} points in all in place of {tidy(usual[0])}"
    yield from _lists("exercise", [name for name, _ in usual[1]], [name for name, _ in other[1]])
    both = {name for name, _ in usual[1]} & {name for name, _ in other[1]}
    before, now = _cases(usual, both), _cases(other, both)
    yield from _lists("case", [*before], [*now])
    for name in before:
        if name in now and before[name] != now[name]:
            yield f"{visible(name)}: {_said(now[name])} in place of {_said(before[name])}"


def _lists(what: str, before: Sequence[str], now: Sequence[str]) -> Iterator[str]:
    for sign, names, others in (("without", before, now), ("with", now, before)):
        if found := [visible(name) for name in names if name not in others]:
            yield f"{sign} the {what}{'s' * (len(found) > 1)} {', '.join(found)}"
    if sorted(before) == sorted(now) and [*before] != [*now]:
        yield f"the {what}s in another order"


def _cases(shape: Shape, exercises: Collection[str]) -> dict[str, tuple[float, bool]]:
    return {
        f"{exercise}-{name}": (points, seen)
        for exercise, cases in shape[1]
        if exercise in exercises
        for name, points, seen in cases
    }


def _said(case: tuple[float, bool]) -> str:
    points, seen = case
    return (
        f"{tidy(points)} {'point' if points == 1 else 'points'}, {'visible' if seen else 'hidden'}"
    )
