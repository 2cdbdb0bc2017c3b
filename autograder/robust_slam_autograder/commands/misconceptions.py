"""``autograder misconceptions``: find out how answers can be wrong, to name it."""

import argparse
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.misconceptions import survey, tables
from robust_slam_autograder.misconceptions.tables import Known, Table
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import labelled
from robust_slam_autograder.reading.labelled import Answer


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    places.add(parser, "names", "--answers")
    parser.add_argument("--to", type=Path, default=layout.MISCONCEPTIONS, metavar="DIR")


def run(options: argparse.Namespace) -> int:
    """Find out; an assignment whose tests and answers have not changed keeps its file."""
    places.refuse_no_answers(options)
    for name in assignments.find_names(options.solutions, options.names):
        assignment = assignments.of(options.solutions, name)
        answers = _answers(options.answers, name)
        before = tables.read_made(options.to, assignment.path)
        if before is not None and before.answers == tables.digest_of_answers(answers):
            print(f"{name}: unchanged")
            continue
        found: dict[str, Table] = {}
        for exercise in assignment.exercises:
            found[exercise] = survey.survey(assignment, exercise, answers)
            count = sum(map(bool, found[exercise].values()))
            print(f"{name}, {exercise}: {count} ways to be wrong", flush=True)
        digests = tables.digest(assignment.path), tables.digest_of_answers(answers)
        tables.write_made(options.to, assignment.path, Known(*digests, found))
    return 0


def _answers(folder: Path | None, name: str) -> list[Answer]:
    """Return an assignment's answers, right and wrong; none without a folder."""
    files = [] if folder is None else labelled.files(folder / name)
    try:
        return [one for path in files for one in labelled.read(path)]
    except ValueError as error:
        raise WrongUse(str(error)) from error
