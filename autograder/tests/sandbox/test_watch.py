"""What a sandbox's processes may use together."""

import os
import subprocess
import sys
from types import SimpleNamespace

import psutil
import pytest
from robust_slam_autograder.sandbox import watch
from robust_slam_autograder.sandbox.terms import MEMORY_BYTES, PROCESSES


def test_all_descendants_are_found():
    start = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'input()'])"
    # Its first thread has started nothing.
    code = f"import threading; threading.Thread(target=exec, args=({start!r}, {{}})).start()"
    with subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE) as process:
        while len(found := watch.descendants(process.pid)) < 1:
            pass
        assert found[0].pid != process.pid
        process.communicate(b"\n")
    assert watch.descendants(process.pid) == []


def using(rss: int = 0, shared: int = 0, threads: int = 0, files: int = 0) -> SimpleNamespace:
    """A process as the watch sees it."""
    return SimpleNamespace(
        memory_info=lambda: SimpleNamespace(rss=rss, shared=shared),
        num_threads=lambda: threads,
        num_fds=lambda: files,
    )


HALF = MEMORY_BYTES // 2
OPEN = MEMORY_BYTES // watch.SOCKET_BYTES


@pytest.mark.parametrize(
    ("processes", "is_too_much"),
    [
        ([using(rss=HALF + 9, shared=9), using(rss=HALF)], False),
        ([using(rss=HALF + 9, shared=9), using(rss=HALF + 1)], True),
        ([using(files=OPEN - 1), using(files=1)], False),
        ([using(files=OPEN), using(files=1)], True),
        ([using(threads=PROCESSES), using(threads=PROCESSES)], False),
        ([using(threads=PROCESSES), using(threads=PROCESSES - 1), using(threads=2)], True),
    ],
)
def test_memory_files_and_threads_of_all_processes_count(processes, is_too_much):
    """Shared memory does not; an open file counts as a full socket."""
    assert watch.uses_too_much(processes, None) == is_too_much


@pytest.mark.parametrize("sizes", [[10_000], [0] * 20], ids=["bytes", "a flood of empty files"])
def test_files_on_the_disk_count(sizes, tmp_path, monkeypatch):
    for number, size in enumerate(sizes):
        (tmp_path / str(number)).write_bytes(os.urandom(size))
    assert not watch.uses_too_much([psutil.Process()], tmp_path)
    monkeypatch.setattr(watch, "SCRATCH_BYTES", 5000 * len(sizes) // 2)
    assert watch.uses_too_much([psutil.Process()], tmp_path)


def test_a_folder_that_cannot_be_listed_is_an_error(tmp_path):
    with pytest.raises(OSError):
        watch.uses_too_much([psutil.Process()], tmp_path / "missing")
