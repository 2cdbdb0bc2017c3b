"""``autograder export``: write marks for Canvas or Moodle."""

import argparse
import functools
import sys
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable
from robust_slam_autograder.lms import downloads, late, marks, roster, systems
from robust_slam_autograder.lms.late import Rules
from robust_slam_autograder.lms.marks import Ledger
from robust_slam_autograder.lms.roster import Matching, Roster
from robust_slam_autograder.lms.systems import System, Values
from robust_slam_autograder.markup import as_csv
from robust_slam_autograder.reports import exported


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    places.add(parser, "names", "--submitted", "--out", "--gradebook", *places.ROSTER)
    parser.add_argument(
        "--column",
        type=_pair,
        action="append",
        default=[],
        metavar="NAME=HEADER",
        help="the roster's column of an assignment, where neither name nor title says it",
    )
    parser.add_argument(
        "--late", type=Path, metavar="FILE", help="due times and what lateness costs, in TOML"
    )
    parser.add_argument(
        "--missing-as-zero", action="store_true", help="0 for who is on the roster without work"
    )
    parser.add_argument(
        "--to", type=Path, metavar="FILE", help="default: class/canvas.csv, class/moodle.csv"
    )


def _pair(text: str) -> tuple[str, str]:
    name, mark, header = text.partition("=")
    if not (name and mark and header.strip()):
        raise argparse.ArgumentTypeError("an assignment and its column, as 02-name=Header (12345)")
    return name, header.strip()


def run(options: argparse.Namespace) -> int:
    """Write the file; exit status 1 where a mark is not in it."""
    layout.refuse_unmoved(options.out)
    to = places.target(options, f"{options.format}.csv")
    system = systems.SYSTEMS[options.format]
    people, lines, match = places.roster(options)
    students = roster.by_key(people, lines, match)
    rules = None if options.late is None else late.load(options.late)
    ledger = marks.read(
        options.solutions,
        options.names,
        location=places.gradebook(options),
        out=options.out,
        rules=rules,
        submitted=options.submitted,
    )
    matched = Matching(ledger, students, downloads.left_out(options.submitted))
    if not matched.owners:
        raise WrongUse(
            f"{options.roster}: no one in its column {people.header[match]!r} has a mark: "
            f"{matched.likely or 'name another with --match'}; there are {people.columns}."
        )
    values = Values(
        match,
        ledger.columns,
        _places(system, people, ledger, options),
        functools.partial(matched.cell, zero=options.missing_as_zero),
    )
    durable.write(to, as_csv(system.table(people, values)), private=True)
    _tell(rules, matched, values, zero=options.missing_as_zero)
    marked = {*matched.owners.values()} & {one for c in ledger.columns for one in c.marks}
    print(
        f"{len(marked)} of {len(students)} students have marks, matched by "
        f"{people.header[match]}. To import into {system.title}: {to}"
    )
    unclear = any(map(matched.unclear, ledger.columns))
    return 1 if unclear or matched.doubled or ledger.lost else 0


def _places(
    system: System, people: Roster, ledger: Ledger, options: argparse.Namespace
) -> dict[str, int]:
    """Return by assignment the roster's column, named on the command line or found."""
    named = dict(options.column)
    unknown = named.keys() - {column.name for column in ledger.columns}
    if unknown:
        raise WrongUse(f"--column {min(unknown)}=…: there is no mark of {min(unknown)}.")
    taken: dict[int, str] = {}
    for column in ledger.columns:
        said = named.get(column.name)
        place = people.column(said, "--column") if said else systems.find(system, people, column)
        if place in taken:
            both = f"{taken[place]} and {column.name} are both {people.header[place]!r}"
            raise WrongUse(f"{both}: say --column {column.name}=HEADER.")
        if place is not None:
            taken[place] = column.name
    return {name: place for place, name in taken.items()}


def _tell(rules: Rules | None, matched: Matching, values: Values, *, zero: bool) -> None:
    columns = values.columns
    every = (mark for column in columns for mark in column.marks.values())
    if rules is not None or any(mark.before != mark.after for mark in every):
        print(exported.late_table(columns, rules))
    if new := ", ".join(one.name for one in columns if one.name not in values.places):
        print(f"new columns, because the roster has none for them: {new}", file=sys.stderr)
    for line in exported.remarks(matched, rules=rules, zero=zero):
        print(line, file=sys.stderr)
