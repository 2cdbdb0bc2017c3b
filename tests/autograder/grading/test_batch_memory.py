"""A batch's own process holds neither submissions nor results."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import grading_memory

pytestmark = pytest.mark.long

SUBMISSIONS = 48
LARGE_EVERY = 3
"""Kept in memory, these notebooks of 8 MB would take 128 MB: more than what is allowed to grow."""
MOST, GROWTH = 300, 80
"""MiB."""


@pytest.mark.sandbox
def test_memory_is_small_and_flat(tmp_path: Path, wall_name: str) -> None:
    folders = grading_memory.make_class(tmp_path, SUBMISSIONS, LARGE_EVERY)
    seen = list(grading_memory.samples(tmp_path, folders, "--sandbox", wall_name))
    peaks = [sample.memory / grading_memory.MIB for sample in grading_memory.peaks(seen, 12)]
    assert len(peaks) == 5 and max(peaks) < MOST
    assert max(peaks) - peaks[0] < GROWTH
