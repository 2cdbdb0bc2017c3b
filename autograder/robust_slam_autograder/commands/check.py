"""``autograder check``: run the visible tests of your own notebook."""

import argparse
from pathlib import Path

from robust_slam_autograder import self_check
from robust_slam_autograder.commands import places
from robust_slam_autograder.reports import summary


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("notebook", type=Path, metavar="NOTEBOOK")
    parser.add_argument(
        "--release", type=Path, metavar="DIR", help="where the unpacked zip is, or several are"
    )
    parser.add_argument(
        "--markdown", type=Path, metavar="FILE", help="also write what passed, as Markdown"
    )
    parser.add_argument(
        "--hints",
        type=int,
        default=0,
        choices=range(4),
        help="how many hints for what does not pass: where to look, what to compute, the idea",
    )


def run(options: argparse.Namespace) -> int:
    """Check it; exit status 1 where a test does not pass."""
    if options.markdown is not None:
        places.refuse_unwritable("--markdown", options.markdown)
    result, tests = self_check.run(options.notebook, options.release, options.hints)
    if options.markdown is not None:
        text = summary.check_as_markdown(result, tests.hidden_cases)
        options.markdown.write_text(text, encoding="utf-8")
    return 0 if result.score == result.max_score else 1
