"""Honest submissions get full marks, however their notebooks look."""

from __future__ import annotations

from pathlib import Path

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.sandbox import Bubblewrap

from tests.autograder import honest, toy

pytestmark = pytest.mark.sandbox


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory, bubblewrap: Bubblewrap) -> Path:
    """The results of one batch of all honest submissions."""
    folder = tmp_path_factory.mktemp("honest")
    tree = toy.make_tree(folder)
    paths = [folder / "submitted" / name / toy.NAME for name in honest.SUBMISSIONS]
    for path, write in zip(paths, honest.SUBMISSIONS.values(), strict=True):
        write(path)
    command = ["--solutions", tree, "grade", *paths, "--out", folder / "out", "--jobs", 2]
    assert cli.main([*map(str, command)]) == 0
    return folder / "out"


@pytest.mark.parametrize("name", honest.SUBMISSIONS)
def test_honest_work_gets_full_marks(out: Path, name: str) -> None:
    value = toy.result(out, name)
    lost = [(e["name"], e["message"]) for e in value["exercises"] if e["status"] != "passed"]
    assert not lost, value["reason"]
    assert value["score"] == value["max_score"] == toy.MOST


def test_what_was_unusual_is_said(out: Path) -> None:
    assert toy.result(out, "plain")["reason"] == ""
    assert "stands in 2 cells" in toy.result(out, "copied-cell")["reason"]
    assert "Homework (1).ipynb was taken" in toy.result(out, "another-name")["reason"]
    assert "found by its function's name" in toy.result(out, "no-metadata")["reason"]
