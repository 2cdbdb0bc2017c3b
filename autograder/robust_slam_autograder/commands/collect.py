"""``autograder collect``: take in the zip of submissions of Canvas or Moodle."""

import argparse
import os
import sys
from pathlib import Path

from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import durable
from robust_slam_autograder.lms import downloads, roster, systems
from robust_slam_autograder.lms.downloads import Archive, Notebook
from robust_slam_autograder.markup import log_line, one_line
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import submission, timestamp


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("zip", type=Path, metavar="ZIP", help="as the system hands it out")
    places.add(parser, *places.ROSTER, "--submitted")
    parser.add_argument(
        "--name",
        nargs="+",
        default=[],
        metavar="COLUMN",
        help="the roster's columns that make up the name in Moodle's zip, in its order",
    )
    parser.add_argument(
        "--assignment", metavar="NAME", help="that of notebooks whose own names do not say it"
    )
    parser.add_argument(
        "--replace", action="store_true", help="put a notebook in the place of an earlier one"
    )


def run(options: argparse.Namespace) -> int:
    """Write the folders; exit status 1 where something was left out."""
    system = systems.SYSTEMS[options.format]
    if options.name and options.format == "canvas":
        raise WrongUse("--name is for Moodle: the files of Canvas's zip have the roster's ID.")
    names = assignments.find_names(options.solutions)
    assignments.find_names(options.solutions, filter(None, [options.assignment]))
    stems = {assignments.notebook_path(options.solutions / name).stem: name for name in names}
    people, students, match = places.roster(options)
    reader = downloads.Reader(
        system.sent,
        downloads.owners(system.keys(people, options.name), students),
        match,
        stems | {name: name for name in names},
        options.assignment,
    )
    archive = Archive(options.zip)
    found, left = reader.read(archive)
    if not archive.infos:
        raise WrongUse(f"{options.zip} is empty: download it again.")
    taken: list[Notebook] = []
    for one in found:
        try:
            _put(one, archive, options)
            taken.append(one)
        except ValueError as error:
            left[one.entry] = str(error)
    listed = {roster.key(row.cells[match]) for row in students} - {""}
    has = [one.entry for one in found if _there(options.submitted, one.student, one.assignment)]
    may_be = [one for one in left if submission.is_notebook(one) or one.lower().endswith(".zip")]
    lost = [one for one in may_be if one not in has]
    about = {one.assignment for one in found} | {*filter(None, [options.assignment])}
    downloads.remember(options.submitted, archive, lost, about)
    _tell(taken, left, listed, options.submitted)
    return 1 if left else 0


def _there(into: Path, student: str, assignment: str) -> list[str]:
    folder = into / student / assignment
    return [path.name for path in submission.notebooks(folder)] if folder.is_dir() else []


def _put(one: Notebook, archive: Archive, options: argparse.Namespace) -> None:
    """Write a notebook where it belongs; a ValueError says why it is left out."""
    folder = options.submitted / one.student / one.assignment
    notebook = assignments.notebook_path(options.solutions / one.assignment)
    path = folder / notebook.name
    data = archive.read(one.entry)
    for above in (options.submitted / one.student, folder, path):
        if above.is_symlink():
            raise ValueError(f"would be written through a link, {log_line(str(above))}: remove it")
    others = _there(options.submitted, one.student, one.assignment)
    if path.name in others and path.read_bytes() == data:
        return
    where = log_line(str(folder))
    if others and not options.replace:
        raise ValueError(f"differs from what {where} holds already: add --replace")
    if others not in ([], [path.name]):
        raise ValueError(f"cannot replace {', '.join(map(log_line, others))} in {where}")
    with durable.explained(path, part := durable.part_of(path)):
        folder.mkdir(parents=True, exist_ok=True)
        part.write_bytes(data)
        # As unzip does: the zip's times are of this machine's clock.
        os.utime(part, ((at := one.at or archive.at).timestamp(), at.timestamp()))
        # It is about what was handed in before.
        (folder / timestamp.NAME).unlink(missing_ok=True)
        os.replace(part, path)


def _tell(taken: list[Notebook], left: dict[str, str], listed: set[str], into: Path) -> None:
    for entry, why in left.items():
        print(f"left out: {log_line(entry)} {one_line(why)}", file=sys.stderr)
    for name in dict.fromkeys(one.assignment for one in taken):
        mine = [one for one in taken if one.assignment == name]
        told = {
            "late, says the system: {0} of {1}": {one.student for one in mine if one.late},
            "no time in the zip, so its own counts: {0} of {1}": {
                one.student for one in mine if one.at is None
            },
            "no notebook of {1}: {0}": {one for one in listed if not _there(into, one, name)},
        }
        for said, who in told.items():
            if who:
                names = ", ".join(map(one_line, sorted(who)))
                print(f"{said.format(len(who), name)} ({names})")
    people = len({one.student for one in taken})
    print(f"{len(taken)} notebooks of {people} students are in {into}.")
