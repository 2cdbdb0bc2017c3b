"""An assignment's archive: the same bytes each time, and a README that can be followed."""

import io
import os
import re
import time
import zipfile
from dataclasses import dataclass
from pathlib import Path

import pytest
from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing.handout import INSTALL
from robust_slam_autograder.publishing.student_release import release

from .. import toy
from ..as_user import ended
from . import world

pytestmark = pytest.mark.rest

MORE = "08-more"
WHEEL = r"packages/(the_grader|toy_library)-1\.0\+d[0-9a-f]{10}-py3-none-any\.whl"
"""A wheel in the archive; its version names its content."""


def archive_of(out: Path, name: str = toy.NAME) -> dict[str, bytes]:
    with zipfile.ZipFile(out / f"{name}.zip") as archive:
        return {each.removeprefix(f"{name}/"): archive.read(each) for each in archive.namelist()}


@dataclass(frozen=True)
class Released:
    """A course's release: its folder, and what the toy's archive holds."""

    out: Path
    toy: dict[str, bytes]

    @property
    def wheels(self) -> list[str]:
        return [name for name in self.toy if re.fullmatch(WHEEL, name)]


@pytest.fixture(scope="module")
def released(tmp_path_factory):
    """A course of two assignments, of which the second brings files of its own.

    It has a repository's address, from which nothing of an archive is installed.
    """
    folder = tmp_path_factory.mktemp("handout")
    tree = world.make(folder / "course", world.URL)
    world.write(tree.parent, "lib/untracked.py", "")
    toy.write(tree / MORE / f"{MORE}.ipynb", toy.source_notebook())
    world.write(tree / MORE, "data/z.csv", "1,2\n")
    world.write(tree / MORE, "README.txt", "The instructor's own.\n")
    release(tree, [], folder / "out")
    assert sorted(path.name for path in folder.iterdir()) == ["course", "out"]
    return Released(folder / "out", archive_of(folder / "out"))


@pytest.fixture
def tree(tmp_path):
    return world.make(tmp_path / "course")


def test_it_holds_the_release_and_a_readme(released):
    assert len(released.wheels) == 2
    assert list(released.toy) == [
        *(f"{toy.NAME}.ipynb", "README.txt", "autograder.toml", *released.wheels),
        "requirements.txt",
    ]
    for name in (f"{toy.NAME}.ipynb", "autograder.toml"):
        assert released.toy[name] == (released.out / toy.NAME / name).read_bytes()
    with zipfile.ZipFile(released.out / f"{toy.NAME}.zip") as archive:
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0)
            assert entry.external_attr >> 16 == 0o100644
            assert entry.compress_type == zipfile.ZIP_STORED


def test_the_same_release_gives_the_same_bytes(tree, tmp_path):
    release(tree, [], tmp_path / "a")
    time.sleep(2.1)  # archives tell times to two seconds
    before = os.umask(0o077)
    try:
        release(tree, [], tmp_path / "b")
    finally:
        os.umask(before)
    a, b = ((tmp_path / name / f"{toy.NAME}.zip").read_bytes() for name in ("a", "b"))
    assert a == b


def test_what_one_assignment_needs_comes_with_it_alone(released):
    more = archive_of(released.out, MORE)
    assert more["data/z.csv"] == b"1,2\n"
    assert more["README.txt"] == b"The instructor's own.\n"
    assert b"[extra]" not in more["requirements.txt"]


def test_students_install_from_the_archive_by_lines_of_its_readme(released):
    wanted = released.toy["requirements.txt"].decode().splitlines()
    grader, library = released.wheels
    assert wanted == [f"./{library}[extra]", f"./{grader}", "a-lab>=4"]
    text = released.toy["README.txt"].decode()
    assert text.startswith(f"{toy.NAME}: Double and apply\n===")
    assert not [line for line in text.splitlines() if len(line) > 79]
    lines = [line.strip() for line in text.splitlines()]
    start = lines.index(INSTALL[0])
    assert tuple(lines[start : start + len(INSTALL)]) == INSTALL


def test_a_wheel_holds_what_the_public_may_have(released):
    with zipfile.ZipFile(io.BytesIO(released.toy[released.wheels[1]])) as held:
        names = held.namelist()
    assert "toy_library.py" in names
    assert not [name for name in names if "private" in name or "untracked" in name]


