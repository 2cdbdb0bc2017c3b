"""No solution and no hidden test reaches the site or the public course, which holds the release.

Two kinds of canary: text planted into all that is private in a copy of the course, and
every line of the real solutions, hidden regions and answers that is long enough to be
told apart. The copy has a public repository, so it also shows what an address changes.
"""

import functools
import html
import io
import json
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import pytest
from robust_slam_autograder.publishing import course
from robust_slam_autograder.publishing.files import tracked
from robust_slam_autograder.publishing.public import publish

from solutions.classes import answers
from tests.runtime.conftest import RUNTIME, look_for_the_runtime

pytestmark = pytest.mark.long

REGION = re.compile(r"### BEGIN (SOLUTION|HIDDEN TESTS)\n(.*?)### END \1", re.DOTALL)
CANARY = "canary-4c7e"
TELLING = 32
"""Shorter lines, and imports, stand in many a chapter by chance and tell nothing."""
TELLING_OF_AN_ANSWER = 48
"""Answers are plain code of many kinds; more of their lines are alike by chance."""
MARKERS = ("BEGIN HIDDEN TESTS", "BEGIN SOLUTION", "# hint:")
HTML = answers.ROOT / "build" / "html"
NAMES = answers.assignments()
ADDRESS = "https://github.com/owner/course"
PRIVATE = (
    *(".ci/", "README.md", "instructor.mk"),
    *("solutions/course.toml", "solutions/answers/", "solutions/classes/", "solutions/manual/"),
    *("tests/assignments/", "tests/runtime/test_lab.py", "tests/runtime/test_truth.py"),
    *("tests/grader/test_formgrader.py", "tests/course/exercises/"),
    *("tests/test_secrets.py", "tests/test_shown_class.py"),
)
"""What stays here beside the notebooks: said once more, for ``course.toml`` may list too much."""


def telling(name: str, texts: Iterable[str], shortest: int) -> frozenset[str]:
    """Lines of texts that are long enough to tell, and that no student of an assignment sees."""
    cells = ["".join(c["source"]) for c in answers.source_notebook(name)["cells"]]
    shown = {line.strip() for cell in cells for line in REGION.sub("", cell).split("\n")}
    lines = {line.strip() for text in texts for line in text.split("\n")} - shown
    return frozenset(each for each in lines if len(each) >= shortest and "import " not in each)


@functools.cache
def secret_lines(name: str) -> frozenset[str]:
    """Lines that only the instructor has."""
    cells = ["".join(c["source"]) for c in answers.source_notebook(name)["cells"]]
    regions = (found[2] for cell in cells for found in REGION.finditer(cell))
    return telling(name, regions, TELLING)


def manual_lines() -> set[str]:
    pages = (path.read_text("utf-8") for path in (answers.SOLUTIONS / "manual").glob("*.md"))
    lines = {line.strip() for page in pages for line in page.split("\n")}
    return {line for line in lines if len(line) >= TELLING_OF_AN_ANSWER}


def answer_lines(name: str) -> frozenset[str]:
    """Lines of the right and wrong answers to an assignment that students are not shown."""
    files = [path for path in (answers.ANSWERS / name).iterdir() if path.is_file()]
    return telling(name, (path.read_text("utf-8") for path in files), TELLING_OF_AN_ANSWER)


def files_below(folder: Path) -> Iterator[tuple[Path, str]]:
    """Every file's text; an archive's files stand below the archive's name."""
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        if path.suffix in (".zip", ".whl"):
            with zipfile.ZipFile(path) as archive:
                for name in archive.namelist():
                    yield path / name, archive.read(name).decode("utf-8", "replace")
        else:
            yield path, path.read_text(encoding="utf-8", errors="replace")


def texts_in(value: object) -> Iterator[str]:
    """Every text in a value of JSON; a list of texts, as nbformat has it, is one."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, dict):
        yield from (text for part in value.values() for text in texts_in(part))
    elif isinstance(value, list) and all(isinstance(part, str) for part in value):
        yield "".join(value)
    elif isinstance(value, list):
        yield from (text for part in value for text in texts_in(part))


def plain_lines(path: Path, text: str) -> set[str]:
    """A file's lines as a reader sees them: without markup, all that a notebook holds as text."""
    if path.suffix in (".ipynb", ".json"):
        text = "\n".join(texts_in(json.loads(text)))
    elif path.suffix == ".html":
        text = html.unescape(re.sub(r"<[^>]*>", "", text))
    return {line.strip() for line in text.split("\n")}


