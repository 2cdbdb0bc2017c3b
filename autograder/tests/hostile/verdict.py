"""Judges marks, by whichever grader: plain data in, sentences out."""

from collections.abc import Iterable, Mapping

from .entry import Entry
from .target import Target

Marks = Mapping[str, float]
"""What one submission earned, by the grade id of the case; of a refused one there is none."""
All = Mapping[str, Marks]
"""By the submission's name."""

KEEP = ("resources", "values", "reading", "broken")
"""Groups of kinds in which a submission loses in the victim's exercise alone.

The others change the process that their other exercises run in, or speak for them: their own loss.
"""


def inflated(entry: Entry, marks: All, target: Target, baselines: Iterable[str]) -> str:
    """Say what an entry earned that it must not; empty where it did not."""
    mine = marks.get(entry.name, {})
    most = {case.grade_id: case.points for case in target.assignment.cases}
    over = [key for key, points in mine.items() if points > most.get(key, 0)]
    if over:
        return f"{entry.name} earned more than there is at {', '.join(over)}"
    if entry.bound == "refused" and any(mine.values()):
        return f"{entry.name} earned {sum(mine.values())} though it is to be refused"
    victims = [case.grade_id for case in target.victim_cases]
    if entry.bound == "less" and all(mine.get(key, 0) == most[key] for key in victims):
        return f"{entry.name} earned all points of {target.victim}"
    if entry.bound == "wrong":
        plain = [*baselines, *([entry.twin] if entry.twin else [])]
        allowed = {key: max(marks.get(n, {}).get(key, 0) for n in plain) for key in victims}
        gained = [key for key in victims if mine.get(key, 0) > allowed[key]]
        return f"{entry.name} earned {', '.join(gained)}" if gained else ""
    return ""


def under_graded(entry: Entry, marks: All, target: Target) -> str:
    """Say what an entry that is right did not earn; empty where it earned all."""
    mine = marks.get(entry.name, {})
    lost = [c.grade_id for c in target.assignment.cases if mine.get(c.grade_id, 0) < c.points]
    return f"{entry.name} lost {', '.join(lost)}" if entry.bound == "full" and lost else ""


def spilled(entry: Entry, marks: All, target: Target, baseline: str) -> str:
    """Say what an entry lost in exercises that it answers rightly; empty where it lost nothing."""
    if entry.spills or entry.bound == "refused" or entry.kind.split(":")[0] not in KEEP:
        return ""
    victims = {case.grade_id for case in target.victim_cases}
    mine, plain = marks.get(entry.name, {}), marks.get(baseline, {})
    others = [key for key in plain if key not in victims]
    lost = [key for key in others if mine.get(key, 0) < plain[key]]
    return f"{entry.name} lost {', '.join(lost)} too" if lost else ""
