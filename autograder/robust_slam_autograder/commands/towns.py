"""``autograder towns``: give each student a number for data of their own."""

import argparse
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.grading import batch, durable
from robust_slam_autograder.grading.journal import open_journal
from robust_slam_autograder.lms import roster, systems
from robust_slam_autograder.lms.marks import Column
from robust_slam_autograder.lms.roster import Row
from robust_slam_autograder.markup import as_csv


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    places.add(parser, "--out", *places.ROSTER)
    parser.add_argument(
        "--to", type=Path, metavar="FILE", help="default: class/towns-canvas.csv, or -moodle.csv"
    )


def run(options: argparse.Namespace) -> int:
    """Write the numbers as a column to import; from now on grading uses them."""
    layout.refuse_unmoved(options.out)
    to = places.target(options, f"towns-{options.format}.csv")
    system = systems.SYSTEMS[options.format]
    people, lines, match = places.roster(options)
    students = roster.by_key(people, lines, match)
    with batch.locked(options.out):
        journal = open_journal(options.out, None)
        journal.give_towns()

    def cell(row: Row, column: Column) -> str | None:
        name = roster.key(row.cells[match])
        return str(journal.town(name)) if name in students else None

    column = Column("Town", "", 0, {}, {})  # Canvas would add points to the course's total
    place = systems.find(system, people, column)
    found = {} if place is None else {column.name: place}
    values = systems.Values(match, [column], found, cell)
    durable.write(to, as_csv(system.table(people, values)), private=True)
    print(
        f"{len(students)} students have numbers, by {people.header[match]}, and what is graded "
        f"from now on uses them. To import into {system.title}: {to}"
    )
    return 0
