"""The command: ``python -m tests.assignments.mutation [NAME…] [--jobs 2] [--seed N]``.

NAME is an assignment, or ASSIGNMENT/EXERCISE; all assignments if none is given. Exit status 0: of
the mutants that were not judged equivalent at least 95 % are killed, and at most 10 % are judged
so, in each assignment. 1: not so. 2: an entry of equivalents.toml is stale, or the reference
itself loses marks.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from robust_slam_autograder.errors import AutograderError
from tqdm import tqdm

from solutions.classes import answers
from tests.assignments.mutation import equivalents, run
from tests.assignments.mutation.report import Report


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; give its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.assignments.mutation", description=__doc__.partition("\n")[0]
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="ASSIGNMENT[/EXERCISE]")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at once (default 2)")
    parser.add_argument("--seed", type=int, default=1, help="of the hidden inputs (default 1)")
    parser.add_argument("--solutions", type=Path, default=answers.SOLUTIONS, metavar="DIR")
    parser.add_argument(
        "--judged", type=Path, default=answers.ANSWERS, metavar="DIR", help="of the equivalents"
    )
    given = parser.parse_args(arguments)
    found = sorted(path.parent.name for path in given.solutions.glob("*/*.ipynb"))
    reports = []
    try:
        for name in given.names or found:
            report = mutate(name, given.solutions, given.judged, seed=given.seed, jobs=given.jobs)
            print(report, flush=True)
            reports.append(report)
    except (AutograderError, equivalents.Stale) as error:
        print(error, file=sys.stderr)
        return 2
    return 0 if all(report.is_good for report in reports) else 1


def mutate(name: str, solutions: Path, judged: Path, *, seed: int, jobs: int) -> Report:
    """Grade all mutants of ``ASSIGNMENT``, or of ``ASSIGNMENT/EXERCISE``, with a progress bar.

    ``judged`` is the folder of ``<assignment>/equivalents.toml``.

    Raises:
        AutograderError: there is no such exercise, or the reference itself loses marks.
        equivalents.Stale: an entry does not fit the notebook any more.
    """
    folder, _, only = name.partition("/")
    entries = equivalents.read(judged / folder / equivalents.FILE)
    exercises = run.exercises(solutions / folder / f"{folder}.ipynb", only)
    cells = {one.cell for one in exercises}
    entries = [one for one in entries if not only or one.exercise in cells]
    every = [mutant for one in exercises for mutant in run.of_exercise(one)]
    equivalents.refuse_stale(entries, every, killed=[])
    running = run.run(exercises, seed=seed, jobs=jobs)
    bar = tqdm(running, total=len(every), desc=name, unit="mutant", disable=None, leave=False)
    verdicts = list(bar)
    # By a case: on a busy machine any mutant may run longer than it may.
    killed = [one.mutant for one in verdicts if one.lost]
    equivalents.refuse_stale(entries, every, killed)
    return Report(name, verdicts, entries)


if __name__ == "__main__":
    sys.exit(main())
