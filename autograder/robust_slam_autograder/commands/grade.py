"""``autograder grade``: grade submissions, hidden tests included."""

import argparse
import contextlib
import functools
import importlib
import os
import sys
import threading
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import places, submissions
from robust_slam_autograder.commands.submissions import Places
from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.executor.dask_workers import connected
from robust_slam_autograder.grading import batch, durable, exposed_folders, progress, remote
from robust_slam_autograder.grading.batch import Graded, How
from robust_slam_autograder.grading.journal import Journal, open_journal
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.markup import log_line
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.reading import submission
from robust_slam_autograder.reports import summary, terminal
from robust_slam_autograder.sandbox import BACK_ENDS, choose

STANDARD_OUTPUT = "-"


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("paths", nargs="+", type=Path, metavar="PATH")
    parser.add_argument("--assignment", metavar="NAME")
    parser.add_argument("--student", metavar="NAME")
    places.add(parser, "--out", "--gradebook", "--misconceptions")
    parser.add_argument("--seed", type=_seed, metavar="N", help="default: the batch's own, secret")
    add_how(parser)
    parser.add_argument(
        "--json", metavar="FILE", help="also write the marks as JSON; - is standard output"
    )
    parser.add_argument("--markdown", metavar="FILE", help="also write them as a Markdown table")
    parser.add_argument(
        "--no-names", action="store_true", help="leave students out of all that is shown"
    )


def add_how(parser: argparse.ArgumentParser) -> None:
    """Declare how student code is run: where, how many at once, and behind which wall."""
    processors = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    parser.add_argument("--jobs", type=_jobs, default=processors, metavar="N")
    parser.add_argument(
        "--scheduler", metavar="ADDRESS", help="grade on a Dask cluster, say tcp://HOST:8786"
    )
    parser.add_argument(
        "--sandbox", choices=list(BACK_ENDS), help="default: the first that works here"
    )
    parser.add_argument(
        "--unsandboxed", action="store_true", help="trust the submissions: run them without a wall"
    )


