"""A batch's own process holds neither submissions nor results."""

import contextlib
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from .. import toy

pytestmark = [pytest.mark.long, pytest.mark.soak]

SUBMISSIONS, LARGE_BYTES = 18, 8_000_000
"""Kept in memory, these notebooks would take 144 MB: more than what is allowed to grow."""
MOST, GROWTH = 300 * 2**20, 80 * 2**20


def make_class(root: Path) -> list[Path]:
    """Write the assignment and its submissions, all of them large, and give their folders."""
    toy.make_tree(root)
    large = toy.answer(toy.DOUBLE, toy.APPLY, toy.cell("x = 1"))
    text = {"output_type": "stream", "name": "stdout", "text": "x" * LARGE_BYTES}
    large["cells"][-1]["outputs"] = [text]
    return [toy.hand_in(root / "submitted", f"{n:05}", large) for n in range(SUBMISSIONS)]


def sizes(root: Path, folders: list[Path], wall: str) -> Iterator[int]:
    """Grade the class, and look at the batch's process again and again until it ends."""
    command = [sys.executable, "-m", "robust_slam_autograder.cli"]
    command += ["--solutions", str(root / "solutions"), "grade", *map(str, folders)]
    command += ["--out", str(root / "graded"), "--sandbox", wall]
    with (root / "said.txt").open("w+") as said:
        batch = subprocess.Popen(command, stdout=said, stderr=said)
        process = psutil.Process(batch.pid)
        while batch.poll() is None:
            yield process.memory_info().rss
            with contextlib.suppress(subprocess.TimeoutExpired):
                batch.wait(timeout=0.05)
    assert batch.returncode == 0, (root / "said.txt").read_text()[-1000:]


@pytest.mark.sandbox
def test_memory_is_small_and_flat(tmp_path, wall_name):
    seen = list(sizes(tmp_path, make_class(tmp_path), wall_name))
    quarter = len(seen) // 4
    assert quarter and max(seen) < MOST
    assert max(seen[quarter:]) - max(seen[:quarter]) < GROWTH
