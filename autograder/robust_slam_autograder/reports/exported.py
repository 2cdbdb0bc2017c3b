"""What an export did, for a terminal: who is where, and what lateness cost."""

from collections.abc import Iterator, Sequence
from datetime import UTC, timedelta

from robust_slam_autograder.lms.late import Rules
from robust_slam_autograder.lms.marks import Column
from robust_slam_autograder.lms.roster import Matching
from robust_slam_autograder.markup import log_line, one_line
from robust_slam_autograder.reports.terminal import aligned


def late_table(columns: Sequence[Column], rules: Rules | None) -> str:
    """Return every mark before and after what lateness costs, with the time that it follows from.

    Without rules it is nbgrader's own policy that has taken something off.
    """
    zone = UTC if rules is None or rules.timezone is None else rules.timezone
    rows = [("student", "assignment", "handed in", "says", "late", "before", "after")]
    for column in columns:
        for student, mark in sorted(column.marks.items()):
            at = source = ""
            if mark.handed_in is not None:
                at = mark.handed_in.at.astimezone(zone).strftime("%Y-%m-%d %H:%M:%S %z")
                source = one_line(mark.handed_in.source)
            told = at, source, span(mark.late), str(mark.before), str(mark.after)
            rows.append((one_line(student), column.name, *told))
    said = "nbgrader's own late policy" if rules is None else f"{rules.path}: {rules.policy}"
    return "\n".join([*aligned(rows), f"Late work: {said}. Times are in {zone}."])


def span(late: timedelta) -> str:
    """Write a duration in days, hours, minutes and seconds, as ``1d 2h 03m 04s``."""
    if not late:
        return ""
    minutes, seconds = divmod(late.total_seconds(), 60)
    hours, minutes = divmod(int(minutes), 60)
    days, hours = divmod(hours, 24)
    return f"{days}d {hours}h {minutes:02d}m {seconds:02.0f}s"


def remarks(matching: Matching, *, rules: Rules | None, zero: bool) -> Iterator[str]:
    """Yield one line for each kind of thing that an instructor must know of the file.

    With ``zero`` students without a submission get 0.
    """
    ledger = matching.ledger
    if matching.strangers:
        yield f"not on the roster, and not in the file: {_listed(matching.strangers)}"
    if matching.likely:
        yield matching.likely
    for same in matching.doubled.values():
        # ascii(): as text they look alike.
        both = " and ".join(map(ascii, same))
        yield f"{both} are one name, written in two ways: no mark; grade them as one student"
    for one in ledger.ungraded:
        who = f"{one_line(one.student)}/{one.assignment}"
        if one.status == "failed":
            yield f"the grader failed on {who}: no mark; grade it again"
        else:
            yield (
                f"{who} was refused, so no test has given it points: let it be handed in again, "
                f"or leave the mark ({one_line(one.reason)})"
            )
    for column in ledger.columns:
        for student, why in sorted(column.undated.items()):
            yield f"{one_line(student)}/{column.name} has no mark: {log_line(why)}"
        what = "0" if zero else "left as the roster has it"
        if zero and (why := matching.unclear(column)):
            what = f"no 0 either, for {why}"
        if absent := matching.absent(column):
            yield f"no submission of {column.name}, {what}: {_listed(absent)}"
        if waiting := sorted(student for student, mark in column.marks.items() if mark.waits):
            yield f"{column.name} waits for a person's marks: {_listed(waiting)}"
        own = {} if rules is None else rules.extensions.get(column.name, {})
        if unknown := sorted(own.keys() - column.marks.keys() - column.undated.keys()):
            yield f"an extension for {column.name}, and no mark of theirs: {_listed(unknown)}"


def _listed(names: Sequence[str]) -> str:
    return f"{len(names)} ({', '.join(map(one_line, names))})"
