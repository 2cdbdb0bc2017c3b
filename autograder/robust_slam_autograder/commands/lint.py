"""``autograder lint``: look at the instructor's tests for weak ones."""

import argparse
import json
from collections.abc import Sequence
from dataclasses import asdict

from robust_slam_autograder.commands import places
from robust_slam_autograder.lint import RULES, Finding, lint
from robust_slam_autograder.publishing import course as courses
from robust_slam_autograder.reading import assignment as assignments


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    places.add(parser, "names", "--answers")
    parser.add_argument("--strict", action="store_true", help="warnings count as errors")
    parser.add_argument("--json", action="store_true", help="the findings as JSON")
    parser.add_argument("--rules", action="store_true", help="say the rules, and do nothing else")


def run(options: argparse.Namespace) -> int:
    """Look at them; exit status 1 where there is an error (with --strict: or a warning)."""
    if options.rules:
        width = max(len(rule.name) for rule in RULES)
        for rule in RULES:
            print(f"{rule.name:{width}}  {rule.severity:7}  {rule.summary}")
        return 0
    places.refuse_no_answers(options)
    names = assignments.find_names(options.solutions, options.names)
    paths = [assignments.notebook_path(options.solutions / name) for name in names]
    course = courses.load(options.solutions)
    book = course.root / (course.public or courses.Public()).book
    found = [finding for path in paths for finding in lint(path, options.answers, book)]
    if options.json:
        print(json.dumps([asdict(finding) for finding in found], indent=1, ensure_ascii=False))
    else:
        _print(found, len(names))
    grave = [one for one in found if options.strict or one.severity == "error"]
    return 1 if grave else 0


def _print(found: Sequence[Finding], looked_at: int) -> None:
    for finding in found:
        print(finding)
    errors = sum(finding.severity == "error" for finding in found)
    mark = "✗" if errors else "✓"
    print(
        f"{mark} {errors} errors, {len(found) - errors} warnings in {looked_at} "
        f"{'assignment' if looked_at == 1 else 'assignments'}."
    )
