"""Options that several commands have: where things are, looked at before a command works."""

import argparse
import functools
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, TypeAlias

from robust_slam_autograder import layout
from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.grading import pythons
from robust_slam_autograder.grading.entered_by_hand import Entered
from robust_slam_autograder.lms import roster as rosters
from robust_slam_autograder.lms import systems
from robust_slam_autograder.lms.roster import Roster, Row
from robust_slam_autograder.publishing import course as courses
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading.submission import DATABASE_NAME, DATABASE_VARIABLE

if TYPE_CHECKING:
    from sqlalchemy import URL  # the student's install lacks it

Gradebook: TypeAlias = "URL"


def _folder(default: Path, text: str) -> dict[str, Any]:
    return {"type": Path, "default": default, "metavar": "DIR", "help": text}


_OPTIONS: Mapping[str, Mapping[str, Any]] = {
    "names": {"nargs": "*", "metavar": "NAME", "help": "assignments; all where none"},
    "--out": _folder(layout.GRADED, "the results' folder"),
    "--submitted": _folder(
        layout.SUBMITTED, "where the submissions are, DIR/<student>/<assignment>/"
    ),
    "--misconceptions": _folder(
        layout.MISCONCEPTIONS,
        "what autograder misconceptions has written, to name what was misunderstood",
    ),
    "--answers": {
        "type": Path,
        "metavar": "DIR",
        "help": "right and wrong answers, DIR/<assignment>/<exercise>.toml",
    },
    "--gradebook": {
        "metavar": "URL",
        "help": f"a shared gradebook, postgresql://HOST/NAME; default: ${DATABASE_VARIABLE}, "
        f"else {DATABASE_NAME} in --out",
    },
    "--format": {"choices": ["canvas", "moodle"], "required": True},
    "--roster": {
        "type": Path,
        "required": True,
        "metavar": "FILE",
        "help": "the gradebook's CSV, as the system exports it",
    },
    "--match": {
        "metavar": "COLUMN",
        "help": "the roster's column that holds the names of the submissions' folders; "
        "default: SIS Login ID (canvas), Email address (moodle)",
    },
    "--notice": {
        "default": "",
        "metavar": "TEXT",
        "help": "stands at the top of each page, as “marks may still change”",
    },
}


ROSTER = ("--format", "--roster", "--match")
"""Options that say who is who."""


def add(parser: argparse.ArgumentParser, *options: str) -> None:
    """Declare some of the options that several commands have."""
    for option in options:
        parser.add_argument(option, **_OPTIONS[option])


def refuse_no_answers(options: argparse.Namespace) -> None:
    """Refuse answers from a folder that is not there.

    Raises:
        WrongUse: ``--answers`` names it.
    """
    if options.answers is not None and not options.answers.is_dir():
        raise WrongUse(f"There is no folder {options.answers}: --answers DIR names it.")


def gradebook(options: argparse.Namespace) -> Gradebook:
    """Return the gradebook that a command shall use, which can be reached.

    Raises:
        WrongUse: it cannot, or a password stands where everybody on the machine can read it.
    """
    from robust_slam_autograder.nbgrader import database  # it takes its time to import

    url = database.chosen(options.out, options.gradebook)
    if options.gradebook and database.has_password(url):
        raise WrongUse(
            "--gradebook holds a password, and others can read a command line: put it into "
            f"~/.pgpass or $PGPASSWORD, or the whole address into ${DATABASE_VARIABLE}."
        )
    if options.gradebook or os.environ.get(DATABASE_VARIABLE):
        who = "--gradebook" if options.gradebook else f"${DATABASE_VARIABLE}"
        if file := database.file_of(url):
            refuse_unwritable(who, file, made=options.out)
        try:
            database.exists(url)
        except GraderFailure as error:
            raise WrongUse(str(error)) from error
    return url


def warn_of_python(tree: Path, to: TextIO | None = None) -> None:
    """Say where students write in a newer Python than this one."""
    said = pythons.warning(courses.load(tree).lab)
    if said:
        print(f"note: {said}", file=to or sys.stderr)


def roster(options: argparse.Namespace) -> tuple[Roster, tuple[Row, ...], int]:
    """Return the roster, the lines of its students, and the column that names their folders.

    Raises:
        WrongUse: it cannot be read, or there is no such column, or no student.
    """
    system = systems.SYSTEMS[options.format]
    people = rosters.read(options.roster)
    students = system.students(people)
    if not students:
        raise WrongUse(f"{options.roster} has no student: export the gradebook again.")
    return people, students, people.column(options.match or system.match, "--match")


def by_hand(options: argparse.Namespace) -> Callable[[str], Entered]:
    """Return what tells by assignment which marks people entered in the gradebook.

    Of an assignment that the source tree does not have any more nothing is told.

    Raises:
        WrongUse: the gradebook cannot be reached.
    """
    from robust_slam_autograder.nbgrader import marks_by_hand  # it takes its time to import

    location = gradebook(options)

    @functools.cache
    def entered(name: str) -> Entered:
        if not (options.solutions / name).is_dir():
            return Entered()
        return marks_by_hand.read(location, assignments.of(options.solutions, name))

    return entered


def target(options: argparse.Namespace, name: str) -> Path:
    """Return the file of ``--to``, by default one of this name in the class's folder.

    Raises:
        WrongUse: it cannot be written, or it is the roster itself.
    """
    to: Path = options.to or layout.CLASS / name
    refuse_unwritable("--to", to, made=layout.CLASS)
    if to.exists() and options.roster.exists() and to.samefile(options.roster):
        raise WrongUse(f"--to {to} is the roster itself: name another file.")
    return to


def refuse_unwritable(option: str, path: Path, *, made: Path | None = None) -> None:
    """Refuse a place that no file can be written to.

    Args:
        option: who names it, as on the command line.
        path: the file to write.
        made: a folder that the command makes itself before it writes.

    Raises:
        WrongUse: its folder is missing or closed, or it is a folder itself.
    """
    folder = path.parent
    if path.is_dir():
        raise WrongUse(f"{option} {path} is a folder: name a file in it.")
    if made is not None and folder.resolve() == made.resolve():
        return
    if not folder.is_dir():
        raise WrongUse(
            f"There is no folder {folder} for {option} {path}: make it, or correct the path."
        )
    if not os.access(path if path.exists() else folder, os.W_OK):
        raise WrongUse(f"{option} {path} cannot be written: make it writable, or name another.")


def write_page(path: Path, text: str) -> None:
    """Write a page into the folder that ``--to`` names.

    Raises:
        GraderFailure: it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise GraderFailure(
            f"{path} cannot be written ({error.strerror}): "
            "make room or make its folder writable, or choose another with --to DIR."
        ) from error
