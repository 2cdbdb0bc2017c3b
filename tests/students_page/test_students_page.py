"""What the students' page and a zip's README say to type works as it is printed.

A new user unpacks a zip into an empty home and types the lines. The quick test lends the
packages of this environment, so that pip installs the zip's own wheels and nothing else; the
long one installs everything.
"""

import json
import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Mapping
from pathlib import Path

import pytest
from robust_slam_autograder.publishing.handout import INSTALL
from robust_slam_autograder.publishing.student_release import release

from autograder.tests.as_user import ROOT
from autograder.tests.ci.running import NETWORK, OFFLINE, PACKAGES
from solutions.classes import answers
from tests.operate_page import page
from tests.operate_page.terminal import Said, Terminal

pytestmark = pytest.mark.rest

TEXT = page.source(ROOT / "chapters" / "students.md")
TYPED = [command.text for block in page.blocks(TEXT) for command in page.commands(block)]
FIRST, SECOND = "00-one-lie", "07-certificates"
CHECK = f"autograder check {FIRST}.ipynb"
HALF = """\
def total_cost(x, i, j, z, sigma):
    x = np.asarray(x)
    return np.sum(((x[j] - x[i] - z) / sigma) ** 2) / 2
"""


@pytest.fixture(scope="module")
def zips(tmp_path_factory):
    folder = tmp_path_factory.mktemp("release")
    release(answers.SOLUTIONS, [FIRST, SECOND], folder)
    return folder


def hidden_cases() -> int:
    """How many cases of the first assignment hold checks that students do not see."""
    return sum(case.has_hidden for case in answers.load(FIRST).cases)


def unpack(zips: Path, name: str, home: Path) -> Path:
    with zipfile.ZipFile(zips / f"{name}.zip") as archive:
        archive.extractall(home)
    return home / name


def environment(home: Path, more: Mapping[str, str]) -> dict[str, str]:
    """What a new user has: Python, a home, and nothing of these tests' environment."""
    path = f"{sys.base_prefix}/bin:/usr/local/bin:/usr/bin:/bin"
    return {"PATH": path, "HOME": str(home), "LANG": "C.UTF-8", **more}


def write_answers(notebook: Path, texts: Mapping[str, str]) -> None:
    value = json.loads(notebook.read_text("utf-8"))
    for cell in value["cells"]:
        known = cell["metadata"].get("nbgrader", {})
        if known.get("solution"):
            cell["source"] = texts[known["grade_id"]]
    notebook.write_text(json.dumps(value), "utf-8")


@pytest.fixture
def shell(tmp_path, zips):
    """A new user's terminal, in the folder that they have unpacked."""
    place = unpack(zips, FIRST, tmp_path / "home")
    # Two packages that jsonschema's extra names are not in this environment.
    offline = {**OFFLINE, "PIP_NO_DEPS": "1"}
    terminal = Terminal(place, environment(place.parent, offline), tmp_path / "log")
    yield terminal
    terminal.close()


def lend_packages(environment: Path) -> None:
    """Give an environment what pip took for installed."""
    (site,) = environment.glob("lib/python*/site-packages")
    here = {path.name for path in site.iterdir()}
    for path in Path(PACKAGES).iterdir():
        if path.name not in here and path.suffix != ".pth":
            (site / path.name).symlink_to(path)


def type_in(shell: Terminal, *commands: str) -> list[Said]:
    said = [shell.run(command) for command in commands]
    assert not [each for each in said if each.status], said
    return said


def test_the_page_and_the_readme_say_the_same_lines(zips):
    with zipfile.ZipFile(zips / f"{FIRST}.zip") as archive:
        readme = archive.read(f"{FIRST}/README.txt").decode()
    assert [*INSTALL, f"jupyter lab {FIRST}.ipynb", CHECK, "jupyter lab 03-irls.ipynb"] == TYPED
    shown = [line.strip() for line in readme.splitlines() if line.startswith("     ")]
    assert shown == TYPED[:5]


