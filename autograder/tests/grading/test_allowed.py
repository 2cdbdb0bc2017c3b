"""Grading refuses a course that its own sandbox would show to students, in one sentence."""

import json
from pathlib import Path

import pytest
import robust_slam_autograder

from .. import toy

SHOWN = "which is in"


@pytest.fixture
def exposed(tmp_path, monkeypatch):
    """A folder that student code sees, as the allowed package of the same name."""
    folder = tmp_path / f"shown_{tmp_path.name}"
    folder.mkdir()
    (folder / "__init__.py").touch()
    monkeypatch.syspath_prepend(tmp_path)
    return folder


@pytest.fixture
def grade(autograder, wall_name):
    """Grade Ada's submission behind the wall: exit status, errors."""

    def run(tree, submitted, out, how=("--sandbox", wall_name)):
        handed_in = toy.hand_in(submitted, "ada", toy.answer())
        status, _, said = autograder("--solutions", tree, "grade", handed_in, "--out", out, *how)
        return status, said

    return run


@pytest.mark.sandbox
@pytest.mark.parametrize("what", ["tree", "submitted", "out", "a link to the tree"])
def test_what_student_code_could_read_is_refused(what, exposed, tmp_path, grade):
    places = {name: tmp_path / name for name in ("tree", "submitted", "out")}
    if what in places:
        places[what] = exposed / what
    config = f"packages = {json.dumps([*toy.PACKAGES, exposed.name])}\n"
    places["tree"] = toy.make_tree(exposed if "tree" in what else places["tree"], config)
    if what.startswith("a link"):
        (tmp_path / "link").symlink_to(places["tree"])
        places["tree"] = tmp_path / "link"
    status, said = grade(**places)
    assert status == 2
    assert "Student code could read" in said and f"{SHOWN} {exposed}: move it out" in said
    assert not (places["out"] / "ada").exists()
    if what != "out":  # to trust the submissions is to trust them with that too
        assert grade(**places, how=["--unsandboxed"])[0] == 0


@pytest.mark.sandbox
def test_a_course_in_an_allowed_packages_source_folder_is_refused(tmp_path, grade):
    """Of this one student code sees the grader itself."""
    out = Path(robust_slam_autograder.__file__).parent / "no-such-results"
    status, said = grade(toy.make_tree(tmp_path), tmp_path / "submitted", out)
    assert status == 2 and SHOWN in said and not out.exists()


@pytest.mark.sandbox
def test_a_package_that_is_not_installed_is_refused(tmp_path, grade):
    tree = toy.make_tree(tmp_path, 'packages = ["numpy", "no_such_package"]\n')
    status, said = grade(tree, tmp_path / "submitted", tmp_path / "out")
    assert status == 2
    assert f"{toy.NAME}/autograder.toml: packages (by default numpy, scipy, matplotlib)" in said
    assert "names no_such_package, which is not installed here: install it, or list oth" in said
