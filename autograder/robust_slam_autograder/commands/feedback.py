"""``autograder feedback``: make a page per submission for its student."""

import argparse
import re
from collections.abc import Sequence
from functools import cache
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import results
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reports import feedback

_SCHEME = re.compile(r"[a-zA-Z][a-zA-Z0-9+.-]*:")


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("students", nargs="*", metavar="STUDENT", help="all where none")
    places.add(parser, "--out", "--gradebook", "--notice")
    parser.add_argument("--to", type=Path, default=layout.FEEDBACK, metavar="DIR")
    parser.add_argument(
        "--site",
        type=_site,
        default="",
        metavar="URL",
        help="the built book's address, or its path from a page; else chapters are named only",
    )


def _site(text: str) -> str:
    scheme = _SCHEME.match(text)
    if scheme and scheme.group().lower() not in ("http:", "https:", "file:"):
        raise argparse.ArgumentTypeError("an address https://…, or a path such as ../../html")
    return text


def run(options: argparse.Namespace) -> int:
    """Write the pages."""
    layout.refuse_unmoved(options.out)
    assignments.find_names(options.solutions)
    paths = _results(options.out, options.students)
    config = cache(
        lambda name: assignments.load_config(options.solutions / name / assignments.CONFIG_NAME)
    )
    marks = places.by_hand(options)
    for path in paths:
        result = results.read_checked(path)
        entries = marks(result.assignment).of(result.student)
        page = feedback.page(result, config(result.assignment), options.site, entries)
        folder = options.to / path.parent.name
        places.write_page(folder / f"{path.stem}.html", feedback.html(page, options.notice))
        places.write_page(folder / f"{path.stem}.md", feedback.markdown(page))
    students = len({path.parent for path in paths})
    print(f"feedback on {len(paths)} submissions of {students} students: {options.to}")
    return 0


def _results(out: Path, students: Sequence[str]) -> list[Path]:
    paths = results.listed(out)
    known = {path.parent.name for path in paths}
    for student in students:
        if student not in known:
            raise WrongUse(f"{out} holds no result of {student}: grade that submission first.")
    return [path for path in paths if not students or path.parent.name in students]
