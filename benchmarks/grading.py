"""How long does grading take, beside plain nbgrader? The same class on both sides, in one run.

Every submission is correct and gets full marks on both sides, or the run stops. Both begin
with the gradebook that ``nbgrader generate_assignment`` makes, and write marks into it. nbgrader
runs each notebook once; the grader makes two passes, with hidden inputs of its own.

    python -m benchmarks.grading --assignment 03-irls --submissions 40

A line ``ratio NAME VALUE`` tells how many times faster the grader is, or two workers are
than one; names that end in /cpu compare processor time, which a busy machine spoils less.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from nbgrader.api import Gradebook
from robust_slam_autograder.sandbox import BACK_ENDS

from benchmarks.cost import Cost, measure
from tests.assignments import answers

SCRIPTS = Path(sys.executable).parent
ENVIRONMENT = {
    "PATH": os.pathsep.join([str(SCRIPTS), os.environ.get("PATH", "")]),
    "OPENBLAS_NUM_THREADS": "1",
}
CONFIG = 'c = get_config()\nc.CourseDirectory.course_id = "benchmark"\n'


def make_course(root: Path, assignment: str, submissions: int) -> None:
    """Make an nbgrader course whose students hand in the instructor's own answers."""
    shutil.copytree(answers.SOLUTIONS / assignment, root / "source" / assignment)
    (root / "nbgrader_config.py").write_text(CONFIG, encoding="utf-8")
    measure(
        [str(SCRIPTS / "nbgrader"), "generate_assignment", assignment], cwd=root, env=ENVIRONMENT
    )
    text = answers.text(answers.solved(assignment, root / "release"))
    for number in range(submissions):
        path = root / "submitted" / f"student-{number:03}" / assignment / f"{assignment}.ipynb"
        path.parent.mkdir(parents=True)
        path.write_text(text, encoding="utf-8")


def run_nbgrader(root: Path, assignment: str) -> Cost:
    """Grade the class with plain nbgrader."""
    shutil.copy(root / "gradebook.db", root / "before.db")
    cost = measure([str(SCRIPTS / "nbgrader"), "autograde", assignment], cwd=root, env=ENVIRONMENT)
    with Gradebook(f"sqlite:///{root / 'gradebook.db'}") as book:
        marks = [(s.score, s.max_score) for s in book.assignment_submissions(assignment)]
    _insist_on_full_marks(marks, root)
    return cost


def run_grader(root: Path, assignment: str, wall: str, workers: int) -> Cost:
    """Grade the class with the grader, in an empty results' folder."""
    out = root / "graded"
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir()
    shutil.copy(root / "before.db", out / "gradebook.db")
    command = [str(SCRIPTS / "autograder"), "--solutions", str(root / "source"), "grade"]
    command += [str(path) for path in sorted((root / "submitted").glob(f"*/{assignment}"))]
    command += ["--out", str(out), "--jobs", str(workers), "--sandbox", wall]
    cost = measure(command, cwd=root, env=ENVIRONMENT)
    results = [json.loads(path.read_text("utf-8")) for path in out.glob(f"*/{assignment}.json")]
    _insist_on_full_marks([(r["score"], r["max_score"]) for r in results], root)
    return cost


def _insist_on_full_marks(marks: Sequence[tuple[float, float]], root: Path) -> None:
    handed_in = len(list((root / "submitted").iterdir()))
    if len(marks) != handed_in or any(score != most for score, most in marks):
        raise RuntimeError(f"{handed_in} right answers, but the marks are {sorted(set(marks))}.")


def tell(name: str, cost: Cost, submissions: int) -> None:
    """Print a line of the table."""
    cpu = "–" if cost.cpu is None else f"{cost.cpu / submissions:.3f}"
    load = f"{os.getloadavg()[0]:.1f}"
    print(
        f"{name:<24} {cost.wall:8.1f} {cost.wall / submissions:10.3f} {cpu:>10} {load:>6}",
        flush=True,
    )


def ratios(name: str, slow: Cost, fast: Cost) -> list[str]:
    """The lines that compare two costs."""
    lines = [f"ratio {name} {slow.wall / fast.wall:.2f}"]
    if slow.cpu and fast.cpu:
        lines.append(f"ratio {name}/cpu {slow.cpu / fast.cpu:.2f}")
    return lines


def compare(root: Path, assignment: str, submissions: int) -> list[str]:
    """Measure both sides, one after the other, and give the lines that compare them."""
    make_course(root, assignment, submissions)
    walls = [name for name, wall in BACK_ENDS.items() if wall.problem() is None]
    print(
        f"{assignment}, {submissions} submissions; load average before: {os.getloadavg()[0]:.1f}"
    )
    print(f"{'':<24} {'seconds':>8} {'each':>10} {'each, CPU':>10} {'load':>6}")
    plain = run_nbgrader(root, assignment)
    tell("nbgrader", plain, submissions)
    lines = []
    for wall in walls:
        cost = run_grader(root, assignment, wall, workers=1)
        tell(f"grader, {wall}", cost, submissions)
        lines += ratios(f"grade/nbgrader/{wall}", plain, cost)
    for wall in walls[:1]:
        one, two = (run_grader(root, assignment, wall, workers) for workers in (1, 2))
        tell(f"one worker, {wall}", one, submissions)
        tell(f"two workers, {wall}", two, submissions)
        lines.append(f"ratio grade/parallel {one.wall / two.wall:.2f}")
    return lines


def main() -> None:
    """Read the arguments and print the table."""
    parser = argparse.ArgumentParser(description="Grading beside plain nbgrader.")
    parser.add_argument("--assignment", default="03-irls")
    parser.add_argument("--submissions", type=int, default=40)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="benchmark-") as folder:
        lines = compare(Path(folder), options.assignment, options.submissions)
    print("\n".join(lines))


if __name__ == "__main__":
    main()
