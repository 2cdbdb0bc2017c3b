"""Runs every hidden case on the reference with many seeds: it must pass with all of them.

    python -m tests.assignments.seeds [NAME…] [--seeds 10000] [--jobs 2]

A case that refuses a right answer for one seed in a thousand costs a whole class its points one
day. Exit status 1 where any case fails.
"""

import argparse
import functools
import multiprocessing
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

from tqdm import tqdm

from solutions.classes import answers
from tests.assignments import reference

CHUNK = 200
"""Seeds of one task."""


class Failure(NamedTuple):
    """A case that refuses the reference."""

    grade_id: str
    seed: int
    error: str


def failures(
    name: str, seeds: range, *, jobs: int, tree: Path = answers.SOLUTIONS
) -> Iterator[Failure]:
    """Run an assignment's hidden cases with these seeds, with a progress bar."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # one thread a process
    cases = [case for case in reference.load(name, tree).assignment.cases if case.has_hidden]
    chunks = [seeds[start : start + CHUNK] for start in range(0, len(seeds), CHUNK)]
    tasks = [(case.grade_id, chunk) for case in cases for chunk in chunks]
    context = multiprocessing.get_context("forkserver")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        run = functools.partial(_failures_of_case, name, tree)
        found = pool.map(run, *zip(*tasks, strict=True))
        for some in tqdm(found, name, len(tasks), unit="chunk", disable=None, leave=False):
            yield from some


def _failures_of_case(name: str, tree: Path, grade_id: str, seeds: range) -> list[Failure]:
    solutions = reference.load(name, tree)
    (case,) = (one for one in solutions.assignment.cases if one.grade_id == grade_id)
    found = []
    for seed in seeds:
        try:
            solutions.run(case, seed)
        except Exception as error:  # a test fails by raising, whatever it raises
            told = f"{type(error).__name__}: {error}".rstrip(": ")
            found.append(Failure(grade_id, seed, told))
    return found


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; give its exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.assignments.seeds",
        description="Run every hidden case on the reference with many seeds.",
    )
    parser.add_argument("names", nargs="*", metavar="NAME", default=answers.assignments())
    parser.add_argument("--seeds", type=int, default=10_000, help="how many (default 10000)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once")
    given = parser.parse_args(arguments)
    seeds = range(1, 1 + given.seeds)
    return max([_report(name, seeds, given.jobs) for name in given.names])


def _report(name: str, seeds: range, jobs: int) -> int:
    """Say which cases of an assignment fail, and how often; 1 where any does."""
    found: dict[str, list[Failure]] = {}
    for failure in failures(name, seeds, jobs=jobs):
        found.setdefault(failure.grade_id, []).append(failure)
    print(f"{name}: {len(found)} cases fail with some of {len(seeds)} seeds", flush=True)
    for grade_id, some in found.items():
        told = f"{grade_id} with seed {some[0].seed}: {some[0].error}"
        print(f"  {len(some)} times {told}", flush=True)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
