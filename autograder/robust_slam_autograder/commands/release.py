"""``autograder release``: make the student release."""

import argparse
from pathlib import Path

from robust_slam_autograder.commands import places


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    places.add(parser, "names")
    parser.add_argument("--out", type=Path, default=Path("build/release"), metavar="DIR")
    places.add(parser, "--misconceptions")


def run(options: argparse.Namespace) -> int:
    """Make it."""
    from robust_slam_autograder.publishing.student_release import release

    places.warn_of_python(options.solutions)
    for path in release(
        options.solutions, options.names, options.out, misconceptions=options.misconceptions
    ):
        print(f"released {path} ({path.parent}.zip)")
    return 0
