"""``autograder mark``: add or take points by hand, with the reason."""

import argparse
import math

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.grading.results import tidy
from robust_slam_autograder.markup import one_line
from robust_slam_autograder.reading import assignment as assignments


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("student", metavar="STUDENT")
    parser.add_argument("assignment", metavar="ASSIGNMENT")
    parser.add_argument("exercise", metavar="EXERCISE")
    parser.add_argument(
        "points",
        type=_points,
        metavar="POINTS",
        help="beside those of the tests, as +2 or -1, in place of an earlier mark by hand; "
        "0 takes that back",
    )
    parser.add_argument(
        "--reason", default="", metavar="TEXT", help="one sentence, which the student reads"
    )
    places.add(parser, "--out", "--gradebook")


def _points(text: str) -> float:
    try:
        points = float(text)
    except ValueError:
        points = math.nan
    if not math.isfinite(points):
        raise argparse.ArgumentTypeError(f"points are a number, as +2 or -1, not {text!r}")
    return tidy(points)


def run(options: argparse.Namespace) -> int:
    """Enter the points in the gradebook."""
    layout.refuse_unmoved(options.out)
    from robust_slam_autograder.nbgrader import marks_by_hand  # the student's install lacks it

    (name,) = assignments.find_names(options.solutions, [options.assignment])
    change = marks_by_hand.enter(
        places.gradebook(options),
        assignments.of(options.solutions, name),
        student=options.student,
        exercise=options.exercise,
        points=options.points,
        reason=options.reason,
    )
    now = tidy(change.by_tests + change.after)
    replaced = f", in place of {tidy(change.before):+}" if change.before else ""
    print(
        f"{one_line(options.student)}/{name}, {options.exercise}: {tidy(change.by_tests)} by the "
        f"tests, {change.after:+} by hand{replaced}: {now}/{tidy(change.max_score)} points. "
        f"The assignment has {change.total}/{change.total_max}. "
        "`autograder feedback` and `report` bring the pages up to date."
    )
    return 0