def test_the_page_lists_every_assignment():
    listed = re.findall(r"^\| `([^`]+)\.zip` \|", TEXT, re.M)
    assert listed == answers.assignments()


@pytest.mark.long
def test_who_types_the_lines_has_a_check(tmp_path, zips, shell):
    """A new environment gets pip, which then installs the wheels of two assignments."""
    type_in(shell, *INSTALL)
    lend_packages(tmp_path / "home" / ".venv")
    type_in(shell, "unset PYTHONPATH")
    folder = Path(type_in(shell, "pwd")[0].text.strip())
    right = {a.exercise: a.source for a in answers.answers(FIRST) if a.is_right}
    write_answers(folder / f"{FIRST}.ipynb", right | {"total_cost": HALF})
    said = shell.run(CHECK)
    shown = next(block for block in page.blocks(TEXT) if block.kind == "text")
    assert said.status == 1
    lines = shown.body.splitlines()
    assert [line for line in said.text.splitlines() if line in lines] == lines
    assert said.text.splitlines()[-1] == (
        f"Visible cases passed in 3 of 4 exercises; {hidden_cases()} hidden cases remain when it "
        "is graded."
    )
    # "For the next assignment … type the second and the third line in its folder."
    unpack(zips, SECOND, folder.parent)
    type_in(shell, f"deactivate; cd ../{SECOND}", *INSTALL[1:])
    again = shell.run(f"autograder check {SECOND}.ipynb")
    assert again.status == 1 and "Not written yet" in again.text


BLOCKED = """
import sys

class Refused:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {names!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Refused())
from robust_slam_autograder.cli import main
sys.exit(main(sys.argv[1:]))
"""
FOR_INSTRUCTORS = (
    "alembic", "cvxpy", "distributed", "ipywidgets", "jinja2", "markupsafe", "nbformat",
    "nbgrader", "sqlalchemy", "tqdm", "yaml",
)  # fmt: skip


def run_without(names: tuple[str, ...], *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run the grader's command where some modules are not installed."""
    command = [sys.executable, "-c", BLOCKED.format(names=names), *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT)


def test_check_needs_no_package_of_the_instructors(tmp_path, zips):
    place = unpack(zips, FIRST, tmp_path)
    right = {a.exercise: a.source for a in answers.answers(FIRST) if a.is_right}
    write_answers(place / f"{FIRST}.ipynb", right)
    done = run_without(FOR_INSTRUCTORS, "check", str(place / f"{FIRST}.ipynb"))
    assert done.returncode == 0, done.stdout + done.stderr
    assert f"All visible cases passed; {hidden_cases()} hidden cases" in done.stdout


def test_an_instructors_command_says_what_to_install(tmp_path):
    done = run_without(FOR_INSTRUCTORS, "release", "--out", str(tmp_path / "release"))
    assert done.returncode == 2
    assert 'pip install "./autograder[grading]"' in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.soak
def test_a_fresh_install_is_as_large_as_the_page_says(tmp_path, zips):
    """With a network: nothing is lent."""
    home = tmp_path / "home"
    network = {key: os.environ[key] for key in NETWORK if key in os.environ}
    for name, megabytes in ((FIRST, 600), (SECOND, 800)):
        place = unpack(zips, name, home)
        terminal = Terminal(place, environment(home, network), tmp_path / "log")
        try:
            type_in(terminal, *INSTALL, "jupyter lab --version")
            said = terminal.run(f"autograder check {name}.ipynb")
            size, listed = type_in(terminal, "du -sm ../.venv", "pip list --format=freeze")
        finally:
            terminal.close()
        assert said.status == 1 and "Not written yet" in said.text
        assert megabytes - 100 < int(size.text.split()[0]) <= megabytes
        installed = {line.split("==")[0].lower() for line in listed.text.splitlines()}
        assert not installed & {"nbgrader", "sqlalchemy", "alembic", "ipywidgets"}
        assert ("cvxpy" in installed) == (name == SECOND)
        assert 90 < len(installed) < 125
