"""Memory that no process's size shows: refused, or counted by a control group."""

import contextlib
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import psutil
import pytest
from robust_slam_autograder.sandbox import Fork, Sandbox, cgroup, terms, watch
from robust_slam_autograder.sandbox.cgroup import Group

from ..kernel import leave_out
from ..sessions import started
from .probing import ATTACKERS, LAUNCH, processes_of, run

HOLDERS = """
import fcntl, os, socket

def held():
    "Bytes that this process holds in sockets and pipes, as many as it can open."
    kept, total = [], 0
    try:
        while True:
            pair = socket.socketpair()
            kept.append(pair)
            for end in pair:
                end.setblocking(False)
                try:
                    while True: total += end.send(bytes(65536))
                except BlockingIOError: pass
    except OSError: pass
    return total, len(kept)

def locks():
    "The number of a file with many locks, which stays open and can be locked again."
    global kept
    kept = open(os.path.join(os.environ["HOME"], "locked"), "w+b")
    for place in range(0, 2000, 2):
        fcntl.lockf(kept, fcntl.LOCK_EX, 1, place)
    fcntl.flock(kept, fcntl.LOCK_EX)
    with open(kept.name, "r+b") as other:
        fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return os.fstat(kept.fileno()).st_ino
"""


@pytest.mark.sandbox
def test_what_sockets_hold_is_counted_for_each_open_file(wall):
    total, pairs = run(wall, "held", HOLDERS)
    assert 0 < total <= 2 * pairs * watch.SOCKET_BYTES


@pytest.mark.sandbox
def test_locks_are_none(wall):
    """A lock on a file that sandboxes share would make others wait; many take memory."""
    with started(HOLDERS, names=("locks",), wall=wall, packages=ATTACKERS) as session:
        inode = session.bindings()["locks"]()
        assert f":{inode} " not in Path("/proc/locks").read_text("utf-8")


@pytest.fixture
def group():
    """A group for a sandbox."""
    problem = cgroup.problem()
    # Root with version 1 of control groups, found out without the grader's code.
    may = os.getuid() == 0 and os.access("/sys/fs/cgroup/memory/cgroup.procs", os.W_OK)
    if problem is not None and may:
        pytest.fail(f"This machine counts memory, but {problem}")
    if problem is not None:
        leave_out(problem)
    with cgroup.made() as made:
        assert made is not None
        yield made
    assert not made.folder.exists()


FILL = """
import os, socket, sys
open(sys.argv[1], "w").write("0")
kept = []
for _ in range(int(sys.argv[2])):
    pair = socket.socketpair()
    kept.append(pair)
    for end in pair:
        end.setblocking(False)
        try:
            while True: end.send(bytes(65536))
        except BlockingIOError: pass
print("full", flush=True)
sys.stdin.read()
"""


def fill(group: Group, pairs: int) -> Any:
    """A process in a group that fills so many pairs of sockets, until its input ends."""
    command = [sys.executable, "-c", FILL, str(group.members), str(pairs)]
    pipe = subprocess.PIPE
    return subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True)


USED = ("memory.current", "memory.usage_in_bytes")
LIMITS = ("memory.max", "memory.limit_in_bytes")


def files(group: Group, names: tuple[str, str]) -> list[Path]:
    return [path for name in names if (path := group.folder / name).exists()]


def test_a_group_has_the_sandboxs_limit_and_counts_what_sockets_hold(group):
    assert [int(path.read_text()) for path in files(group, LIMITS)] == [terms.MEMORY_BYTES]
    with fill(group, 200) as process:
        assert process.stdout.readline() == "full\n"
        assert int(files(group, USED)[0].read_text()) > 200 * 200_000
        process.stdin.close()


def test_a_group_ends_what_holds_more(group):
    for path in files(group, LIMITS):
        path.write_text(str(64 * 2**20))
    with fill(group, 400) as process:
        assert process.wait() == -signal.SIGKILL


def groups_of(wall: Sandbox) -> set[str]:
    """Names of the groups of what this process has started behind a wall."""
    started = psutil.Process().children(recursive=True)
    if isinstance(wall, Fork):
        started = processes_of(wall.home)
    found = set()
    for process in started:
        with contextlib.suppress(OSError):
            text = Path(f"/proc/{process.pid}/cgroup").read_text()
            found |= set(re.findall(rf"/({cgroup.PREFIX}\S+)", text))
    return found


@pytest.mark.sandbox
def test_each_sandbox_has_a_group_while_it_runs(wall, group):
    running = [wall.start(LAUNCH) for _ in range(2)]
    assert [one.await_ready() for one in running] == [None, None]
    names = groups_of(wall)
    assert len(names) == 2
    for one in running:
        one.stop()
    assert [name for name in names if (group.folder.parent / name).exists()] == []


@pytest.mark.sandbox
def test_a_group_goes_with_a_student_that_is_killed(wall, group):
    running = wall.start(LAUNCH)
    assert running.await_ready() is None
    (name,) = groups_of(wall)
    for pid in (group.folder.parent / name / "cgroup.procs").read_text().split():
        with contextlib.suppress(ProcessLookupError):  # it ended with another one
            os.kill(int(pid), signal.SIGKILL)
    running.stop()
    assert not (group.folder.parent / name).exists()


def test_what_a_killed_grader_left_is_removed(group):
    parent = group.folder.parent
    left = parent / f"{cgroup.PREFIX}0-left"
    left.mkdir()
    with fill(group, 1) as process:
        process.stdout.readline()
        cgroup.problem.cache_clear()
        assert cgroup.problem() is None
        assert left.exists()  # it may be a moment old, and its grader about to use it
        for folder in (left, group.folder):
            os.utime(folder, (0, 0))
        cgroup.problem.cache_clear()
        assert cgroup.problem() is None
        assert not left.exists() and group.folder.exists()
        process.stdin.close()


SYSTEMD = "0::/user.slice/user-1000.slice/user@1000.service/app.slice/shell.scope\n"


def test_with_version_2_the_nearest_group_that_counts_its_children_is_taken(tmp_path):
    """A group with processes of its own cannot count its children's memory: one around it can."""
    own = tmp_path / SYSTEMD.strip()[len("0::/") :]
    own.mkdir(parents=True)
    for folder in (own, own.parent):
        (folder / "cgroup.procs").touch()
    (own / "cgroup.subtree_control").mkdir()  # as the kernel: it cannot be written
    (own.parent / "cgroup.subtree_control").write_text("memory pids")
    (tmp_path / "mountinfo").write_text(f"31 23 0:28 / {tmp_path} rw - cgroup2 cgroup2 rw\n")
    (tmp_path / "cgroup").write_text(SYSTEMD)
    assert cgroup.parent(tmp_path) == own.parent


def test_where_there_are_no_groups_nothing_is_made(tmp_path):
    for name in ("mountinfo", "cgroup"):
        (tmp_path / name).touch()
    assert cgroup.parent(tmp_path) is None
