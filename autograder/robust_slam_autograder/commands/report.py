"""``autograder report``: for the instructor, pages of assignments and students, and an index."""

from __future__ import annotations

import argparse
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.grading import results
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reports import class_pages, class_report, heat_map
from robust_slam_autograder.reports.class_pages import Entry
from robust_slam_autograder.reports.class_report import Report, Source
from robust_slam_autograder.reports.heat_map import STUDENTS, Column

INDEX = "index.html"


def add(commands: Any) -> None:  # noqa: ANN401
    """Declare the command."""
    parser = commands.add_parser("report", help="make a page per assignment for the instructor")
    parser.add_argument(
        "assignments", nargs="*", metavar="ASSIGNMENT", help="pages of these; all where none"
    )
    places.add_out(parser)
    parser.add_argument("--to", type=Path, default=layout.REPORT, metavar="DIR")
    parser.add_argument(
        "--feedback",
        type=Path,
        default=layout.FEEDBACK,
        metavar="DIR",
        help="the students' pages; names link to those that are there",
    )
    parser.add_argument(
        "--no-names", action="store_true", help="leave students and their own words out"
    )
    places.add_notice(parser, "in place of the warning not to publish it")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Write the pages; of assignments that are not named, the index alone is made anew."""
    layout.refuse_unmoved(options.out)
    found = _results(options.out, options.assignments)
    students = frozenset(path.parent.name for paths in found.values() for path in paths)
    entries: list[Entry] = []
    columns: list[Column] = []
    files: dict[str, str] = {}
    for name, paths in found.items():
        source = _source(name, paths, students, options)
        report = class_report.report(source)
        page = options.to / f"{name}.html"
        if not options.assignments or name in options.assignments:
            places.write_page(page, class_pages.html(report, options.notice))
            entries.append(Entry(report, quote(page.name)))
        else:
            entries.append(_entry_of_before(report, page))
        for path, result in zip(paths, source.results, strict=True):
            files[result.student] = f"{path.parent.name}.html"
        feedback = _links(paths, source.results, options, options.to / STUDENTS)
        columns.append(Column(source, entries[-1].address, feedback))
    _write_students_and_index(entries, columns, files, options)
    pages = len(options.assignments or found)
    print(f"report on {pages} of {len(found)} assignments: {options.to / INDEX}")
    return 0


def _write_students_and_index(
    entries: Sequence[Entry],
    columns: Sequence[Column],
    files: Mapping[str, str],
    options: argparse.Namespace,
) -> None:
    chart = heat_map.heat_map(columns, files)
    for row in chart.rows:
        if row.file:
            places.write_page(
                options.to / STUDENTS / row.file, class_pages.student(row, options.notice)
            )
    index = class_pages.index(entries, chart, names=not options.no_names, notice=options.notice)
    places.write_page(options.to / INDEX, index)


def _entry_of_before(report: Report, page: Path) -> Entry:
    """Return an assignment whose page is as it was; that one may hold names."""
    return Entry(report, quote(page.name) if report.names and page.is_file() else "")


def _results(out: Path, wanted: Sequence[str]) -> dict[str, list[Path]]:
    """Return the result files of each assignment."""
    found: dict[str, list[Path]] = {}
    for path in sorted(results.listed(out), key=lambda path: (path.stem, path)):
        found.setdefault(path.stem, []).append(path)
    if Path(INDEX).stem in found:
        raise WrongUse(f"An assignment named index would take the place of {INDEX}: name it anew.")
    for name in wanted:
        if name not in found:
            raise WrongUse(f"{out} holds no result of {name}; there are {', '.join(found)}.")
    return found


def _source(
    name: str, paths: Sequence[Path], students: frozenset[str], options: argparse.Namespace
) -> Source:
    marks = [results.read_checked(path) for path in paths]
    config = assignments.load_config(options.solutions / name / assignments.CONFIG_NAME)
    return Source(
        assignment=name,
        title=config.title,
        results=marks,
        names=not options.no_names,
        links=_links(paths, marks, options, options.to),
        students=students,
    )


def _links(
    paths: Sequence[Path], marks: Sequence[Result], options: argparse.Namespace, start: Path
) -> Mapping[str, str]:
    """Return by student, the address of the feedback page from a page in ``start``."""
    links: dict[str, str] = {}
    for path, result in zip(paths, marks, strict=True):
        page = options.feedback / path.parent.name / f"{path.stem}.html"
        if page.is_file() and not options.no_names:
            links[result.student] = _address(os.path.relpath(page, start))
    return links


def _address(path: str) -> str:
    return quote(os.fsencode(path))
