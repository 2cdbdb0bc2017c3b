"""What nbgrader keeps in a submission's folder is a short plain file, or it is not there."""

from datetime import datetime
from pathlib import Path

import pytest
from nbgrader.apps.api import NbGraderAPI
from nbgrader.coursedir import CourseDirectory
from robust_slam_autograder.nbgrader import own_files
from robust_slam_autograder.nbgrader.own_files import read_warily

from ..timestamps import JUNK


@pytest.fixture
def api(monkeypatch, tmp_path):
    """nbgrader's object, changed for the test alone."""
    for owner, name in (
        (CourseDirectory, "get_existing_timestamp"),
        (NbGraderAPI, "get_submitted_timestamp"),
    ):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    read_warily()
    return NbGraderAPI(CourseDirectory(root=str(tmp_path)))


@pytest.fixture
def folder(tmp_path):
    path = tmp_path / "submitted" / "ada" / "07-toy"
    path.mkdir(parents=True)
    return path


def times(api: NbGraderAPI, folder: Path) -> set[datetime | None]:
    """What autograde and formgrader read."""
    listed = api.get_submitted_timestamp("07-toy", "ada")
    return {listed, api.coursedir.get_existing_timestamp(str(folder))}


@pytest.mark.parametrize("spoil", JUNK.values(), ids=JUNK)
def test_what_holds_no_time_is_read_as_none(api, folder, spoil):
    assert times(api, folder) == {None}
    spoil(folder / "timestamp.txt")
    assert times(api, folder) == {None}


def test_a_plain_time_is_read(api, folder):
    (folder / "timestamp.txt").write_text("2026-03-01 12:00:00 UTC")
    assert times(api, folder) == {datetime(2026, 3, 1, 12)}


def test_both_files_are_kept_where_they_are_plain(folder):
    (folder / "timestamp.txt").write_text("2026-03-01")
    (folder / "submission_secret.txt").write_text("s3cret")
    wanted = {"timestamp.txt": b"2026-03-01", "submission_secret.txt": b"s3cret"}
    assert own_files.plain(folder) == wanted
    (folder / "submission_secret.txt").unlink()
    (folder / "submission_secret.txt").symlink_to("/etc/passwd")
    (folder / "timestamp.txt").write_text("9" * 2000)
    assert own_files.plain(folder) == {}
