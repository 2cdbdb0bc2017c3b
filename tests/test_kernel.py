"""A back end that the kernel supports and that does not work fails; no skip hides it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from robust_slam_autograder.sandbox import BACK_ENDS

from tests import kernel
from tests.autograder import toy
from tests.conftest import leave_out

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def broken(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(BACK_ENDS, "fork", toy.Broken())
    monkeypatch.delenv("ROBUST_SLAM_STRICT", raising=False)


def test_what_the_kernel_supports_must_work(broken: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel, "supports", lambda name: True)
    with pytest.raises(pytest.fail.Exception, match="supports fork, but it does not work"):
        kernel.working("fork")
    assert kernel.usable()[0] == "fork"


def test_what_the_kernel_lacks_is_left_out(broken: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel, "supports", lambda name: False)
    with pytest.raises(pytest.skip.Exception, match="fork does not work here"):
        kernel.working("fork")
    assert "fork" not in kernel.usable()


@pytest.mark.sandbox
def test_a_wall_without_a_stone_fails_without_strict(tmp_path: Path) -> None:
    """Without ``forbid_new_privileges`` no filter can be set, and no back end of ours works."""
    if not kernel.supports("fork"):
        leave_out("this kernel grants no namespaces")
    package = tmp_path / "robust_slam_autograder"
    subprocess.run(["cp", "-r", ROOT / "autograder" / package.name, package], check=True)
    module = package / "sandbox" / "system.py"
    text = module.read_text("utf-8")
    assert text.count("_prctl(_SET_NO_NEW_PRIVS, 1)") == 1
    module.write_text(text.replace("_prctl(_SET_NO_NEW_PRIVS, 1)", "pass"), "utf-8")
    for folder in (tmp_path, *tmp_path.parents[:2]):
        folder.chmod(0o755)
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    environment.pop("ROBUST_SLAM_STRICT", None)
    test = "tests/autograder/sandbox/test_sandbox.py::test_plain_work_goes_on[fork]"
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-n", "0", test]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert done.returncode == 1 and "supports fork, but it does not work" in done.stdout
