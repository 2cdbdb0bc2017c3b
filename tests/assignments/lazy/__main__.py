"""The command: ``python -m tests.assignments.lazy [NAME…] [--seeds N]``.

Exit status 1 where a lazy answer earns a hidden point.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from tests.assignments import answers, reference
from tests.assignments.lazy.search import earned


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; give its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.assignments.lazy",
        description="Try lazy answers to every exercise; none may earn a hidden point.",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", default=answers.assignments())
    parser.add_argument("--seeds", type=int, default=1, help="of hidden inputs (default 1)")
    given = parser.parse_args(arguments)
    return max([_report(name, range(1, given.seeds + 1)) for name in given.names])


def _report(name: str, seeds: Sequence[int]) -> int:
    """Say what lazy answers earn in an assignment; 1 where it is anything."""
    solutions = reference.load(name)
    found = {one.case.grade_id: one for seed in seeds for one in earned(solutions, seed)}
    cases = solutions.assignment.cases
    hidden = sum(case.points for case in cases if case.has_hidden)
    points = sum(one.case.points for one in found.values())
    print(f"{name}: {points:g} of {hidden:g} hidden points", flush=True)
    for grade_id, one in found.items():
        print(f"  {grade_id} ({one.case.points:g}): {one.how}", flush=True)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
