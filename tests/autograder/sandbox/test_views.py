"""The walls once more as an ordinary user, and as root where every folder is open."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests import as_user

WALLS = "tests/autograder/sandbox/test_sandbox.py"
ATTACKS = "tests/autograder/hostile"
USERS = {"root": 0, "an ordinary user": as_user.ORDINARY}


def run_as(uid: int, *words: str) -> subprocess.CompletedProcess[str]:
    """Run tests as a user with a home and a temporary folder of its own."""
    home = Path(tempfile.mkdtemp(prefix="view-"))  # pytest's own folders are closed to others
    os.chown(home, uid, uid)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    command += ["--basetemp", f"{home}/tests", *words]
    environment = {**os.environ, "HOME": str(home), "ROBUST_SLAM_STRICT": "1"}
    for name in [name for name in environment if name.startswith("PYTEST")]:
        del environment[name]
    wrapped = as_user.command(command, uid)
    done = subprocess.run(
        wrapped, cwd=as_user.ROOT, env=environment, capture_output=True, text=True
    )
    shutil.rmtree(home)
    return done


@pytest.fixture(scope="module")
def runs() -> Iterator[Callable[[str], subprocess.CompletedProcess[str]]]:
    """What the walls' tests say to each user, who run them at the same time."""
    if not as_user.may():
        pytest.skip("this user is an ordinary one, and test_sandbox.py has run")
    with ThreadPoolExecutor() as pool:
        answers = {name: pool.submit(run_as, uid, WALLS) for name, uid in USERS.items()}
        yield lambda name: answers[name].result()


@pytest.mark.sandbox
@pytest.mark.parametrize("user", USERS)
def test_every_wall_stands_for(
    user: str, runs: Callable[[str], subprocess.CompletedProcess[str]]
) -> None:
    done = runs(user)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert re.search(r"\d\d passed", done.stdout) and "skipped" not in done.stdout


@pytest.mark.soak
@pytest.mark.skipif(not as_user.may(), reason="only root may become another user")
def test_attacks_on_an_ordinary_users_walls() -> None:
    done = run_as(as_user.ORDINARY, "--soak", ATTACKS)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
