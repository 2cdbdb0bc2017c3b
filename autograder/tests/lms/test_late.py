"""Late work: what a day costs, whose clock counts, and who says when."""

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.lms import late
from robust_slam_autograder.lms.late import Policy

from ..timestamps import JUNK

HOUR = timedelta(hours=1)
TABLE = """\
timezone = "Europe/Berlin"
[policy]
percent_per_day = 10
grace_minutes = 15
cap_percent = 50
[due]
07-toy = 2026-10-20T23:59:00
08-free = "none"
09-utc = 2026-10-20T23:59:00Z
[extensions.07-toy]
ada = 2026-10-27T23:59:00
bob = "none"
"""


def loaded(folder: Path, text: str = TABLE) -> late.Rules:
    path = folder / "late.toml"
    path.write_text(text, encoding="utf-8")
    return late.load(path)


@pytest.mark.parametrize(
    ("lateness", "points"),
    [
        (timedelta(), 0),
        (timedelta(minutes=15), 0),
        (timedelta(minutes=15, seconds=1), 2),
        (24 * HOUR, 2),
        (24 * HOUR + timedelta(minutes=15), 2),
        (25 * HOUR, 4),
        (97 * HOUR, 10),
        (365 * 24 * HOUR, 10),
    ],
)
def test_each_day_begun_costs_up_to_the_cap(lateness, points):
    policy = Policy(percent_per_day=10, grace_minutes=15, cap_percent=50)
    assert policy.penalty(lateness, 20) == points


def test_due_times_are_the_zones_and_extensions_the_students(tmp_path):
    rules = loaded(tmp_path)
    due = rules.due_for("07-toy", "eve")
    assert due == datetime(2026, 10, 20, 21, 59, tzinfo=UTC)
    own = rules.due_for("07-toy", "ada")
    # Clocks change in between: a week is an hour longer.
    assert own - due == 7 * 24 * HOUR + HOUR
    assert rules.due_for("07-toy", "bob") is None
    assert rules.due_for("08-free", "ada") is None
    assert rules.due_for("09-utc", "ada") == datetime(2026, 10, 20, 23, 59, tzinfo=UTC)
    with pytest.raises(WrongUse, match="no due time for 10-new: write it under \\[due\\]"):
        rules.due_for("10-new", "ada")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('timezone = "Europe/Berlin"\n', "", "due.07-toy has no time zone"),
        ("Europe/Berlin", "Europe/Nowhere", "'Europe/Nowhere' is no time zone"),
        ("Europe/Berlin", "../../etc/passwd", "is no time zone"),
        ("2026-10-20T23:59:00\n", "2026-10-25T02:30:00\n", "comes twice or never"),
        ("2026-10-20T23:59:00\n", "2026-03-29T02:30:00\n", "comes twice or never"),
        ("2026-10-20T23:59:00\n", "2026-10-20\n", "due.07-toy must be a date with a time"),
        ("2026-10-20T23:59:00\n", '"soon"\n', "due.07-toy must be a date with a time"),
        ("percent_per_day = 10\n", "", "needs percent_per_day"),
        ("percent_per_day = 10", "percent_per_day = 101", "from 0 to 100, not 101"),
        ("percent_per_day = 10", "percent_per_day = nan", "from 0 to 100, not nan"),
        ("grace_minutes = 15", "grace_minutes = -1", "grace_minutes is a number from 0"),
        ("grace_minutes = 15", "grace = 15", "unknown key 'grace'"),
        ("[policy]", "[policies]", "unknown key 'policies'"),
        ("[extensions.07-toy]", "[extensions]", "value of the wrong type"),
        ("[due]", "[due", "is not valid TOML"),
    ],
)
def test_what_is_unclear_is_refused_by_name(tmp_path, old, new, words):
    assert old in TABLE
    with pytest.raises(WrongUse, match=r"late\.toml") as caught:
        loaded(tmp_path, TABLE.replace(old, new))
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("text", "moment"),
    [
        ("2026-10-20 23:59:00.5 UTC", datetime(2026, 10, 20, 23, 59, 0, 500_000, UTC)),
        ("2026-10-20 23:59:00 Europe/Berlin\n", datetime(2026, 10, 20, 21, 59, tzinfo=UTC)),
        ("2026-10-20 23:59:00.000000 +0530", datetime(2026, 10, 20, 18, 29, tzinfo=UTC)),
        ("2026-10-20T23:59:00+02:00", datetime(2026, 10, 20, 21, 59, tzinfo=UTC)),
        ("2026-10-20 23:59:00", datetime(2026, 10, 20, 23, 59, tzinfo=UTC)),
    ],
)
def test_nbgraders_time_comes_first(tmp_path, text, moment):
    (tmp_path / "timestamp.txt").write_text(text)
    (tmp_path / "07-toy.ipynb").write_text("{}")
    found = late.handed_in(tmp_path, "07-toy")
    assert found.at == moment and found.source == "timestamp.txt"


@pytest.mark.parametrize("spoil", JUNK.values(), ids=JUNK)
def test_what_holds_no_time_is_refused_and_not_guessed(tmp_path, spoil):
    (tmp_path / "07-toy.ipynb").write_text("{}")
    spoil(tmp_path / "timestamp.txt")
    with pytest.raises(late.Undated, match=r"timestamp\.txt"):
        late.handed_in(tmp_path, "07-toy")


def test_without_it_the_notebooks_own_time_counts_and_is_named(tmp_path):
    path = tmp_path / "renamed.ipynb"
    path.write_text("{}")
    os.utime(path, (1_000_000_000, 1_000_000_000))
    found = late.handed_in(tmp_path, "07-toy")
    assert found.at == datetime.fromtimestamp(1_000_000_000, UTC)
    assert found.source == "renamed.ipynb"
