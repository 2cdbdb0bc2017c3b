"""An assignment's archive: the same bytes each time, and a README that can be followed."""

from __future__ import annotations

import hashlib
import os
import time
import zipfile
from pathlib import Path

import pytest
from robust_slam_autograder import cli
from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing.handout import INSTALL
from robust_slam_autograder.publishing.student_release import release

from tests.autograder import toy
from tests.autograder.publishing import world

WHEELS = ("the_grader-1.0-py3-none-any.whl", "toy_library-1.0-py3-none-any.whl")
HELD = (
    f"{toy.NAME}.ipynb",
    "README.txt",
    "autograder.toml",
    *(f"packages/{name}" for name in WHEELS),
    "requirements.txt",
)


def archive_of(tree: Path, out: Path) -> zipfile.ZipFile:
    release(tree, [], out)
    return zipfile.ZipFile(out / f"{toy.NAME}.zip")


def readme_of(tree: Path, out: Path) -> str:
    with archive_of(tree, out) as archive:
        return archive.read(f"{toy.NAME}/README.txt").decode()


def test_it_holds_the_release_and_a_readme(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    with archive_of(tree, tmp_path / "out") as archive:
        names = archive.namelist()
        assert names == [f"{toy.NAME}/{name}" for name in HELD]
        for name in (f"{toy.NAME}.ipynb", "autograder.toml"):
            assert (
                archive.read(f"{toy.NAME}/{name}")
                == (tmp_path / "out" / toy.NAME / name).read_bytes()
            )
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            assert entry.external_attr >> 16 == 0o100644
            assert entry.compress_type == zipfile.ZIP_STORED
    assert sorted(path.name for path in tmp_path.iterdir()) == ["course", "out"]


def test_the_same_release_gives_the_same_bytes(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    digests = set()
    for name, mask in (("a", 0o022), ("b", 0o077)):
        before = os.umask(mask)
        try:
            archive_of(tree, tmp_path / name).close()
        finally:
            os.umask(before)
        digests.add(hashlib.sha256((tmp_path / name / f"{toy.NAME}.zip").read_bytes()).hexdigest())
        time.sleep(2.1)  # archives tell times to two seconds
    assert len(digests) == 1


def test_files_that_an_assignment_needs_come_with_it(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    (tree / toy.NAME / "data").mkdir()
    (tree / toy.NAME / "data" / "z.csv").write_text("1,2\n")
    (tree / toy.NAME / "README.txt").write_text("The instructor's own.\n")
    with archive_of(tree, tmp_path / "out") as archive:
        assert archive.read(f"{toy.NAME}/data/z.csv") == b"1,2\n"
        assert archive.read(f"{toy.NAME}/README.txt") == b"The instructor's own.\n"


def test_students_install_from_the_archive_with_an_address_and_without(tmp_path: Path) -> None:
    texts = set()
    for url in ("", world.URL):
        folder = tmp_path / (url[:1] or "none")
        tree = world.make(folder / "course", url)
        with archive_of(tree, folder / "out") as archive:
            read = {name: archive.read(f"{toy.NAME}/{name}").decode() for name in HELD[1:2]}
            texts.add(read["README.txt"])
            wanted = archive.read(f"{toy.NAME}/requirements.txt").decode().splitlines()
        assert wanted == [f"./packages/{WHEELS[1]}[extra]", f"./packages/{WHEELS[0]}", "a-lab>=4"]
    (text,) = texts
    lines = [line.strip() for line in text.splitlines()]
    start = lines.index(INSTALL[0])
    assert tuple(lines[start : start + len(INSTALL)]) == INSTALL


def test_an_extra_is_for_its_assignment_alone(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    toy.write(tree / "08-more" / "08-more.ipynb", toy.source_notebook())
    release(tree, [], tmp_path / "out")
    with zipfile.ZipFile(tmp_path / "out" / "08-more.zip") as archive:
        assert "[extra]" not in archive.read("08-more/requirements.txt").decode()


def test_a_wheel_holds_what_the_public_may_have(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    world.write(tree.parent, "lib/untracked.py", "")
    with (
        archive_of(tree, tmp_path / "out") as archive,
        archive.open(f"{toy.NAME}/packages/{WHEELS[1]}") as wheel,
        zipfile.ZipFile(wheel) as held,
    ):
        names = held.namelist()
    assert "toy_library.py" in names
    assert not [name for name in names if "private" in name or "untracked" in name]


@pytest.mark.parametrize(
    ("old", "new", "error", "sentence"),
    [
        ('"autograder/", ', "", WrongUse, "names autograder/, and there is no file of it"),
        ("[extra]", "[a b]", WrongUse, r"\[install.also\] takes extras"),
        ("toy-library[extra]", "other[extra]", WrongUse, r"\[install.also\] takes extras"),
        ("a-lab>=4", "a-lab @ https://x", WrongUse, "tools takes a list of packages"),
        ("a-lab>=4", "--index-url=x", WrongUse, "tools takes a list of packages"),
    ],
)
def test_what_cannot_be_installed_is_named(
    tmp_path: Path, old: str, new: str, error: type[Exception], sentence: str
) -> None:
    tree = world.make(tmp_path / "course")
    assert old in world.COURSE
    world.write(tree.parent, "solutions/course.toml", world.COURSE.replace(old, new))
    with pytest.raises(error, match=sentence):
        release(tree, [], tmp_path / "out")


def test_a_package_that_cannot_be_built_stops_it(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    world.write(tree.parent, "lib/pyproject.toml", "[build-system")
    with pytest.raises(GraderFailure, match="pip could not build lib, autograder: "):
        release(tree, [], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_course_that_says_nothing_leaves_it_to_the_instructor(tmp_path: Path) -> None:
    text = readme_of(toy.make_tree(tmp_path), tmp_path / "out")
    assert text.startswith(f"{toy.NAME}\n=====") and "pip install" not in text
    assert f"autograder check {toy.NAME}.ipynb" in text and "says how" in text


def test_the_readme_has_short_lines_and_the_title(tmp_path: Path) -> None:
    for url in ("", world.URL):
        folder = tmp_path / (url[:1] or "none")
        text = readme_of(world.make(folder / "course", url), folder / "out")
        assert text.startswith(f"{toy.NAME}: Double and apply\n===")
        assert not [line for line in text.splitlines() if len(line) > 79]


@pytest.mark.parametrize(
    ("config", "sentence"),
    [
        ("repository: {url: not an address}", "repository.url must be an address"),
        ("repository: {url: 'https://me:t0ken@x/y'}", "repository.url holds a password"),
        ("repository: {url: 3}", "repository.url must be an address"),
        ("repository: {url: 'https://x/\"; rm'}", "repository.url must be an address"),
        ("repository: {url: 'https://x/y', branch: 'a b'}", "repository.branch must be"),
        ("repository: [", "cannot be read"),
    ],
)
def test_an_address_that_is_none_is_named(tmp_path: Path, config: str, sentence: str) -> None:
    tree = world.make(tmp_path / "course")
    world.write(tree.parent, "_config.yml", config)
    with pytest.raises(WrongUse, match=sentence):
        release(tree, [], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_of_several_assignments_all_are_released_or_none(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    out = tmp_path / "out"
    release(tree, [], out)
    before = world.files(out)
    good, bad = toy.source_notebook(), toy.source_notebook()
    good["cells"][0]["source"] += "# changed\n"
    toy.write(tree / toy.NAME / f"{toy.NAME}.ipynb", good)
    bad["cells"][3]["source"] = bad["cells"][3]["source"].replace("HIDDEN TESTS", "HIDDEN TEST")
    toy.write(tree / "08-bad" / "08-bad.ipynb", bad)
    with pytest.raises(GraderFailure, match="# hint:"):
        release(tree, [], out)
    assert world.files(out) == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["course", "out"]


def test_one_release_leaves_the_others_alone(tmp_path: Path) -> None:
    tree = world.make(tmp_path / "course")
    toy.write(tree / "08-more" / "08-more.ipynb", toy.source_notebook())
    out = tmp_path / "out"
    release(tree, [], out)
    (out / toy.NAME / "mine.txt").write_text("mine")
    release(tree, ["08-more", "08-more"], out)
    assert (out / toy.NAME / "mine.txt").is_file()
    assert sorted(path.name for path in out.glob("*.zip")) == [f"{toy.NAME}.zip", "08-more.zip"]


def test_the_command_names_the_archive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tree, out = world.make(tmp_path / "course"), tmp_path / "out"
    assert cli.main(["--solutions", str(tree), "release", "--out", str(out)]) == 0
    assert str(out / f"{toy.NAME}.zip") in capsys.readouterr().out
