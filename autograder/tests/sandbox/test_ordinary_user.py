"""The walls once more as an ordinary user, where root runs the tests."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from .. import as_user

pytestmark = pytest.mark.rest


def run_as_ordinary_user(*words: str) -> subprocess.CompletedProcess[str]:
    """Run tests as a user with a home and a temporary folder of its own."""
    home = Path(tempfile.mkdtemp(prefix="view-"))  # pytest's own folders are closed to others
    os.chown(home, as_user.ORDINARY, as_user.ORDINARY)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    command += ["--basetemp", f"{home}/tests", *words]
    environment = {**os.environ, "HOME": str(home), "ROBUST_SLAM_STRICT": "1"}
    for name in [name for name in environment if name.startswith("PYTEST")]:
        del environment[name]
    wrapped = as_user.command(command, as_user.ORDINARY)
    done = as_user.ended(wrapped, cwd=as_user.GRADER, env=environment)
    shutil.rmtree(home)
    return done


@pytest.mark.skipif(not as_user.may(), reason="an ordinary user runs these tests anyway")
@pytest.mark.parametrize(
    "words",
    [
        pytest.param(
            ["-m", "not soak", "tests/sandbox/test_sandbox.py"], marks=pytest.mark.sandbox
        ),
        pytest.param(["-m", "", "tests/hostile"], marks=pytest.mark.soak),
    ],
    ids=["every wall stands", "no attack succeeds"],
)
def test_for_an_ordinary_user(words):
    """A second pytest starts, and runs these tests again."""
    done = run_as_ordinary_user(*words)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert re.search(r"\d\d passed", done.stdout) and "skipped" not in done.stdout
