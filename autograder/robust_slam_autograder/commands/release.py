"""``autograder release``: the student release, of each assignment a folder and an archive."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add(commands: Any) -> None:  # noqa: ANN401
    """Declare the command."""
    parser = commands.add_parser("release", help="make the student release")
    parser.add_argument("names", nargs="*", metavar="NAME", help="assignments; all where none")
    parser.add_argument("--out", type=Path, default=Path("build/release"), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Make it."""
    from robust_slam_autograder.publishing.student_release import release

    for path in release(options.solutions, options.names, options.out):
        print(f"released {path} ({path.parent}.zip)")
    return 0
