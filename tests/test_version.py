"""A release raises one number, and the changes that were unreleased get it as their heading."""

import shutil
from datetime import date

import pytest

from tools import version


@pytest.fixture
def course(tmp_path):
    for name in (*version.PLACES, version.CHANGES):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(version.ROOT / name, tmp_path / name)
    changes = tmp_path / version.CHANGES
    new = f"{version.UNRELEASED}\n- A change.\n"
    changes.write_text(changes.read_text("utf-8").replace(version.UNRELEASED, new), "utf-8")
    return tmp_path


def test_a_release_raises_it_everywhere(course):
    before = (course / version.CHANGES).read_text("utf-8")
    version.raise_to("7.0.0", course)
    assert version.current(course) == "7.0.0"
    after = (course / version.CHANGES).read_text("utf-8")
    heading = f"## Unreleased\n\n## 7.0.0 ({date.today()})\n"
    assert after == before.replace("## Unreleased\n", heading)


@pytest.mark.parametrize("number", ["0.1.0", "7.0", "v7.0.0", "7.0.0+d1"])
def test_what_is_no_newer_version_changes_nothing(course, number):
    before = {name: (course / name).read_bytes() for name in version.PLACES}
    with pytest.raises(ValueError, match="is no version"):
        version.raise_to(number, course)
    assert before == {name: (course / name).read_bytes() for name in version.PLACES}


def test_there_is_no_release_without_a_change(course):
    version.raise_to("7.0.0", course)
    with pytest.raises(ValueError, match=r"CHANGELOG\.md names no change"):
        version.raise_to("7.0.1", course)
    assert version.current(course) == "7.0.0"


def test_files_that_disagree_are_named(course):
    place = course / "CITATION.cff"
    place.write_text(place.read_text("utf-8").replace(version.current(), "0.0.1"), "utf-8")
    with pytest.raises(ValueError, match=r"CITATION\.cff"):
        version.current(course)
