"""The fork server: shared by processes, and gone with the one that owns it."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import psutil
import pytest
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.sandbox import Fork, Launch

from tests import kernel
from tests.autograder.killing import PATIENCE

pytestmark = pytest.mark.sandbox
LAUNCH = Launch(withheld=(), used=(), cpu_seconds=20)


@pytest.fixture
def wall() -> Fork:
    """A fork server of the test's own."""
    kernel.working("fork")
    return Fork()


def until(holds: Callable[[], bool]) -> bool:
    """Wait a while for something that happens in another process."""
    end = time.monotonic() + PATIENCE
    while not holds() and time.monotonic() < end:
        time.sleep(0.02)
    return holds()


def processes_of(home: Path) -> list[psutil.Process]:
    """The fork servers of a folder, and what they forked."""
    found = []
    for process in psutil.process_iter():
        try:
            if str(home) in " ".join(process.cmdline()):
                found.append(process)
        except psutil.Error:
            continue
    return found


def start_and_stop(wall: Fork, answers: multiprocessing.Queue[object]) -> None:
    running = wall.start(LAUNCH)
    answers.put(running.await_ready())
    running.stop()


def test_other_processes_use_the_same_server(wall: Fork) -> None:
    context = multiprocessing.get_context("spawn")
    answers: multiprocessing.Queue[object] = context.Queue()
    workers = [context.Process(target=start_and_stop, args=(wall, answers)) for _ in range(2)]
    for worker in workers:
        worker.start()
    assert [answers.get(timeout=60) for _ in workers] == [None, None]
    for worker in workers:
        worker.join()
    # The servers outlive the workers, one for each kind of launch.
    assert until(lambda: len(processes_of(wall._home)) == 1)


def test_a_copy_knows_the_same_folder(wall: Fork) -> None:
    assert pickle.loads(pickle.dumps(wall))._home == wall._home


OWNER = """
import sys, time
from robust_slam_autograder.sandbox import Fork, Launch
wall = Fork()
running = wall.start(Launch(withheld=(), used=(), cpu_seconds=20))
print(running.await_ready(), wall._home, flush=True)
time.sleep(60)
"""


def test_servers_and_students_end_when_their_owner_is_killed(wall: Fork) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", OWNER], stdout=subprocess.PIPE, text=True
    ) as owner:
        assert owner.stdout is not None
        said, home = owner.stdout.readline().split()
        assert said == "None" and len(processes_of(Path(home))) > 1
        owner.send_signal(signal.SIGKILL)
    assert until(lambda: not processes_of(Path(home)))
    assert until(lambda: not Path(home).exists())


def test_an_interrupt_for_the_whole_group_leaves_nothing(wall: Fork) -> None:
    command = [sys.executable, "-c", OWNER]
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    with subprocess.Popen(command, start_new_session=True, **options) as owner:  # type: ignore[call-overload]
        home = Path(owner.stdout.readline().split()[1])
        os.killpg(owner.pid, signal.SIGINT)
    assert until(lambda: not processes_of(home))
    assert until(lambda: not home.exists())


def test_a_student_does_not_outlive_its_keeper(wall: Fork) -> None:
    running = wall.start(LAUNCH)
    assert running.await_ready() is None
    server = min(processes_of(wall._home), key=lambda process: process.create_time())
    (keeper,) = server.children()
    keeper.kill()
    assert until(lambda: len(processes_of(wall._home)) == 1)
    running.stop()


def test_a_stopped_student_leaves_nothing(wall: Fork) -> None:
    running = wall.start(LAUNCH)
    assert running.await_ready() is None
    before = len(processes_of(wall._home))
    running.stop()
    assert until(lambda: len(processes_of(wall._home)) == 1 < before)
    assert not list(wall._home.glob("scratch-*"))


def test_a_server_that_was_killed_is_started_again(wall: Fork) -> None:
    wall.start(LAUNCH).stop()
    (server,) = processes_of(wall._home)
    server.kill()
    assert until(lambda: not processes_of(wall._home))
    running = wall.start(LAUNCH)
    assert running.await_ready() is None
    running.stop()


def test_what_the_grader_itself_needs_cannot_be_withheld(wall: Fork) -> None:
    with pytest.raises(GraderFailure, match="numpy is withheld"):
        wall.start(Launch(withheld=("numpy",), used=(), cpu_seconds=20))


def test_a_withheld_module_is_not_imported_ahead(wall: Fork) -> None:
    """Its code would be in the student's memory, whatever the files say."""
    launch = Launch(withheld=("json.tool",), used=(), cpu_seconds=20, preload=("json.tool",))
    running = wall.start(launch)
    assert running.await_ready() is None
    running.stop()


def test_only_the_owners_user_may_ask(wall: Fork) -> None:
    wall.start(LAUNCH).stop()
    (address,) = [path for path in wall._home.iterdir() if path.is_socket()]
    assert address.stat().st_mode & 0o077 == 0
    assert wall._home.stat().st_mode & 0o066 == 0
    assert address.stat().st_uid == os.getuid()
