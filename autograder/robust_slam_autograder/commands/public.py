"""``autograder public``: write the course as the public may have it."""

import argparse
from pathlib import Path


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--out", type=Path, default=Path("build/public"), metavar="DIR")


def run(options: argparse.Namespace) -> int:
    """Write it."""
    # nbgrader takes a second to import
    from robust_slam_autograder.publishing.public import publish

    written = publish(options.solutions, options.out)
    print(f"public course of {len(written)} files: {options.out}")
    return 0
