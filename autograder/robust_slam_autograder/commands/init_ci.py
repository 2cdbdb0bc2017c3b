"""``autograder init-ci``: write files for GitHub, GitLab or Gradescope."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.ci import container, workflows
from robust_slam_autograder.commands import places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.publishing import course as courses
from robust_slam_autograder.publishing.course import Course
from robust_slam_autograder.reading import assignment as assignments

GRADESCOPE = "gradescope"
TARGETS = (*workflows.WORKFLOWS, GRADESCOPE)


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("target", choices=TARGETS, metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help=f"assignments, for {GRADESCOPE}; all where none"
    )
    parser.add_argument(
        "--out",
        type=Path,
        metavar="DIR",
        help=f"the repository's folder (default .), or {GRADESCOPE}'s (class/gradescope)",
    )
    parser.add_argument(
        "--install",
        action="append",
        default=[],
        metavar="WHAT",
        help="what students install, as pip takes it; default: from the public repository",
    )
    places.add(parser, "--misconceptions")
    parser.add_argument("--force", action="store_true", help="replace files that are there")


def run(options: argparse.Namespace) -> int:
    """Write them, and say what to do next."""
    course = courses.load(options.solutions)
    if options.target == GRADESCOPE:
        return _write_archives(course, options)
    if options.names:
        raise WrongUse(f"{options.target} is for all assignments: leave out {options.names[0]}.")
    workflow = workflows.WORKFLOWS[options.target]
    path = (options.out or Path()) / workflow.place
    _refuse_there([path], force=options.force)
    text = workflows.fill(options.target, course, options.install)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    print(f"wrote {path}\nNext: {workflow.then}")
    return 0


def _write_archives(course: Course, options: argparse.Namespace) -> int:
    if options.install:
        raise WrongUse(f"{GRADESCOPE} installs the course's own packages: leave out --install.")
    names = assignments.find_names(options.solutions, options.names)
    out = options.out or layout.GRADESCOPE
    archives = {name: out / f"{name}.zip" for name in names}
    _refuse_there(list(archives.values()), force=options.force)
    container.refuse_in_sight(archives.values())
    out.mkdir(parents=True, exist_ok=True)
    for name, path in archives.items():
        container.write(course, name, path, options.misconceptions)
        print(f"wrote {path}")
    print(
        "Next: upload each under Configure Autograder, and test it there with a submission before "
        "students come.\nAn archive holds hidden tests and answers: give it to no one else."
    )
    return 0


def _refuse_there(paths: Sequence[Path], *, force: bool) -> None:
    there = [path for path in paths if path.exists()]
    if there and not force:
        raise WrongUse(
            f"{there[0]} is there already: --force replaces it, --out DIR is elsewhere."
        )
