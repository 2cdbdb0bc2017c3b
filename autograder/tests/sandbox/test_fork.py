"""The fork server: shared by processes, and gone with the one that owns it."""

import os
import pickle
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.sandbox import Fork, Launch
from robust_slam_autograder.sandbox.fork import Forked

from ..kernel import working
from ..killing import lives, wait_for
from ..sessions import started
from .probing import LAUNCH, processes_of

pytestmark = pytest.mark.sandbox


@pytest.fixture(scope="module")
def wall():
    working("fork")
    return Fork()


def launched(wall: Fork, launch: Launch = LAUNCH) -> Forked:
    running = wall.start(launch)
    assert running.await_ready() is None
    return running


USER = """
import pickle, sys
wall, launch = pickle.loads(bytes.fromhex(sys.argv[1]))
running = wall.start(launch)
print(running.await_ready())
running.stop()
"""


def test_other_processes_use_the_same_server(wall):
    command = [sys.executable, "-c", USER, pickle.dumps((wall, LAUNCH)).hex()]
    users = [subprocess.Popen(command, stdout=subprocess.PIPE, text=True) for _ in range(2)]
    assert [user.communicate()[0] for user in users] == ["None\n"] * 2
    # The servers outlive them, one for each kind of launch.
    wait_for(lambda: len(processes_of(wall.home)) == 1)


# A shell's background processes ignore interrupts; this one must not.
OWNER = """
import signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
from robust_slam_autograder.sandbox import Fork, Launch
wall = Fork()
running = wall.start(Launch(withheld=(), used=(), cpu_seconds=20))
print(running.await_ready(), wall.home, flush=True)
time.sleep(600)
"""


@pytest.fixture
def owner(wall):
    """A process that owns a fork server with a student, and the server's folder."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL, "text": True}
    command = [sys.executable, "-c", OWNER]
    with subprocess.Popen(command, start_new_session=True, **options) as process:
        try:
            said, home = process.stdout.readline().split()
            assert said == "None" and len(processes_of(Path(home))) > 1
            yield process.pid, Path(home)
        finally:
            process.kill()


@pytest.mark.parametrize(
    "end", [lambda pid: os.kill(pid, signal.SIGKILL), lambda pid: os.killpg(pid, signal.SIGINT)],
    ids=["killed alone", "interrupted with its group"],
)  # fmt: skip
def test_servers_and_students_end_with_their_owner(owner, end):
    pid, home = owner
    end(pid)
    wait_for(lambda: not processes_of(home) and not home.exists())


def test_a_student_does_not_outlive_its_keeper(wall):
    running = launched(wall)
    server = min(processes_of(wall.home), key=lambda process: process.create_time())
    (keeper,) = server.children()
    keeper.kill()
    wait_for(lambda: len(processes_of(wall.home)) == 1)
    running.stop()


def test_a_stopped_student_leaves_nothing_but_a_server_that_no_other_user_may_ask(wall):
    running = launched(wall)
    assert len(processes_of(wall.home)) > 1
    running.stop()
    wait_for(lambda: len(processes_of(wall.home)) == 1)
    assert not list(wall.home.glob("scratch-*"))
    (address,) = [path for path in wall.home.iterdir() if path.is_socket()]
    assert address.stat().st_mode & 0o077 == 0
    assert wall.home.stat().st_mode & 0o066 == 0
    assert address.stat().st_uid == os.getuid()


def test_a_server_that_was_killed_is_started_again(wall):
    wall.start(LAUNCH).stop()
    (server,) = processes_of(wall.home)
    server.kill()
    wait_for(lambda: not lives(server))  # its sockets are closed later than its memory
    launched(wall).stop()


def test_what_the_grader_itself_needs_cannot_be_withheld(wall):
    with pytest.raises(GraderFailure, match="numpy is withheld"):
        wall.start(Launch(withheld=("numpy",), used=(), cpu_seconds=20))


def test_a_withheld_module_is_not_imported_ahead():
    """Its code would be in the student's memory, whatever the files say."""
    name = ("json.tool",)
    launched(Fork(), Launch(withheld=name, used=(), cpu_seconds=20, preload=name)).stop()


LOOK = """
import os, timeit
FOLDER, NEW = os.path.dirname(os.__file__), os.urandom(8).hex()
def took(n):
    return timeit.timeit(f"exists('{FOLDER}/{NEW}-{n}')", "from os.path import exists", number=1)
def look():
    first, again = (sorted(map(took, range(2000)))[1000] for _ in range(2))
    return first / again, os.path.getsize(f"{FOLDER}/json/tool.py"), os.stat(FOLDER).st_dev
"""


def test_the_servers_share_a_copy_that_forgets_what_it_is_asked_for(wall, request):
    """What one withholds is not seen when the next server's view needs it in the same copy."""
    request.addfinalizer(partial(os.umask, os.umask(0o077)))
    fresh, names = Fork(), ("look",)
    withheld = started(LOOK, names=names, withheld=("json.tool",), wall=fresh)
    with withheld as one, started(LOOK, names=names, wall=fresh) as other:
        (again, nothing, device), (_, size, same) = (
            session.bindings()["look"]() for session in (one, other)
        )
    assert nothing == 0 < size and device == same
    assert again < 1.5, "a disk remembers a name that is not there, and answers thrice as fast"
