"""Grading refuses a course that its own sandbox would show to students, in one sentence."""

import json
from collections.abc import Sequence
from pathlib import Path

import pytest
import robust_slam_autograder
from robust_slam_autograder import cli

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


def grade(tree: Path, submitted: Path, out: Path, *more: str) -> Sequence[str]:
    handed_in = toy.hand_in(submitted, "ada", toy.answer())
    command = ["--solutions", str(tree), "grade", str(handed_in), "--out", str(out), *more]
    return command


@pytest.mark.sandbox
@pytest.mark.parametrize("what", ["tree", "submitted", "out", "a link to the tree"])
def test_what_student_code_could_read_is_refused(what, exposed, tmp_path, capsys, wall_name):
    places = {name: tmp_path / name for name in ("tree", "submitted", "out")}
    if what in places:
        places[what] = exposed / what
    config = f"packages = {json.dumps([*toy.PACKAGES, exposed.name])}\n"
    places["tree"] = toy.make_tree(exposed if "tree" in what else places["tree"], config)
    if what.startswith("a link"):
        link = tmp_path / "link"
        link.symlink_to(places["tree"])
        places["tree"] = link
    command = grade(places["tree"], places["submitted"], places["out"], "--sandbox", wall_name)
    assert cli.main(command) == 2
    said = capsys.readouterr().err
    assert "Student code could read" in said and f"{SHOWN} {exposed}: move it out" in said
    assert not (places["out"] / "ada").exists()
    if what != "out":  # to trust the submissions is to trust them with that too
        assert cli.main([*command[:-2], "--unsandboxed"]) == 0


@pytest.mark.sandbox
def test_a_course_in_an_allowed_packages_source_folder_is_refused(tmp_path, capsys, wall_name):
    """Of this one student code sees the grader itself."""
    out = Path(robust_slam_autograder.__file__).parent / "no-such-results"
    tree = toy.make_tree(tmp_path)
    assert cli.main(grade(tree, tmp_path / "submitted", out, "--sandbox", wall_name)) == 2
    assert SHOWN in capsys.readouterr().err and not out.exists()


@pytest.mark.sandbox
def test_a_package_that_is_not_installed_is_refused(tmp_path, capsys, wall_name):
    tree = toy.make_tree(tmp_path, 'packages = ["numpy", "no_such_package"]\n')
    command = grade(tree, tmp_path / "submitted", tmp_path / "out", "--sandbox", wall_name)
    assert cli.main(command) == 2
    said = capsys.readouterr().err
    assert f"{toy.NAME}/autograder.toml: packages names no_such_package, which is not" in said
