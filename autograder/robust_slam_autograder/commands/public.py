"""``autograder public``: the course without what its instructor keeps."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any


def add(commands: Any) -> None:  # noqa: ANN401
    """Declare the command."""
    parser = commands.add_parser("public", help="write the course as the public may have it")
    parser.add_argument("--out", type=Path, default=Path("build/public"), metavar="DIR")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write it."""
    from robust_slam_autograder.publishing.public import (
        publish,  # nbgrader takes a second to import
    )

    written = publish(options.solutions, options.out)
    print(f"public course of {len(written)} files: {options.out}")
    return 0