def marked(files: Iterable[tuple[Path, str]]) -> list[Path]:
    """The files in which a region or a hint stands."""
    return [path for path, text in files if any(mark in text for mark in MARKERS)]


def test_the_site_holds_no_solution_and_no_hidden_test():
    assert (HTML / "index.html").is_file(), "build the site first: make book"
    secrets = {line for name in NAMES for line in secret_lines(name)} | manual_lines()
    pages = [(path, text) for path, text in files_below(HTML) if not is_runtime(path)]
    assert any(path.suffix == ".ipynb" for path, _ in pages), "the pages' sources are there too"
    leaks = ((path.name, plain_lines(path, text) & secrets) for path, text in pages)
    assert not [leak for leak in leaks if leak[1]]
    # The page *Operate* names the marks, for who makes an exercise.
    assert not marked((path, text) for path, text in pages if path.stem != "operate")
    assert not list(HTML.rglob("*solutions*"))


def is_runtime(path: Path) -> bool:
    """Whether a file of the site comes from the runtime, which has a test of its own."""
    parts = path.relative_to(HTML).parts
    return parts[0] == "lab" or parts[:2] in (("python", "pyodide"), ("python", "wheels"))


@pytest.mark.parametrize("place", ["lab", "wheels"])
def test_the_runtime_holds_no_solution_and_no_hidden_test(place):
    """Its packages and notebooks; Pyodide's own files are verified by their checksums."""
    look_for_the_runtime()
    copies = {"lab": HTML / "lab", "wheels": HTML / "python" / "wheels"}
    secrets = {line for name in NAMES for line in secret_lines(name)}
    secrets -= {line for lines in known().values() for line in lines}
    folders = [folder for folder in (RUNTIME / place, copies[place]) if folder.is_dir()]
    for folder in folders:
        files = list(files_below(folder))
        kinds = {path.suffix for path, _ in files}
        assert kinds >= ({".ipynb", ".json"} if place == "lab" else {".py", ".json"})
        assert not [path for path, text in files if plain_lines(path, text) & secrets]
        assert not marked((path, text) for path, text in files if path.suffix == ".ipynb")
        assert not [path for path, text in files if CANARY in text]


def plant_in_notebook(path: Path) -> None:
    """Put a canary into every region, every hint, and an output of every code cell."""
    notebook = json.loads(path.read_text(encoding="utf-8"))
    for number, cell in enumerate(notebook["cells"]):
        source = re.sub(r"# hint:.*", f"\\g<0> {CANARY}", "".join(cell["source"]))
        mark = f"    # {CANARY} {number}\n"
        cell["source"] = re.sub(r"(?m)^ *### END (SOLUTION|HIDDEN TESTS)", mark + r"\g<0>", source)
        if cell["cell_type"] == "code":
            said = {"output_type": "stream", "name": "stdout", "text": f"{CANARY}\n"}
            cell["outputs"] = [said]
    answers.write(path, notebook)


def plant(root: Path) -> int:
    """Put a canary into every file of a course that is private, and into private regions.

    Returns:
        how many files hold one.
    """
    notebooks = sorted(root.glob("solutions/*/*.ipynb"))
    for path in notebooks:
        plant_in_notebook(path)
    whole = [root / name for name in tracked(root) if name.startswith(PRIVATE)]
    for path in [*whole, root / "lib" / "robust_slam" / "untracked.py"]:
        with path.open("a", encoding="utf-8") as file:
            file.write(f"\n# {CANARY}\n")
    return sum(CANARY in text for _, text in files_below(root))


@pytest.fixture(scope="module")
def public(tmp_path_factory):
    """The public course of a copy that has an address, and a canary in all that is private."""
    root = tmp_path_factory.mktemp("planted") / "course"
    names = tracked(answers.ROOT)
    for name in names:
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(answers.ROOT / name, root / name)
    settings = root / "_config.yml"
    text, count = re.subn(r"(?m)^  url: .*$", f'  url: "{ADDRESS}"', settings.read_text("utf-8"))
    assert count == 1, "one setting in one place"
    settings.write_text(text, encoding="utf-8")
    for command in (["init", "-q"], ["add", "-A"]):
        subprocess.run(["git", "-C", str(root), *command], check=True)
    private = [name for name in names if name.startswith(PRIVATE)]
    assert plant(root) == len(NAMES) + len(private) + 1
    out = root.with_name("public")
    publish(root / "solutions", out)
    return out


