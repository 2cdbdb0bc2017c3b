"""``autograder release``: the student release, of each assignment a folder and an archive."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from robust_slam_autograder.commands import places


def add(commands: Any) -> None:  # noqa: ANN401
    """Declare the command."""
    parser = commands.add_parser("release", help="make the student release")
    places.add(parser, "names")
    parser.add_argument("--out", type=Path, default=Path("build/release"), metavar="DIR")
    places.add(parser, "--misconceptions")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Make it."""
    from robust_slam_autograder.publishing.student_release import release

    for path in release(
        options.solutions, options.names, options.out, misconceptions=options.misconceptions
    ):
        print(f"released {path} ({path.parent}.zip)")
    return 0
