"""What a sandbox's processes may use together."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import psutil
import pytest
from robust_slam_autograder.sandbox import watch
from robust_slam_autograder.sandbox.inside import PROCESSES


def test_all_descendants_are_found() -> None:
    code = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'input()'])"
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE) as process:
        while len(found := watch.descendants(process.pid)) < 1:
            pass
        assert found[0].pid != process.pid
        process.communicate(b"\n")
    assert watch.descendants(process.pid) == []


@pytest.mark.parametrize("limit", ["MEMORY_BYTES", "PROCESSES", "SCRATCH_BYTES"])
def test_each_limit_counts(limit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    processes = [psutil.Process()]
    (tmp_path / "file").write_bytes(os.urandom(10_000))
    assert not watch.uses_too_much(processes, tmp_path)
    monkeypatch.setattr(watch, limit, 0)
    assert watch.uses_too_much(processes, tmp_path)


class Threads:
    """A process that only has threads."""

    def __init__(self, count: int) -> None:
        self.count = count

    def memory_info(self) -> SimpleNamespace:
        return SimpleNamespace(rss=0, shared=0)

    def num_threads(self) -> int:
        return self.count

    def num_fds(self) -> int:
        return 0


@pytest.mark.parametrize(("more", "is_too_much"), [(0, False), (1, True)])
def test_threads_of_all_processes_count_to_twice_the_kernels_limit(
    more: int, is_too_much: bool
) -> None:
    processes: Any = [Threads(PROCESSES), Threads(PROCESSES - 1), Threads(1 + more)]
    assert watch.uses_too_much(processes, None) == is_too_much


def test_a_flood_of_empty_files_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watch, "SCRATCH_BYTES", 50_000)
    for number in range(20):
        (tmp_path / str(number)).touch()
    assert watch.uses_too_much([psutil.Process()], tmp_path)


def test_a_folder_that_cannot_be_listed_is_told(tmp_path: Path) -> None:
    with pytest.raises(OSError):
        watch.uses_too_much([psutil.Process()], tmp_path / "missing")