@pytest.fixture(scope="module")
def files(public):
    """The public course's files with their texts, read once: also what lies in archives."""
    return list(files_below(public))


@pytest.fixture(scope="module")
def lines(public, files):
    return {path.relative_to(public).as_posix(): plain_lines(path, text) for path, text in files}


def known() -> Mapping[str, Sequence[str]]:
    """By file the lines that are like a secret one by chance."""
    return course.load(answers.SOLUTIONS).public.known


class TestPublicCourse:
    """What ``make public`` writes, of a copy of this course in which all private is marked."""

    def test_no_canary_reaches_the_public_course_nor_a_region_or_hint_in_a_notebook(self, files):
        """The first one waits for a copy of the repository and the public course made of it."""
        assert len(files) > 250
        assert not [path for path, text in files if CANARY in text]
        notebooks = [(path, text) for path, text in files if path.suffix == ".ipynb"]
        assert len(notebooks) > 2 * len(NAMES)
        assert not marked(notebooks)

    def test_its_assignments_carry_the_packages_and_no_canary(self, public):
        for name in NAMES:
            with zipfile.ZipFile(public / "assignments" / f"{name}.zip") as archive:
                wanted = archive.read(f"{name}/requirements.txt").decode().splitlines()
                packages = [line.partition("[")[0] for line in wanted if line.startswith("./")]
                held = [archive.read(f"{name}/{path.removeprefix('./')}") for path in packages]
            assert len(packages) == 3 and ("[sdp]" in wanted[0]) == (name == "07-certificates")
        for wheel in held:
            with zipfile.ZipFile(io.BytesIO(wheel)) as archive:
                assert not [n for n in archive.namelist() if CANARY.encode() in archive.read(n)]

    def test_it_passes_its_own_lint(self, public):
        """With an address the chapters have one cell more than here, where lint looks."""
        for command in (["check"], ["format", "--check"]):
            ruff = [sys.executable, "-m", "ruff", *command, "--no-cache", "."]
            done = subprocess.run(ruff, cwd=public, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stdout

    @pytest.mark.parametrize(("lines_of", "least"), [(secret_lines, 200), (answer_lines, 1000)])
    def test_it_holds_no_line_of_a_solution_a_hidden_test_or_an_answer(
        self, lines, lines_of, least
    ):
        secrets = {line for name in NAMES for line in lines_of(name)}
        assert len(lines) > 250 and len(secrets) > least
        alike = known()
        assert len(alike) < 10
        assert not [name for name in alike if name.startswith("assignments/")]
        found = {name: held & secrets - set(alike.get(name, ())) for name, held in lines.items()}
        assert not {name: leaked for name, leaked in found.items() if leaked}
        for name in NAMES:
            for folder in (name, f"{name}.zip/{name}"):
                assert len(lines[f"assignments/{folder}/{name}.ipynb"]) > 100

    def test_it_holds_no_history_and_no_private_file(self, public):
        names = {path.relative_to(public).as_posix() for path in public.rglob("*")}
        for private in ("solutions", ".git", "tests/assignments", "instructor.mk", "build"):
            assert private not in names
        tests = {path for path in names if path.startswith("tests/") and path.endswith(".py")}
        telling = ("tests.assignments", "solutions.classes", "tests.test_secrets")
        texts = ((public / name).read_text() for name in tests)
        assert not [text for text in texts if any(word in text for word in telling)]
        paths = [
            *(answers.ROOT / "tests" / "assignments").rglob("*.py"),
            *(path for kind in ("*.py", "*.ipynb") for path in answers.SOLUTIONS.rglob(kind)),
            *answers.ANSWERS.rglob("*.toml"),
        ]
        private = {path.read_bytes() for path in paths} - {b""}
        assert not [p for p in public.rglob("*") if p.is_file() and p.read_bytes() in private]

    def test_it_holds_each_assignment_twice_and_stands_on_its_own(self, public):
        for name in NAMES:
            folder = public / "assignments"
            with zipfile.ZipFile(folder / f"{name}.zip") as archive:
                notebook = archive.read(f"{name}/{name}.ipynb")
            assert (folder / name / f"{name}.ipynb").read_bytes() == notebook
        needed = ("README.md", ".gitignore", "LICENSE", "LICENSE-text", "requirements.lock")
        assert not [name for name in needed if not (public / name).is_file()]
        readme = (public / "README.md").read_text(encoding="utf-8")
        assert "Keep this repository private" not in readme and "make public" not in readme
        assert "solutions/" not in readme

    def test_every_make_target_that_its_texts_name_is_there(self, public, lines):
        named: dict[str, set[str]] = {}
        for name, held in lines.items():
            is_text = name.endswith((".md", ".ipynb", ".txt")) and not name.startswith("tests/")
            if is_text and not name.endswith("operate.md"):  # it is about the private repository
                for target in re.findall(r"(?:^|`)make ([a-z]+)", "\n".join(held), re.M):
                    named.setdefault(target, set()).add(name)
        assert set(named) >= {"book", "test", "lab"}
        there = set(re.findall(r"(?m)^([a-z]+):", (public / "Makefile").read_text("utf-8")))
        assert not {target: names for target, names in named.items() if target not in there}

    def test_every_path_that_its_readmes_name_is_there(self, public):
        """Links and tables; build/ is made, and a solution tree is what graders bring."""
        for readme in (public / "README.md", public / "autograder" / "README.md"):
            text = readme.read_text(encoding="utf-8")
            linked = re.findall(r"\]\((?!https?:|#)([^)#]+)", text)
            assert not [name for name in linked if not (readme.parent / name).exists()]
        rows = re.findall(r"(?m)^\| `([^`]+)`", (public / "README.md").read_text("utf-8"))
        assert len(rows) > 4
        assert not [row for row in rows if row != "build/" and not (public / row).exists()]

    def test_all_is_installed_from_the_one_address(self, public, files):
        folders = (public / "chapters", public / "assignments")
        texts = [text for path, text in files if any(map(path.is_relative_to, folders))]
        named = {found for text in texts for found in re.findall(r"git\+([^@\s]*)@", text)}
        assert named == {ADDRESS}

    @pytest.mark.rest
    def test_its_tests_can_all_be_collected_and_those_of_the_house_pass(self, public):
        """A second pytest imports all tests there; one that reads solutions then would fail.

        What these look at differs there; `make soak` runs all of its tests.
        """
        house = "test_house.py or test_docstrings.py or test_version.py"
        command = [sys.executable, "-m", "pytest", "-q", "--assert=plain"]
        command += ["-p", "no:cacheprovider", "-k", house]
        done = subprocess.run(command, cwd=public, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout[-3000:]
        (passed, others) = re.findall(r"(\d+) passed, (\d+) deselected", done.stdout)[0]
        assert int(passed) > 5 and int(others) > 500

    def test_a_line_that_somebody_adds_would_be_found(self, tmp_path):
        """The canary lives: it sees any telling line of any assignment, wherever it is put."""
        for name in NAMES:
            secret = max(secret_lines(name))
            cell = {"cell_type": "code", "source": ["x = 1\n", f"  {secret}\n"], "outputs": []}
            plant = tmp_path / name
            plant.mkdir()
            (plant / "a.py").write_text(f"x = 1\n    {secret}\n", encoding="utf-8")
            words = " ".join(f"<i>{html.escape(word)}</i>" for word in secret.split(" "))
            (plant / "e.html").write_text(f"<pre>\n    {words}\n</pre>", encoding="utf-8")
            (plant / "b.ipynb").write_text(json.dumps({"cells": [cell]}), encoding="utf-8")
            for archived in ("c.zip", "d.whl"):
                with zipfile.ZipFile(plant / archived, "w") as archive:
                    archive.write(plant / "b.ipynb", "d/b.ipynb")
            found = [path.name for path, text in files_below(plant)
                     if secret in plain_lines(path, text)]  # fmt: skip
            assert found == ["a.py", "b.ipynb", "b.ipynb", "b.ipynb", "e.html"]