def test_a_fix_reaches_who_has_installed_the_release_before(tree, tmp_path):
    """Pip installs twice, by the same lines, in an environment that all assignments share."""
    plain = world.COURSE.replace('["a-lab>=4"]', "[]").replace("[extra]", "")
    world.write(tree.parent, COURSE, plain)

    def installed_from(release_number: int) -> str:
        out = tmp_path / f"release-{release_number}"
        release(tree, [], out)
        with zipfile.ZipFile(out / f"{toy.NAME}.zip") as archive:
            archive.extractall(tmp_path / "student")
        folder = tmp_path / "student" / toy.NAME
        script = "\n".join([*INSTALL, "pip check", "python -c 'import toy_library as t; t.say()'"])
        offline = os.environ | {"PIP_NO_INDEX": "1"}
        done = ended(["bash", "-ec", script], cwd=folder, env=offline)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout.splitlines()[-1]

    told = "from importlib.metadata import version\ndef say(): print({!r}, version('toy-library'))"
    said = []
    for number, text in enumerate(["wrong", "right"]):
        world.write(tree.parent, "lib/toy_library.py", told.format(text))
        said.append(installed_from(number).split())
    assert [text for text, _ in said] == ["wrong", "right"]
    first, second = (version for _, version in said)
    assert first != second and first.startswith("1.0+d")
    world.write(tree.parent, "lib/toy_library.py", told.format("wrong"))
    release(tree, [], tmp_path / "again")
    assert archive_of(tmp_path / "again").keys() == archive_of(tmp_path / "release-0").keys()


def test_where_to_hand_in_is_read_from_the_book_s_settings(tree, tmp_path):
    place = "Upload this file to the folder of your group at https://example.edu/upload."
    world.write(tree.parent, BOOK, f"parse: {{myst_substitutions: {{hand_in: '{place}'}}}}\n")
    release(tree, [], tmp_path / "out")
    assert place in " ".join(archive_of(tmp_path / "out")["README.txt"].decode().split())


def test_a_course_that_says_nothing_leaves_it_to_the_instructor(tmp_path):
    release(toy.make_tree(tmp_path), [], tmp_path / "out")
    text = archive_of(tmp_path / "out")["README.txt"].decode()
    assert text.startswith(f"{toy.NAME}\n=====") and "pip install" not in text
    assert f"terminal:\n\n     autograder check {toy.NAME}.ipynb" in text and "says how" in text


COURSE, BOOK = "solutions/course.toml", "_config.yml"


@pytest.mark.parametrize(
    ("file", "old", "new", "sentence"),
    [
        (COURSE, '"autograder/", ', "", "names autograder/, and there is no file of it"),
        (COURSE, "[extra]", "[a b]", r"\[install.also\] takes extras"),
        (COURSE, "toy-library[extra]", "other[extra]", r"\[install.also\] takes extras"),
        (COURSE, "a-lab>=4", "a-lab @ https://x", "tools takes a list of packages"),
        (COURSE, "a-lab>=4", "--index-url=x", "tools takes a list of packages"),
        (BOOK, '""', "not an address", "repository.url must be an address"),
        (BOOK, '""', "https://me:t0ken@x/y", "repository.url holds a password"),
        (BOOK, '""', "3", "repository.url must be an address"),
        (BOOK, '""', "'https://x/\"; rm'", "repository.url must be an address"),
        (BOOK, '""', "https://x/y\n  branch: a b", "repository.branch must be"),
        (BOOK, '""', "[", "cannot be read"),
        (BOOK, "repository:", "parse: {myst_substitutions: {hand_in: 3}}\nx:", "be a text"),
    ],
)
def test_what_cannot_be_installed_is_named(tree, tmp_path, file, old, new, sentence):
    text = (tree.parent / file).read_text(encoding="utf-8")
    assert old in text
    world.write(tree.parent, file, text.replace(old, new))
    with pytest.raises(WrongUse, match=sentence):
        release(tree, [], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_a_package_that_cannot_be_built_stops_it(tree, tmp_path):
    world.write(tree.parent, "lib/pyproject.toml", "[build-system")
    said = "No wheels could be built of lib, autograder: tomllib"
    with pytest.raises(GraderFailure, match=said):
        release(tree, [], tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_of_several_assignments_all_are_released_or_none(tree, tmp_path):
    out = tmp_path / "out"
    release(tree, [], out)
    before = world.files(out)
    toy.make_tree(tree.parent, value=toy.source_notebook(setup=f"{toy.SETUP}# changed\n"))
    misspelt = toy.DOUBLE_RANDOM.replace("HIDDEN TESTS", "HIDDEN TEST")
    bad = toy.source_notebook(double_random=misspelt)
    toy.write(tree / "08-bad" / "08-bad.ipynb", bad)
    with pytest.raises(GraderFailure, match="# hint:"):
        release(tree, [], out)
    assert world.files(out) == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["course", "out"]


def test_one_release_replaces_its_own_folder_and_leaves_the_others_alone(tree, tmp_path):
    toy.write(tree / MORE / f"{MORE}.ipynb", toy.source_notebook())
    out = tmp_path / "out"
    release(tree, [], out)
    for name in (toy.NAME, MORE):
        (out / name / "mine.txt").write_text("mine")
    release(tree, [MORE, MORE], out)
    assert (out / toy.NAME / "mine.txt").is_file() and not (out / MORE / "mine.txt").exists()
    assert sorted(path.name for path in out.glob("*.zip")) == [f"{toy.NAME}.zip", f"{MORE}.zip"]
