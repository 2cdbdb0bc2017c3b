"""Judges the records of both graders by the same bounds, and writes the tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from benchmarks.attacks.ours import UNKNOWN
from benchmarks.attacks.record import HIDDEN_INPUTS, HIDDEN_TESTS, OWN_READING, TOKEN, Record
from tests.autograder.hostile import verdict
from tests.autograder.hostile.catalogue import BASELINES
from tests.autograder.hostile.entry import Entry
from tests.autograder.hostile.kinds import CORRECT, KINDS
from tests.autograder.hostile.target import Target

INFLATED, FULL, UNDER, HARMED, STOPPED = "inflated", "full", "under-graded", "harmed", "stopped"
COLUMNS = {
    INFLATED: "inflated",
    UNDER: "under-graded",
    HIDDEN_TESTS: "hidden tests leaked",
    HIDDEN_INPUTS: "hidden inputs leaked",
    TOKEN: "token leaked",
    HARMED: "others harmed",
    STOPPED: "batch stopped",
}
Records = Mapping[str, Record]


@dataclass(frozen=True)
class Side:
    """One grader's part of a run."""

    name: str
    records: Records
    per_minute: float


def faults(
    entries: Sequence[Entry], records: Records, target: Target
) -> dict[str, frozenset[str]]:
    """What is wrong about each submission, by the names of ``COLUMNS`` and a few more."""
    marks = {name: record.marks for name, record in records.items()}
    judged = [entry for entry in entries if entry.kind and entry.name in records]
    found = {e.name: frozenset(_faults(e, records[e.name], marks, target)) for e in judged}
    if UNKNOWN in records:
        found[UNKNOWN] = frozenset(_happened(records[UNKNOWN]))
    return found


def _faults(
    entry: Entry, record: Record, marks: Mapping[str, verdict.Marks], target: Target
) -> Iterator[str]:
    if _inflated(entry, marks, target):
        yield INFLATED
        if sum(record.marks.values()) >= sum(case.points for case in target.assignment.cases):
            yield FULL
    if verdict.under_graded(entry, marks, target):
        yield UNDER
    yield from record.leaks
    yield from _happened(record)


def _inflated(entry: Entry, marks: Mapping[str, verdict.Marks], target: Target) -> bool:
    # Right answers in a file that is hard to read are worth what they earn.
    own_work = entry.bound == "refused" and entry.kind.startswith("broken:")
    return not own_work and bool(verdict.inflated(entry, marks, target, BASELINES))


def _happened(record: Record) -> Iterator[str]:
    if record.harmed:
        yield HARMED
    if record.stopped:
        yield STOPPED


def summary(entries: Sequence[Entry], sides: Sequence[Side], target: Target) -> str:
    """One line per grader."""
    heads = (
        "inflated (of these to 100 %)",
        "correct work under-graded",
        "hidden tests leaked (of these read by the submission's own code)",
        "hidden inputs leaked",
        "token leaked",
        "other students harmed",
        "batch stopped or hung",
        "correct submissions per minute",
    )
    lines = [f"| | {' | '.join(heads)} |", "|---" * (len(heads) + 1) + "|"]
    for side in sides:
        found = faults(entries, side.records, target)
        count = {
            name: sum(name in one for one in found.values())
            for name in (*COLUMNS, FULL, OWN_READING)
        }
        cells = [f"{count[INFLATED]} ({count[FULL]})", str(count[UNDER])]
        cells += [f"{count[HIDDEN_TESTS]} ({count[OWN_READING]})", str(count[HIDDEN_INPUTS])]
        cells += [str(count[name]) for name in (TOKEN, HARMED, STOPPED)]
        cells.append(f"{side.per_minute:.0f}")
        lines.append(f"| {side.name} | {' | '.join(cells)} |")
    return "\n".join(lines)


def by_kind(entries: Sequence[Entry], sides: Sequence[Side], target: Target) -> str:
    """One line per kind: the graders' counts in their order, empty where all are 0."""
    found = [faults(entries, side.records, target) for side in sides]
    kinds: dict[str, list[str]] = {kind: [] for kind in (*KINDS, *CORRECT)}
    for entry in entries:
        if entry.kind and all(entry.name in one for one in found):
            kinds[entry.kind].append(entry.name)
    lines = [f"| kind | submissions | {' | '.join(COLUMNS.values())} |"]
    lines.append("|---" * (len(COLUMNS) + 2) + "|")
    for kind, names in ((kind, names) for kind, names in kinds.items() if names):
        cells = [_counts(column, names, found) for column in COLUMNS]
        lines.append(f"| {kind} | {len(names)} | {' | '.join(cells)} |")
    return "\n".join(lines)


def _counts(
    column: str, names: Sequence[str], found: Sequence[Mapping[str, frozenset[str]]]
) -> str:
    counts = [sum(column in one[name] for name in names) for one in found]
    return " / ".join(map(str, counts)) if any(counts) else ""
