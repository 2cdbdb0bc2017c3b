"""``autograder init-ci``: every target in a clean folder, nothing replaced unasked."""

import re
import stat
import subprocess
import zipfile
from pathlib import Path

import pytest
import yaml
from robust_slam_autograder import cli
from robust_slam_autograder.ci.workflows import WORKFLOWS
from robust_slam_autograder.commands import init_ci

from .. import toy
from ..publishing import world
from . import running

pytestmark = pytest.mark.rest


@pytest.fixture
def course(tmp_path, monkeypatch):
    """A course with a public repository; the commands run in it."""
    root = tmp_path / "course"
    world.make(root, world.URL)
    world.write(root, "autograder/grader.py", "")
    world.write(root, ".gitignore", "class/\n")
    world.track(root)
    monkeypatch.chdir(root)
    return root


def file_of(target: str, out: Path) -> Path:
    is_archive = target == init_ci.GRADESCOPE
    return out / (f"{toy.NAME}.zip" if is_archive else WORKFLOWS[target].place)


@pytest.mark.parametrize("target", init_ci.TARGETS)
def test_a_target_is_one_file_that_is_replaced_only_by_force(course, tmp_path, target, capsys):
    out = tmp_path / "clean"
    command = ["init-ci", target, "--out", str(out)]
    assert cli.main(command) == 0
    path = file_of(target, out)
    assert [out / name for name in world.files(out)] == [path]
    told = capsys.readouterr().out
    assert f"wrote {path}\n" in told and "\nNext: " in told
    if path.suffix != ".zip":
        text = path.read_text("utf-8")
        assert yaml.safe_load(text) and not re.search(r"@[A-Z_]+@", text)
    path.write_text("mine")
    assert cli.main(command) == 2 and path.read_text() == "mine"
    assert "is there already: --force replaces it" in capsys.readouterr().err
    assert cli.main([*command, "--force"]) == 0 and path.read_bytes() != b"mine"
    assert [p.name for p in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("out", [".", "build/new", "class/tracked"])
def test_an_archive_goes_where_git_does_not_take_it_over(course, out, capsys):
    """It holds answers, hidden tests and what seeds follow from."""
    tracked = course / "class" / "tracked" / f"{toy.NAME}.zip"
    tracked.parent.mkdir(parents=True)
    tracked.touch()
    subprocess.run(["git", "add", "--force", str(tracked)], cwd=course, check=True)
    assert cli.main(["init-ci", "gradescope", "--out", out, "--force"]) == 2
    told = capsys.readouterr().err
    assert f"{toy.NAME}.zip would hold hidden tests, answers" in told and "class/" in told
    assert not (course / out / f"{toy.NAME}.zip").exists() or not tracked.stat().st_size
    assert cli.main(["init-ci", "gradescope"]) == 0


def test_students_install_from_the_public_repository(course):
    for target in ("github-student", "gitlab-student"):
        assert cli.main(["init-ci", target]) == 0
    script = running.load(file_of("gitlab-student", course))["public-checks"]["script"][0]
    assert script == (
        "python -m pip install \\\n"
        f"  'toy-library[extra] @ git+{world.URL}@main#subdirectory=lib' \\\n"
        f"  'the-grader @ git+{world.URL}@main#subdirectory=autograder'\n"
    )
    steps = running.scripts(file_of("github-student", course), "check")
    assert steps["Install"]["run"] == script


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["nowhere"], "invalid choice"),
        (["github-student", "07-toy"], "is for all assignments"),
        (["gradescope", "--install", "x"], "leave out --install"),
        (["gradescope", "08-none"], "has no assignment 08-none; it has 07-toy"),
        (["github-student", "--install", "a\nb"], "cannot be installed"),
        (["github-student", "--install", "${{ secrets.X }}"], "cannot be installed"),
        (["github-student", "--install", " "], "cannot be installed"),
    ],
)
def test_wrong_use_writes_nothing(course, autograder, arguments, sentence):
    before = world.files(course)
    assert autograder("--solutions", "solutions", "init-ci", *arguments).refused(sentence)
    assert world.files(course) == before


@pytest.mark.parametrize("target", ["github-student", "gitlab-student", "gradescope"])
def test_a_course_that_does_not_say_what_to_install_is_told_so(tmp_path, autograder, target):
    toy.make_tree(tmp_path)
    out = tmp_path / "out"
    assert autograder("init-ci", target, "--out", out).refused("course.toml")
    assert not out.exists() or not world.files(out)


def test_what_pip_gets_is_one_word_of_the_shells(course):
    assert cli.main(["init-ci", "github-student", "--install", "a'; touch made; '"]) == 0
    path = file_of("github-student", course)
    script = running.scripts(path, "check")["Install"]["run"]
    assert "'a'\"'\"'; touch made; '\"'\"''" in script


def test_the_archive_is_its_owners_and_has_what_it_needs(course):
    assert cli.main(["init-ci", "gradescope"]) == 0
    path = course / "class" / "gradescope" / f"{toy.NAME}.zip"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        programs = {e.filename for e in archive.infolist() if e.external_attr >> 16 & 0o111}
        seed = archive.read("seed")
        setup = archive.read("setup.sh").decode()
    # At the root of the archive: elsewhere Gradescope does not find them.
    assert programs == {"setup.sh", "run_autograder"}
    assert {"constraints.txt", "lib/toy_library.py", "autograder/grader.py"} < set(names)
    assert [n for n in names if n.startswith("solutions/")] == [
        f"solutions/{toy.NAME}/{toy.NAME}.ipynb",
        f"solutions/{toy.NAME}/autograder.toml",
    ]
    assert '"$source"/\'lib[extra]\' \\\n    "$source"/autograder\n' in setup
    assert cli.main(["init-ci", "gradescope", "--force"]) == 0
    with zipfile.ZipFile(path) as archive:
        assert archive.read("seed") != seed
