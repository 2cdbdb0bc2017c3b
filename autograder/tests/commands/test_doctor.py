"""What ``autograder doctor`` says of a machine."""

import json

import pytest
from robust_slam_autograder import sandbox
from robust_slam_autograder.commands import doctor
from robust_slam_autograder.sandbox import Fork, Unsandboxed

from .. import toy


def test_it_says_what_works_and_what_is_taken(autograder, monkeypatch):
    monkeypatch.setattr(sandbox, "BACK_ENDS", {"broken": toy.Broken(), "good": Unsandboxed()})
    status, out, _ = autograder("doctor")
    assert status == 0
    assert "✗ unusable    broken: it is not installed" in out
    assert "✓ works       good" in out and "Grading uses good" in out
    monkeypatch.setattr(sandbox, "BACK_ENDS", {"broken": toy.Broken()})
    status, out, _ = autograder("doctor")
    assert status == 1 and "--unsandboxed" in out


@pytest.mark.parametrize("problem", [None, "this user may make no control group"])
def test_it_says_how_memory_is_counted(autograder, monkeypatch, problem):
    monkeypatch.setattr(sandbox, "BACK_ENDS", {"good": Unsandboxed()})
    monkeypatch.setattr(doctor.cgroup, "problem", lambda: problem)
    status, out, _ = autograder("doctor")
    assert status == 0
    if problem is None:
        assert "Memory is counted by the kernel" in out
    else:
        assert problem in out and "process by process" in out and "systemd-run" in out


def test_it_says_what_student_code_would_see_of_the_course(autograder, monkeypatch, tmp_path):
    """The sentence with which grading refuses."""
    tree, out = toy.make_tree(tmp_path), tmp_path / "graded"
    monkeypatch.setattr(sandbox, "BACK_ENDS", {"fork": Fork()})
    monkeypatch.setattr(Fork, "problem", lambda wall: None)
    assert autograder("doctor", "--out", out).worked(doctor.SEEN)
    (tmp_path / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path.parent)
    toy.make_tree(tmp_path, f"packages = {json.dumps([*toy.PACKAGES, tmp_path.name])}\n")
    status, said, _ = autograder("doctor", "--out", out)
    assert status == 1 and doctor.SEEN not in said
    assert f"Student code could read {tree}, which is in {tmp_path}: move it" in said


@pytest.mark.parametrize(
    ("name", "problem", "facts", "remedy"),
    [
        ("fork", "unshare: Operation not…", {"setting": "1"}, "sysctl -w kernel.apparmor"),
        ("fork", "unshare: Operation not permitted", {}, "grade as root, outside a container"),
        ("fork", "it says nothing", {}, "Report this"),
        ("landlock", "version 0", {"landlock": 0}, "Linux 5.13"),
        ("landlock", "cannot enter /root", {"uid": 0}, "/usr/local"),
        ("landlock", "version 4", {"uid": 1000}, "Linux 6.12"),
        ("fork", "it needs Linux", {"system": "Darwin"}, "WSL"),
    ],
)
def test_a_problem_has_a_remedy(monkeypatch, tmp_path, name, problem, facts, remedy):
    (tmp_path / "kernel").mkdir()
    restriction = tmp_path / "kernel" / "apparmor_restrict_unprivileged_userns"
    restriction.write_text(f"{facts.get('setting', '0')}\n")
    monkeypatch.setattr(doctor, "SETTINGS", tmp_path)
    monkeypatch.setattr("platform.system", lambda: facts.get("system", "Linux"))
    monkeypatch.setattr("os.getuid", lambda: facts.get("uid", 1000))
    monkeypatch.setattr(doctor.landlock, "version", lambda: facts.get("landlock", 5))
    assert remedy in doctor.remedy(name, problem)
