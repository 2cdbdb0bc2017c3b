"""Late work: when it was due and when it was handed in, and what a day costs.

By hand: an assignment of 20 points, 10 % a day. Handed in 25 hours late, two days have
begun; that is 20 % of 20 points, 4 off. A mark of 15 becomes 11, and none falls below 0.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any
from zoneinfo import ZoneInfo

from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.reading import submission, timestamp
from robust_slam_autograder.reading.table import Kinds, read_table

NONE = "none"
"""A due time that never comes."""
_KINDS: Kinds = {
    "timezone": str,
    "due": dict,
    "extensions": {...: dict},
    "policy": dict.fromkeys(("grace_minutes", "percent_per_day", "cap_percent"), (int, float)),
}


class Undated(WrongUse):
    """One submission does not say when it was handed in: its lateness is unknown."""


@dataclass(frozen=True)
class HandedIn:
    """A time in UTC, and who says so."""

    at: datetime
    source: str
    """``timestamp.txt``, or the notebook's name: then a copy without its times says too late."""


@dataclass(frozen=True)
class Policy:
    """What lateness costs."""

    percent_per_day: float
    """Of the assignment's points, for each 24 hours that have begun."""
    grace_minutes: float = 0.0
    """Minutes after the due time that cost nothing; days are counted from their end."""
    cap_percent: float = 100.0
    """The most that is taken off, of the assignment's points."""

    def penalty(self, lateness: timedelta, max_score: float) -> float:
        """Return points off for work that came ``lateness`` after its due time."""
        beyond = lateness - timedelta(minutes=self.grace_minutes)
        days = max(0, math.ceil(beyond / timedelta(days=1)))
        return max_score * min(self.percent_per_day * days, self.cap_percent) / 100

    def __str__(self) -> str:
        return (
            f"{self.percent_per_day:g} % of the points for each 24 hours begun, "
            f"after {self.grace_minutes:g} minutes' grace, at most {self.cap_percent:g} %"
        )


@dataclass(frozen=True)
class Rules:
    """A course's due times, with a time zone each."""

    path: Path
    timezone: ZoneInfo | None
    policy: Policy
    due: Mapping[str, datetime | None]
    """By assignment, in UTC; None where there is no due time."""
    extensions: Mapping[str, Mapping[str, datetime | None]]
    """By assignment and student a due time of their own."""

    def due_for(self, assignment: str, student: str) -> datetime | None:
        """Return when a student's work is due.

        Raises:
            WrongUse: the file does not say.
        """
        if assignment not in self.due:
            raise WrongUse(
                f"{self.path}: there is no due time for {assignment}: write it under [due], "
                f'or "{NONE}".'
            )
        return self.extensions.get(assignment, {}).get(student, self.due[assignment])


def load(path: Path) -> Rules:
    """Read due times and policy from a TOML file.

    Raises:
        WrongUse: names the file and the key that is missing, unknown or no time.
    """
    table = read_table(path, _KINDS)
    if "policy" not in table or "due" not in table:
        raise WrongUse(f"{path}: [policy] with percent_per_day, and [due], are wanted.")
    zone = _zone(path, table.get("timezone"))

    def times(where: str, said: Mapping[str, object]) -> dict[str, datetime | None]:
        return {name: _time(path, f"{where}.{name}", one, zone) for name, one in said.items()}

    policy, due = _policy(path, table["policy"]), times("due", table["due"])
    own = table.get("extensions", {})
    extensions = {name: times(f"extensions.{name}", said) for name, said in own.items()}
    return Rules(path, zone, policy, due, extensions)


def _zone(path: Path, name: str | None) -> ZoneInfo | None:
    try:
        return None if name is None else ZoneInfo(name)
    except (ValueError, OSError, LookupError) as error:
        raise WrongUse(f'{path}: {name!r} is no time zone, as "Europe/Berlin" is.') from error


def _policy(path: Path, table: dict[str, Any]) -> Policy:
    if "percent_per_day" not in table:
        raise WrongUse(f"{path}: [policy] needs percent_per_day; 0 takes nothing off.")
    for key, value in table.items():
        most = 100 if "percent" in key else 7 * 24 * 60
        if not 0 <= value <= most:
            raise WrongUse(f"{path}: {key} is a number from 0 to {most}, not {value}.")
    return Policy(**table)


def _time(path: Path, where: str, value: object, zone: ZoneInfo | None) -> datetime | None:
    if value == NONE:
        return None
    if not isinstance(value, datetime):
        raise WrongUse(
            f'{path}: {where} must be a date with a time, as 2026-10-20T23:59:00, or "{NONE}".'
        )
    if value.tzinfo is not None:
        return value.astimezone(UTC)
    if zone is None:
        raise WrongUse(
            f'{path}: {where} has no time zone: write timezone = "…" above, or end it in Z '
            "or +02:00."
        )
    local = value.replace(tzinfo=zone)
    if local.utcoffset() != local.replace(fold=1).utcoffset():
        raise WrongUse(
            f"{path}: {where} comes twice or never in {zone}, for clocks change then: "
            "end it in +01:00 or the like."
        )
    # On one clock, so that two times' difference is true.
    return local.astimezone(UTC)


def handed_in(folder: Path, notebook: str) -> HandedIn:
    """Return when a submission was: by nbgrader's ``timestamp.txt``, else the notebook's own time.

    The folder is ``submitted/<student>/<assignment>/``, the notebook's name without its ending.

    Raises:
        Undated: there is no folder or no notebook, or ``timestamp.txt`` holds no time.
    """
    try:
        stated = timestamp.read(folder)
    except Refused as error:
        raise Undated(f"{folder}: {error}") from error
    if stated is not None:
        return HandedIn(stated, timestamp.NAME)
    try:
        path, _ = submission.notebook_in(folder, notebook)
        modified = path.lstat().st_mtime
    except (Refused, OSError) as error:
        raise Undated(
            f"{folder} does not say when it was handed in ({error}): "
            "name the submissions' folder with --submitted DIR."
        ) from error
    return HandedIn(datetime.fromtimestamp(modified, UTC), path.name)
