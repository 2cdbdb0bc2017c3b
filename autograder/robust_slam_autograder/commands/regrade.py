"""``autograder regrade``: show what changed tests do to marks."""

import argparse
import sys
from pathlib import Path

from robust_slam_autograder import layout
from robust_slam_autograder.commands import grade, places
from robust_slam_autograder.grading import batch, progress, regrading
from robust_slam_autograder.grading.journal import Journal, open_journal
from robust_slam_autograder.grading.regrading import Plan, Trial
from robust_slam_autograder.reports import changes
from robust_slam_autograder.reports.changes import Regrade


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("assignment", metavar="ASSIGNMENT")
    parser.add_argument(
        "--apply", action="store_true", help="put the new marks into results and gradebook"
    )
    places.add(parser, "--submitted", "--out", "--gradebook", "--misconceptions")
    grade.add_how(parser)
    parser.add_argument(
        "--json",
        nargs="?",
        const=grade.STANDARD_OUTPUT,
        metavar="FILE",
        help="also write the changes as JSON; - or nothing is standard output",
    )


def run(options: argparse.Namespace) -> int:
    """Grade again; exit status 1 where the grader failed on a submission."""
    if options.json not in (None, grade.STANDARD_OUTPUT):
        places.refuse_unwritable("--json", Path(options.json))
    layout.refuse_unmoved(options.out)
    from robust_slam_autograder.nbgrader import recording  # the student's install lacks nbgrader

    plan = regrading.plan(
        options.solutions, options.assignment, out=options.out, submitted=options.submitted
    )
    gradebook = places.gradebook(options)
    with grade.chosen(plan.jobs, options) as how, batch.locked(options.out):
        journal = open_journal(options.out, None)
        stale = regrading.outdated(plan.jobs, journal, how.sandbox)
        with progress.shown(len(stale)) as step:
            trial = regrading.attempt(stale, journal, how, step)
        found = _compare(plan, trial, journal, gradebook, options)
        if options.apply:
            regrading.apply(trial, journal)
            jobs, standing = regrading.standing(plan.jobs, journal)
            recording.record_new(gradebook, journal, jobs, standing, how.sandbox)
            regrading.clear(journal)
    _tell(found, options)
    return 1 if found.failed else 0


def _compare(
    plan: Plan,
    trial: Trial,
    journal: Journal,
    gradebook: places.Gradebook,
    options: argparse.Namespace,
) -> Regrade:
    # nbgrader takes a second to import
    from robust_slam_autograder.nbgrader import database, totals

    again = regrading.compare(trial, options.out)
    news = [(job, result) for job, result in trial.results() if result.status != "failed"]
    news += regrading.unrecorded(plan.jobs, trial, journal, database.recorded(gradebook))
    return changes.Regrade(
        options.assignment,
        again,
        kept=len(plan.jobs) - len(trial.jobs),
        failed=[job.student for job, result in trial.results() if result.status == "failed"],
        left_out=plan.left_out,
        effects=totals.effects(gradebook, options.assignment, news),
        applied=options.apply,
    )


def _tell(found: Regrade, options: argparse.Namespace) -> None:
    if options.json is not None:
        grade.write(options.json, changes.as_json(found))
    people = sys.stderr if options.json == grade.STANDARD_OUTPUT else sys.stdout
    print(changes.table(found), file=people)
