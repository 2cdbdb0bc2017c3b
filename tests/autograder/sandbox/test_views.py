"""The walls once more as an ordinary user, and as root where every folder is open."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from tests import as_user


@pytest.mark.sandbox
@pytest.mark.parametrize("uid", [0, as_user.ORDINARY], ids=["root", "an ordinary user"])
def test_every_wall_stands_for(uid: int) -> None:
    if not as_user.may():
        pytest.skip("this user is an ordinary one, and test_sandbox.py has run")
    home = Path(tempfile.mkdtemp(prefix="view-"))  # pytest's own folders are closed to others
    os.chown(home, uid, uid)
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    command += ["--basetemp", f"{home}/tests", "tests/autograder/sandbox/test_sandbox.py"]
    environment = {**os.environ, "HOME": str(home), "ROBUST_SLAM_STRICT": "1"}
    for name in [name for name in environment if name.startswith("PYTEST")]:
        del environment[name]
    wrapped = as_user.command(command, uid)
    done = subprocess.run(
        wrapped, cwd=as_user.ROOT, env=environment, capture_output=True, text=True
    )
    shutil.rmtree(home)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-1000:]
    assert re.search(r"\d\d passed", done.stdout) and "skipped" not in done.stdout
