"""What a command costs: seconds on the clock, and seconds of processor time of all that it starts.

Daemons and orphans count too, which a parent's own bookkeeping leaves out; so the
command runs in a control group of its own where this user may make one (root on Linux).
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

PLACES = (Path("/sys/fs/cgroup"), Path("/sys/fs/cgroup/unified"))
END_SECONDS = 20.0


@dataclass(frozen=True)
class Cost:
    """Seconds.

    Attributes:
        wall: on the clock.
        cpu: of all processors together; None where it cannot be told.
    """

    wall: float
    cpu: float | None


def measure(command: Sequence[str], *, cwd: Path, env: Mapping[str, str] | None = None) -> Cost:
    """Run a command to its end.

    Raises:
        RuntimeError: it fails; with the end of what it said.
    """
    with _group() as group:
        start = time.perf_counter()
        done = subprocess.run(
            _within(group, command),
            cwd=cwd,
            env=dict(os.environ) | dict(env or {}),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )
        wall = time.perf_counter() - start
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(command)} fails:\n{done.stderr[-2000:]}")
        return Cost(wall, _cpu_seconds(group))


@contextlib.contextmanager
def _group() -> Iterator[Path | None]:
    place = next((place for place in PLACES if (place / "cgroup.procs").is_file()), None)
    group = place / f"benchmark-{os.getpid()}" if place else None
    try:
        if group:
            group.mkdir()
    except OSError:
        group = None
    try:
        yield group
    finally:
        if group:
            group.rmdir()


def _within(group: Path | None, command: Sequence[str]) -> list[str]:
    """Have a shell enter the group and become the command."""
    if group is None:
        return list(command)
    return ["sh", "-c", 'echo $$ > "$0" && exec "$@"', str(group / "cgroup.procs"), *command]


def _cpu_seconds(group: Path | None) -> float | None:
    """Read the group's clock when the last of its processes has ended."""
    if group is None:
        return None
    end = time.monotonic() + END_SECONDS
    while (group / "cgroup.procs").read_text() and time.monotonic() < end:
        time.sleep(0.01)
    fields = dict(line.split() for line in (group / "cpu.stat").read_text().splitlines())
    return int(fields["usage_usec"]) / 1e6
