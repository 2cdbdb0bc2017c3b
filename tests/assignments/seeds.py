"""Runs every hidden case on the reference with many seeds: it must pass with all of them.

    python -m tests.assignments.seeds [NAME…] [--seeds 10000] [--first 1] [--jobs 2]

A case that refuses a right answer for one seed in a thousand costs a whole class its points one
day. Exit status 1 where any case fails.
"""

from __future__ import annotations

import argparse
import functools
import multiprocessing
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from tqdm import tqdm

from tests.assignments import answers, reference

CHUNK = 200
"""Seeds of one task."""


@dataclass(frozen=True)
class Failure:
    """A case that refuses the reference."""

    grade_id: str
    seed: int
    error: str

    def __str__(self) -> str:
        return f"{self.grade_id} with seed {self.seed}: {self.error}"


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
    parser.add_argument("--first", type=int, default=1, help="the first of them (default 1)")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once")
    given = parser.parse_args(arguments)
    seeds = range(given.first, given.first + given.seeds)
    return max([_report(name, seeds, given.jobs) for name in given.names])


def _report(name: str, seeds: range, jobs: int) -> int:
    """Say which cases of an assignment fail, and how often; 1 where any does."""
    first: dict[str, Failure] = {}
    counts: dict[str, int] = {}
    for failure in failures(name, seeds, jobs=jobs):
        first.setdefault(failure.grade_id, failure)
        counts[failure.grade_id] = counts.get(failure.grade_id, 0) + 1
    print(f"{name}: {len(counts)} cases fail with some of {len(seeds)} seeds", flush=True)
    for grade_id, count in counts.items():
        print(f"  {count} times {first[grade_id]}", flush=True)
    return 1 if counts else 0


if __name__ == "__main__":
    sys.exit(main())
