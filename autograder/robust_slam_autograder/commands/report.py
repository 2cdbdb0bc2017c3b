"""``autograder report``: make a page per assignment for the instructor."""

import argparse
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from urllib.parse import quote

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import Refused, WrongUse
from robust_slam_autograder.grading import results, submissions
from robust_slam_autograder.grading.entered_by_hand import Entered
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.lms import marking
from robust_slam_autograder.lms.marking import Marking
from robust_slam_autograder.markup import visible
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import notebook, submission
from robust_slam_autograder.reports import class_pages, class_report, heat_map, similar
from robust_slam_autograder.reports.class_report import Source
from robust_slam_autograder.reports.misunderstood import Code
from robust_slam_autograder.reports.similar import Alike

INDEX = "index.html"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument(
        "assignments", nargs="*", metavar="ASSIGNMENT", help="pages of these; all where none"
    )
    places.add(parser, "--out", "--gradebook", "--notice")
    parser.add_argument("--to", type=Path, default=layout.REPORT, metavar="DIR")
    parser.add_argument(
        "--feedback",
        type=Path,
        default=layout.FEEDBACK,
        metavar="DIR",
        help="the students' pages; names link to those that are there",
    )
    parser.add_argument(
        "--marking",
        type=Path,
        metavar="FILE",
        help=f"who marks whom, and students' questions; default: {marking.NAME} beside --out",
    )
    places.add(parser, "--submitted")
    parser.add_argument(
        "--similar",
        action="store_true",
        help="show answers of two students that are nearly one text, side by side",
    )
    parser.add_argument(
        "--no-names", action="store_true", help="leave students and their own words out"
    )


def run(options: argparse.Namespace) -> int:
    """Write the pages; of assignments that are not named, the index alone is made anew."""
    layout.refuse_unmoved(options.out)
    if options.similar and options.no_names:
        raise WrongUse("--similar shows whose texts are alike: it does not go with --no-names.")
    found = _results(options.out, options.assignments)
    students = frozenset(path.parent.name for paths in found.values() for path in paths)
    marks = places.by_hand(options)
    shared = _marking(found, options)
    sources = [
        _source(name, paths, students, marks(name), shared, options)
        for name, paths in found.items()
    ]
    reports = [class_report.report(source) for source in sources]
    for source, report in zip(sources, reports, strict=True):
        if _is_wanted(source.assignment, options):
            page = options.to / f"{source.assignment}.html"
            places.write_page(page, class_pages.html(report, options.notice))
    chart = heat_map.heat_map(sources)
    for row in chart.rows:
        if row.page:
            places.write_page(options.to / row.page, class_pages.student(row, options.notice))
    index = class_pages.index(reports, chart, names=not options.no_names, notice=options.notice)
    places.write_page(options.to / INDEX, index)
    pages = len(options.assignments or found)
    print(f"report on {pages} of {len(found)} assignments: {options.to / INDEX}")
    return 0


def _is_wanted(name: str, options: argparse.Namespace) -> bool:
    return not options.assignments or name in options.assignments


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


def _marking(found: dict[str, list[Path]], options: argparse.Namespace) -> Marking:
    """Read who marks whom; a class without such a file has no markers and no questions."""
    path = options.marking or options.out.parent / marking.NAME
    if options.marking is None and not path.exists():
        return Marking()
    handed_in = {name: [each.parent.name for each in paths] for name, paths in found.items()}
    return marking.load(path, handed_in)


def _alike(name: str, students: Iterable[str], options: argparse.Namespace) -> Alike:
    """Compare the answers that are in the submissions' folder now.

    Raises:
        WrongUse: the assignment or its submissions are not there.
    """
    from robust_slam_autograder.nbgrader import marked_cells  # it takes its time to import

    assignments.find_names(options.solutions, [name])
    assignment = assignments.of(options.solutions, name)
    given = marked_cells.given(assignment.marked)
    cells = [solution.grade_id for solution in assignment.solutions]
    answers: dict[str, dict[str, str]] = {cell: {} for cell in cells}
    there = False
    for student in students:
        path = options.submitted / student / name
        there = there or path.is_dir()
        for cell, text in _texts(Submission(student, assignment, path)).items():
            answers[cell][student] = text
    if not there:
        raise WrongUse(f"{options.submitted} has no submission of {name}: say --submitted DIR.")
    return similar.find(answers, {cell: given[cell].source for cell in cells})


def _texts(job: Submission) -> dict[str, str]:
    """Return by solution cell what a student wrote; nothing where the notebook is unreadable."""
    try:
        found = submission.collect(submissions.read(job).cells(), job.assignment)
    except Refused:
        return {}
    texts: dict[str, list[str]] = {}
    for piece in found.pieces:
        if piece.label != submission.OWN:
            texts.setdefault(piece.label, []).append(piece.source)
    return {cell: "\n".join(sources) for cell, sources in texts.items()}


def _source(
    name: str,
    paths: Sequence[Path],
    students: frozenset[str],
    marks: Entered,
    shared: Marking,
    options: argparse.Namespace,
) -> Source:
    config = assignments.load_config(options.solutions / name / assignments.CONFIG_NAME)
    names, page = not options.no_names, options.to / f"{name}.html"
    # A page that is as it was before may hold names.
    is_wanted = _is_wanted(name, options)
    is_there = is_wanted or (names and page.is_file())
    mine = [path.parent.name for path in paths]
    feedback = {student: options.feedback / student / f"{name}.html" for student in mine}
    return Source(
        assignment=name,
        title=config.title,
        results=[results.read_checked(path) for path in paths],
        by_hand=marks,
        names=names,
        page=quote(page.name) if is_there else "",
        links={
            student: quote(os.fsencode(os.path.relpath(path, options.to)))
            for student, path in feedback.items()
            if names and path.is_file()
        },
        students=students,
        markers=shared.markers,
        questions=shared.questions.get(name, ()),
        alike=_alike(name, mine, options) if options.similar and is_wanted else None,
        code=_code(options.submitted, name) if names else lambda student, exercise: "",
    )


def _code(submitted: Path, assignment: str) -> Code:
    """Return how to find a student's text for an exercise in what was handed in."""

    def code(student: str, exercise: str) -> str:
        folder = submitted / student / assignment
        try:
            path, _ = submission.notebook_in(folder, assignment)
            cells = notebook.read(path)
        except (Refused, OSError):
            return ""
        found = [cell.source for cell in cells if cell.grade_id == exercise]
        return visible(found[-1]) if found else ""

    return code