def _seed(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError("a seed is a whole number, 0 or more")
    return int(text)


def _jobs(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError("a whole number, 1 or more")
    return int(text)


def run(options: argparse.Namespace) -> int:
    """Grade the batch; exit status 1 where the grader itself failed on a submission."""
    from robust_slam_autograder.nbgrader import recording  # the student's install lacks nbgrader

    _refuse_unwritable(options)
    gradebook = places.gradebook(options)
    handed_in = _find(options, gradebook)
    _warn(handed_in, options)
    with chosen(handed_in, options) as how, batch.locked(options.out):
        journal = open_journal(options.out, options.seed)
        graded = _grade(handed_in, journal, how)
        marks = [item.load() for item in graded]
        recording.record_new(gradebook, journal, handed_in, marks, how.sandbox)
    _tell(graded, marks, gradebook, options)
    return 1 if any(item.status == "failed" for item in graded) else 0


def _refuse_unwritable(options: argparse.Namespace) -> None:
    if options.json is not None and options.json == options.markdown:
        raise WrongUse("--json and --markdown want two places: - can be one of them.")
    for option, target in {"--json": options.json, "--markdown": options.markdown}.items():
        if target not in (None, STANDARD_OUTPUT):
            places.refuse_unwritable(option, Path(target), made=options.out)
    layout.refuse_unmoved(options.out)


def _warn(handed_in: Sequence[Submission], options: argparse.Namespace) -> None:
    places.warn_of_python(options.solutions)
    _warn_of_look_alikes(handed_in, names=not options.no_names)
    _warn_of_old_labels(handed_in, options.misconceptions)


@contextlib.contextmanager
def chosen(handed_in: Sequence[Submission], options: argparse.Namespace) -> Iterator[How]:
    """Yield how to grade, on this machine or on a cluster, as long as its workers are wanted.

    Raises:
        WrongUse: student code could read what it must not, no sandbox works, a package that is
            allowed is not installed, or the scheduler cannot be used.
    """
    sandbox = choose(options.sandbox, unsandboxed=options.unsandboxed)
    kept = [options.misconceptions] if options.misconceptions.is_dir() else []
    folders = [options.solutions, options.out, *kept, *map(_folder_of_students, handed_in)]
    exposed_folders.refuse_unsafe([one.assignment for one in handed_in], folders, sandbox)
    here = How(sandbox, tables.namer(options.misconceptions), workers=options.jobs)
    if options.scheduler is None:
        yield here
        return
    with connected(options.scheduler) as workers:
        # A cluster has as many places as it has workers.
        there = functools.partial(remote.grade, workers)
        yield replace(here, graders=there, workers=sys.maxsize)


def _grade(handed_in: Sequence[Submission], journal: Journal, how: How) -> list[Graded]:
    if any(one.key not in journal.graded for one in handed_in):
        # nbgrader takes two seconds to import: meanwhile submissions are being graded.
        wanted = ("robust_slam_autograder.nbgrader.gradebook",)
        threading.Thread(target=importlib.import_module, args=wanted, daemon=True).start()
    with progress.shown(len(handed_in)) as step:
        return batch.grade(handed_in, journal, how, lambda graded: step())


def _warn_of_old_labels(jobs: Sequence[Submission], folder: Path) -> None:
    """Say where labels were made for other tests, and none are given."""
    for tests in sorted({job.assignment.path for job in jobs}):
        made = tables.made_of(folder, tests)
        if made.is_file() and tables.read_made(folder, tests) is None:
            print(
                f"note: {made.stem} has other tests than when its misconceptions were looked for: "
                "run autograder misconceptions again to have wrong answers named.",
                file=sys.stderr,
            )


def _folder_of_students(job: Submission) -> Path:
    """Return the folder of students' work: a student's own path may be a link to anywhere."""
    is_notebook = submission.is_notebook(job.path.name)
    return job.path.parent if is_notebook else job.path.parents[1]


def _tell(
    graded: Sequence[Graded],
    marks: Sequence[Result],
    gradebook: places.Gradebook,
    options: argparse.Namespace,
) -> None:
    """Write the summaries, and the table for people."""
    names = not options.no_names
    wanted = {options.json: summary.as_json, options.markdown: summary.as_markdown}
    for target, render in wanted.items():
        if target is not None:
            write(target, render(marks, batch.counts(graded), names=names))
    # Where a summary goes to standard output it has that for itself.
    people = sys.stderr if STANDARD_OUTPUT in wanted else sys.stdout
    print(terminal.marks_table(marks, names=names), file=people)
    from robust_slam_autograder.nbgrader import database

    where = f"Results: {options.out}. Gradebook: {database.shown(gradebook)}"
    print(f"{_counts(graded)} {where}", file=people)


def write(target: str, text: str) -> None:
    """Write to a file, or to standard output where the target is ``-``."""
    if target == STANDARD_OUTPUT:
        sys.stdout.write(text)
        return
    with durable.explained(Path(target)):
        Path(target).write_text(text, encoding="utf-8")


def _counts(graded: Sequence[Graded]) -> str:
    counts = batch.counts(graded)
    kept = f", {counts['kept']} of them unchanged and reused" if counts["kept"] else ""
    return (
        f"{counts['graded']} graded, {counts['refused']} refused, {counts['failed']} failed{kept}."
    )


def _find(options: argparse.Namespace, gradebook: places.Gradebook) -> list[Submission]:
    # Not resolve(): a link must not choose the student.
    paths = list(dict.fromkeys(Path(os.path.abspath(path)) for path in options.paths))
    for path in submissions.missing(paths):
        raise WrongUse(f"{_said(path, paths, options)} does not exist.")
    reader = submissions.Reader(
        assignments.find_names(options.solutions),
        options.assignment,
        options.student,
        _taken(options, gradebook),
    )
    if options.assignment is not None:
        assignments.find_names(options.solutions, [options.assignment])
    claims, strays = reader.read(paths)
    sentences = [f"{_said(stray.path, paths, options)} {stray.why}" for stray in strays]
    if sentences and not claims:
        raise WrongUse(sentences[0])
    for sentence in sentences:
        print(f"left out: {sentence}", file=sys.stderr)
    of = functools.cache(functools.partial(assignments.of, options.solutions))
    return [Submission(claim.student, of(claim.assignment), claim.path) for claim in claims]


def _said(path: Path, paths: Sequence[Path], options: argparse.Namespace) -> str:
    """Return a path in a message; its number where it may name a student."""
    if options.no_names:
        return f"path {paths.index(path) + 1} of {len(paths)}"
    return log_line(str(path))


def _taken(options: argparse.Namespace, gradebook: places.Gradebook) -> Places:
    """Look at what is in the results' folder, or will be when the batch has ended."""
    from robust_slam_autograder.nbgrader import database

    out: Path = options.out.absolute()
    targets = [database.file_of(gradebook), options.json, options.markdown]
    files = [Path(target).absolute() for target in targets if target is not None]
    own = {file.name for file in files if file.parent == out}
    there = list(out.iterdir()) if out.is_dir() else []
    folders = {path.name for path in there if path.is_dir() and not path.is_symlink()}
    return Places(folders, {path.name for path in there} - folders - own, own)


def _warn_of_look_alikes(jobs: Sequence[Submission], *, names: bool) -> None:
    for group in submission.look_alike(job.student for job in jobs):
        # ascii(): as text no one could tell one from the other.
        who = " and ".join(map(ascii, group)) if names else f"{len(group)} students' names"
        print(
            f"note: {who} look alike and are graded apart: name them alike if they are one.",
            file=sys.stderr,
        )
