"""Kills a process alone, and sees that what it started ends with it."""

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import psutil

PATIENCE = 900.0
"""Seconds, for a busy machine; tests wait so long only where something is wrong."""
ENDED = (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)


def kill(process: subprocess.Popen[str], when: Callable[[], bool], mark: str) -> None:
    """Kill a batch's process, and it alone, when the time has come; see that none survives it."""
    wait_for(lambda: when() or process.poll() is not None)
    family = related(process.pid, mark)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    assert process.returncode == -signal.SIGKILL, "it was done before it was killed"
    assert len(family) > 1
    wait_for(lambda: not any(map(lives, family)))


def related(pid: int, mark: str) -> list[psutil.Process]:
    """A process with its descendants, and the servers that it started and let go."""
    found = psutil.Process(pid).children(recursive=True)
    for process in psutil.process_iter(["cmdline"]):
        if mark in " ".join(process.info["cmdline"] or ()):
            with contextlib.suppress(psutil.NoSuchProcess):  # it may end meanwhile
                found += [process, *process.children(recursive=True)]
    return found


def lives(process: psutil.Process) -> bool:
    try:
        return process.is_running() and process.status() not in ENDED
    except psutil.NoSuchProcess:
        return False


def wait_for(condition: Callable[[], bool], left: Callable[[], object] = str) -> None:
    """Wait until something holds; ``left`` says what is in its way."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, f"it takes too long {left()}"
        time.sleep(0.005)


def wait_until_empty(folder: Path) -> None:
    """Wait until what ended processes leave behind is removed."""
    wait_for(lambda: not list(folder.iterdir()), lambda: sorted(folder.rglob("*")))
