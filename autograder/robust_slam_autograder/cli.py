"""The command line, ``autograder COMMAND``: what each command does stands in ``commands``."""

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import metadata
from pathlib import Path

from robust_slam_autograder.commands import declare
from robust_slam_autograder.errors import AutograderError, WrongUse
from robust_slam_autograder.markup import log_line

# nbgrader imports jsonschema, which then makes forty parsers of addresses that nothing here uses:
# more than a second. Without this package it goes on without them.
sys.modules.setdefault("rfc3987_syntax", None)  # type: ignore[arg-type]

DISTRIBUTION = "robust-slam-autograder"
GRADING = (
    "alembic",
    "copydetect",
    "jinja2",
    "markupsafe",
    "nbgrader",
    "sqlalchemy",
    "tqdm",
    "traitlets",
    "yaml",
)
"""Modules that the extra ``grading`` installs."""
HOW_TO_GRADE = 'this command needs pip install "./autograder[grading]", where that folder is.'


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit status: 0, 1 or 2 as the README says."""
    given = sys.argv[1:] if arguments is None else arguments
    options = _parser(given).parse_args(given)
    try:
        status = int(options.run(options))
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # The reader has enough; and Python is not to say so again when it ends.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except WrongUse as error:
        print(f"autograder: {log_line(str(error))}", file=sys.stderr)
        return 2
    except (AutograderError, OSError) as error:
        print(f"autograder: {log_line(str(error))}", file=sys.stderr)
        return 1
    except ModuleNotFoundError as error:
        if error.name is None or error.name.split(".")[0] not in GRADING:
            raise
        print(f"autograder: {error.name} is missing: {HOW_TO_GRADE}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("autograder: stopped; the same command goes on from here.", file=sys.stderr)
        return 1


def _parser(given: Sequence[str]) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="autograder", description="Makes, checks and grades nbgrader notebooks."
    )
    parser.add_argument(
        "--solutions",
        type=Path,
        default=Path("solutions"),
        metavar="DIR",
        help="the instructor's source tree",
    )
    parser.add_argument("--version", action="version", version=f"autograder {_version()}")
    declare(parser.add_subparsers(required=True, metavar="COMMAND"), given)
    return parser


def _version() -> str:
    try:
        return metadata.version(DISTRIBUTION)
    except metadata.PackageNotFoundError:  # run from its sources
        return "(not installed)"


if __name__ == "__main__":
    sys.exit(main())
