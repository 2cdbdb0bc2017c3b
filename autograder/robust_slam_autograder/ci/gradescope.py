"""Grades one submission in Gradescope's container and writes its ``results.json``.

The format is Gradescope's, https://gradescope-autograders.readthedocs.io/en/latest/specs/.
Students see the cases that they have whole; all others, and so the total, when the marks
are published: what cannot be seen cannot be asked again and again.

Where no sandbox works, or the grader fails, there is no ``results.json``. Gradescope then
says that the autograder failed, and no one has a mark that is not theirs.
"""

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from robust_slam_autograder.errors import AutograderError
from robust_slam_autograder.grading import batch, durable, journal, submissions
from robust_slam_autograder.grading.batch import How
from robust_slam_autograder.grading.results import CaseResult, ExerciseResult, Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.grading.verdicts import MEANINGS
from robust_slam_autograder.markup import visible
from robust_slam_autograder.misconceptions import tables
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.sandbox import choose

SEED_NAME = "seed"
TREE_NAME = "solutions"
LABELS_NAME = "misconceptions"
NOBODY = "submission"
"""Stands for the student: Gradescope knows who it is, and nothing here needs to."""
LATER = (
    "Checks that use other inputs, and the points, appear when the marks are published. "
    "`autograder check` runs all that you can see."
)


def main(root: Path) -> int:
    """Grade what is in ``root/submission``; exit status 1 where there is no result.

    The root is ``/autograder``, with the archive in ``source``.
    """
    target = root / "results" / "results.json"
    target.parent.mkdir(exist_ok=True)
    target.unlink(missing_ok=True)
    try:
        result = _grade(root)
        if result.status == "failed":
            raise AutograderError(result.reason)
        durable.write(target, json.dumps(as_gradescope(result), indent=1) + "\n")
    except (AutograderError, OSError) as error:
        print(f"Not graded: {error}", file=sys.stderr)
        return 1
    return 0


def _grade(root: Path) -> Result:
    tree = root / "source" / TREE_NAME
    (name,) = assignments.find_names(tree)
    given = Submission(NOBODY, assignments.of(tree, name), root / "submission")
    job = submissions.read(given)
    # From a file, for others can read a command line.
    seed = int((root / "source" / SEED_NAME).read_text(encoding="ascii"))
    with tempfile.TemporaryDirectory() as folder:
        run = journal.open_journal(Path(folder), seed)
        how = How(choose(), tables.namer(root / "source" / LABELS_NAME))
        (graded,) = batch.grade([job], run, how)
        return graded.load()


def as_gradescope(result: Result) -> dict[str, Any]:
    """Return a result as Gradescope reads it.

    Neither a time nor anything else that hidden inputs could have changed is visible before
    the marks are published.
    """
    tests = []
    for number, exercise in enumerate(result.exercises, start=1):
        for place, case in enumerate(exercise.cases, start=1):
            tests.append(_test(exercise, case, f"{number}.{place}"))
        if exercise.misconception:
            tests.append(_label(exercise, f"{number}.{len(exercise.cases) + 1}"))
    return {
        "score": result.score,
        "output": visible(_output(result)),
        "output_format": "text",
        "test_output_format": "text",
        "test_name_format": "text",
        "stdout_visibility": "hidden",
        "tests": tests,
    }


def _output(result: Result) -> str:
    if result.status == "refused":
        return f"Not graded: {result.reason}"
    absent = [e.name for e in result.exercises if e.status == "missing"]
    lines = [f"{name}: {MEANINGS['missing']}" for name in absent]
    return "\n".join([*([result.reason] if result.reason else []), *lines, LATER])


def _test(exercise: ExerciseResult, case: CaseResult, number: str) -> dict[str, Any]:
    return {
        "number": number,
        "name": f"{exercise.name}: {case.name}",
        "score": case.earned,
        "max_score": case.points,
        "status": "passed" if case.passed else "failed",
        "output": visible(case.message),
        "visibility": "visible" if case.visible else "after_published",
    }


def _label(exercise: ExerciseResult, number: str) -> dict[str, Any]:
    """Return what a wrong answer looks like; hidden cases had no part in it."""
    return {
        "number": number,
        "name": f"{exercise.name}: what it looks like",
        "output": visible(f"It looks as if {exercise.misconception}."),
        "visibility": "visible",
    }


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
