"""How much memory does a batch's own process take, and does it grow with the class?

Grades a class of a small assignment; every twentieth notebook is some megabytes large.
The processes that read and run submissions are others, each ends with its submission.

    python -m benchmarks.grading_memory --submissions 500
"""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import psutil

from tests.autograder import toy

LARGE_EVERY = 20
LARGE_BYTES = 8_000_000
MIB = 2**20


@dataclass(frozen=True)
class Sample:
    """The batch's process at one moment: how many results there were, and its bytes."""

    results: int
    memory: int


def make_class(root: Path, submissions: int, large_every: int = LARGE_EVERY) -> list[Path]:
    """Write the assignment and its submissions, and give their folders."""
    toy.make_tree(root)
    large = toy.answer(toy.DOUBLE, toy.APPLY, toy.cell("x = 1"))
    text = {"output_type": "stream", "name": "stdout", "text": "x" * LARGE_BYTES}
    large["cells"][-1]["outputs"] = [text]
    return [
        toy.hand_in(
            root / "submitted", f"{number:05}", toy.answer() if number % large_every else large
        )
        for number in range(submissions)
    ]


def samples(root: Path, folders: list[Path], *options: str) -> Iterator[Sample]:
    """Grade the class, and look at the batch's process again and again until it ends.

    Raises:
        RuntimeError: the batch fails.
    """
    out = root / "graded"
    command = [sys.executable, "-m", "robust_slam_autograder.cli"]
    command += ["--solutions", str(root / "solutions"), "grade", *map(str, folders)]
    command += ["--out", str(out), *options]
    with (root / "said.txt").open("w+") as said:
        batch = subprocess.Popen(command, stdout=said, stderr=said)
        process = psutil.Process(batch.pid)
        while batch.poll() is None:
            yield Sample(len(list(out.glob("*/*.json"))), process.memory_info().rss)
            with contextlib.suppress(subprocess.TimeoutExpired):
                batch.wait(timeout=0.05)
        if batch.returncode != 0:
            said.seek(0)
            raise RuntimeError(f"the batch fails: {said.read()[-1000:]}")


def peaks(seen: list[Sample], step: int) -> list[Sample]:
    """The most memory in each stretch of so many results, the gradebook's writing in the last."""
    found = [Sample(0, 0)] * (max(sample.results for sample in seen) // step + 1)
    for sample in seen:
        stretch = sample.results // step
        if sample.memory > found[stretch].memory:
            found[stretch] = Sample(stretch * step, sample.memory)
    return found


def main() -> None:
    """Read the arguments and print the table."""
    parser = argparse.ArgumentParser(description="Memory of a batch's own process.")
    parser.add_argument("--submissions", type=int, default=500)
    parser.add_argument("--step", type=int, default=100)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="benchmark-") as folder:
        root = Path(folder)
        seen = list(samples(root, make_class(root, options.submissions)))
    print("from result  most memory, MiB")
    for sample in peaks(seen, options.step):
        print(f"{sample.results:>11} {sample.memory / MIB:>17.0f}")
    print(f"peak MiB {max(sample.memory for sample in seen) / MIB:.0f}")


if __name__ == "__main__":
    main()
