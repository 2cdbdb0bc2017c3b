"""The command line: ``autograder release | check | grade``."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from tqdm import tqdm

from robust_slam_autograder import assignment as assignments
from robust_slam_autograder import batch, grading, notebook, report, sandbox, submission
from robust_slam_autograder.batch import Graded, Job
from robust_slam_autograder.errors import AutograderError, Refused, WrongUse


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command and return its exit status: 0, 1 or 2 as the README says."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except WrongUse as error:
        print(f"autograder: {error}", file=sys.stderr)
        return 2
    except AutograderError as error:
        print(f"autograder: {error}", file=sys.stderr)
        return 1


def _parser() -> argparse.ArgumentParser:
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
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    make = commands.add_parser("release", help="make the student release")
    make.add_argument("names", nargs="*", metavar="NAME", help="assignments; all where none")
    make.add_argument("--out", type=Path, default=Path("build/release"), metavar="DIR")
    make.set_defaults(run=_release)

    check = commands.add_parser("check", help="run the visible tests of your own notebook")
    check.add_argument("notebook", type=Path, metavar="NOTEBOOK")
    check.add_argument(
        "--release", type=Path, metavar="DIR", help="take the tests from the release in DIR"
    )
    check.set_defaults(run=_check)

    grade = commands.add_parser("grade", help="grade submissions, hidden tests included")
    grade.add_argument("paths", nargs="+", type=Path, metavar="PATH")
    grade.add_argument("--assignment", metavar="NAME")
    grade.add_argument("--student", metavar="NAME")
    grade.add_argument("--out", type=Path, default=Path("build/graded"), metavar="DIR")
    grade.add_argument("--seed", type=_seed, metavar="N", help="default: the batch's own, secret")
    grade.add_argument("--jobs", type=_jobs, default=os.cpu_count() or 1, metavar="N")
    grade.add_argument(
        "--unsandboxed", action="store_true", help="trust the submissions: run them without a wall"
    )
    grade.set_defaults(run=_grade)
    return parser


def _seed(text: str) -> int:
    value = int(text)
    if value < 0:
        raise argparse.ArgumentTypeError("a seed is a whole number, 0 or more")
    return value


def _jobs(text: str) -> int:
    value = int(text)
    if value < 1:
        raise argparse.ArgumentTypeError("at least one job")
    return value


def _release(options: argparse.Namespace) -> int:
    from robust_slam_autograder.release import release  # nbgrader takes a second to import

    for path in release(options.solutions, options.names, options.out):
        print(f"released {path}")
    return 0


def _check(options: argparse.Namespace) -> int:
    path: Path = options.notebook
    try:
        cells = notebook.read(path)
    except Refused as error:
        raise WrongUse(str(error)) from error
    if options.release is None:
        config = assignments.load_config(path.parent / assignments.CONFIG_NAME)
        tests = assignments.from_cells(path.stem, cells, config)
        print(f"Tests: those in {path} itself; --release DIR takes the original ones.")
    else:
        original = _released(options.release, path)
        tests = assignments.load(original)
        print(f"Tests: those of {original}.")
    code = submission.collect(cells, tests)
    result = grading.check(tests, code, sandbox=sandbox.choose(unsandboxed=True))
    print(report.check_report(result))
    return 0 if result.score == result.max_score else 1


def _released(folder: Path, path: Path) -> Path:
    for name in (path.stem, path.resolve().parent.name):
        if (folder / name).is_dir():
            return assignments.notebook_path(folder / name)
    raise WrongUse(f"{folder} has no release for {path.name}: name the notebook as it was.")


def _grade(options: argparse.Namespace) -> int:
    wall = sandbox.choose(unsandboxed=options.unsandboxed)
    jobs = _find_jobs(options)
    with tqdm(total=len(jobs), unit="submission", disable=not sys.stderr.isatty()) as bar:

        def tell(graded: Graded) -> None:
            bar.set_postfix_str(graded.result.student)
            bar.update()

        graded = batch.grade(
            jobs,
            out=options.out,
            seed=options.seed,
            sandbox=wall,
            workers=options.jobs,
            report=tell,
        )
    _record(options.out, jobs, graded)
    print(report.marks_table([item.result for item in graded]))
    _print_summary(options.out, graded)
    return 1 if any(item.result.status == "failed" for item in graded) else 0


def _record(out: Path, jobs: Sequence[Job], graded: Sequence[Graded]) -> None:
    from robust_slam_autograder import gradebook  # nbgrader takes a second to import

    database = out / gradebook.DATABASE_NAME
    if all(item.reused for item in graded) and database.exists():
        return
    used = {job.assignment.name: job.assignment for job in jobs}
    gradebook.record(database, list(used.values()), [item.result for item in graded])


def _print_summary(out: Path, graded: Sequence[Graded]) -> None:
    counts = batch.counts(graded)
    kept = f", {counts['kept']} of them unchanged and reused" if counts["kept"] else ""
    print(
        f"{counts['graded']} graded, {counts['refused']} refused, "
        f"{counts['failed']} failed{kept}. Results and gradebook: {out}"
    )


def _find_jobs(options: argparse.Namespace) -> list[Job]:
    names = assignments.find_names(options.solutions)
    loaded: dict[str, Job] = {}
    jobs = []
    for path in options.paths:
        student, name = _student_and_assignment(path, names, options)
        if name not in loaded:
            tests = assignments.notebook_path(options.solutions / name)
            loaded[name] = Job("", assignments.load(tests), tests, path)
        jobs.append(Job(student, loaded[name].assignment, loaded[name].tests, path))
    keys = [job.key for job in jobs]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice:
        raise WrongUse(f"{twice} is named twice: hand each submission over once.")
    return jobs


def _student_and_assignment(
    path: Path, names: Sequence[str], options: argparse.Namespace
) -> tuple[str, str]:
    """Whose submission a path is and of what, from the options or from the path's own parts."""
    full = Path(os.path.abspath(path))  # not resolve(): a link must not choose the student
    if not os.path.lexists(full):
        raise WrongUse(f"{path} does not exist.")
    is_folder = full.is_dir()
    student = options.student or (full.parent.name if is_folder else full.stem)
    guesses = [full.name] if is_folder else [full.stem, full.parent.name]
    name = options.assignment or next((guess for guess in guesses if guess in names), None)
    if name is None and len(names) == 1:
        name = names[0]
    if name is None:
        raise WrongUse(f"{path} does not say its assignment: add --assignment NAME.")
    if name not in names:
        raise WrongUse(f"There is no assignment {name}; there are {', '.join(names)}.")
    if student.startswith(".") or "/" in student or not student.isprintable():
        raise WrongUse(f"{student!r} is no name for a student: use --student NAME.")
    return student, name


if __name__ == "__main__":
    sys.exit(main())
