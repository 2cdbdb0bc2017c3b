"""The public course is what is listed and no answer; where it would tell, nothing is written."""

import json
import os
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing import public
from robust_slam_autograder.publishing.public import install_cell, publish

from .. import toy
from ..as_user import ended
from . import world

pytestmark = pytest.mark.rest

SECRET = "history.append(f(history[-1])) or None"
"""A telling line, once the toy's solution has it."""


@pytest.fixture
def tree(tmp_path):
    """The source tree of a course whose solution has a telling line."""
    tree = world.make(tmp_path / "course")
    apply = toy.APPLY.replace("history.append(f(history[-1]))", SECRET)
    toy.write(tree / toy.NAME / f"{toy.NAME}.ipynb", toy.source_notebook(apply=apply))
    return tree


@pytest.fixture
def out(tmp_path):
    return tmp_path / "public"


def test_it_holds_what_is_listed_and_tracked_and_the_release(tree, out):
    (tree.parent / "lib" / "marks.csv").write_text("a student,3\n")
    written = publish(tree, out)
    assert written == list(world.files(out)) == [
        "LICENSE",
        "README.md",
        f"assignments/{toy.NAME}.zip",
        f"assignments/{toy.NAME}/{toy.NAME}.ipynb",
        f"assignments/{toy.NAME}/autograder.toml",
        "autograder/pyproject.toml",
        "autograder/the_grader.py",
        "chapters/00-one.ipynb",
        "lib/pyproject.toml",
        "lib/toy_library.py",
        "run.sh",
        "tests/__init__.py",
        "tests/lib/test_library.py",
    ]  # fmt: skip
    assert os.access(out / "run.sh", os.X_OK) and not os.access(out / "LICENSE", os.X_OK)
    assert (out / "README.md").read_text() == "# Toy\n"
    book = "chapters/00-one.ipynb"  # it installs nothing where there is no address
    assert (out / book).read_bytes() == (tree.parent / book).read_bytes()
    assert not [data for data in world.files(out).values() if SECRET.encode() in data]


def test_it_replaces_the_one_before_as_a_whole(tree, tmp_path, out):
    publish(tree, out)
    before = world.files(out)
    (out / "lib" / "old.py").write_text("")
    (tmp_path / ".public.part").mkdir()  # of a run that was killed
    (tmp_path / ".public.part" / "half").touch()
    publish(tree, out)
    assert world.files(out) == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["course", "public"]


def chapter(source: str, **outputs: str) -> str:
    made = [{"output_type": "stream", "name": n, "text": text} for n, text in outputs.items()]
    return json.dumps(toy.notebook([toy.cell(source) | {"outputs": made}]))


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("lib/toy_library.py", f"def double(x):\n    {SECRET}\n"),
        ("lib/data.txt", f"first\r\n\t{SECRET}\r\n"),
        ("chapters/00-one.ipynb", chapter(f"def a():\n  {SECRET}\n")),
        ("chapters/00-one.ipynb", chapter("1", stdout=f"it was\n    {SECRET}\n")),
        ("lib/deep.json", json.dumps({"a": [{f"x\n{SECRET}\ny": 1}]})),
        ("tests/lib/test_library.py", f'TEXT = """\n{SECRET}\n"""\n'),
        ("solutions/public.md", f"# Toy\n\n    {SECRET}\n"),
        ("lib/toy_library.py", "last, history = apply(lambda value: 3 * value, start, 4)"),
        ("lib/toy_library.py", "# hint: Call f once per time, each time with the value before."),
    ],
    ids=["code", "text", "cell", "output", "json", "string", "readme", "hidden-test", "hint"],
)  # fmt: skip
def test_a_file_that_tells_stops_it_and_leaves_what_was_there(tree, tmp_path, out, name, text):
    world.write(out, f"assignments/{toy.NAME}.zip", "the release before")
    before = world.files(out)
    world.write(tree.parent, name, text)
    world.track(tree.parent)
    name = "README.md" if name == "solutions/public.md" else name
    said = f"{name} would tell a line .* of {toy.NAME} .* Nothing written"
    with pytest.raises(GraderFailure, match=said):
        publish(tree, out)
    assert world.files(out) == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["course", "public"]


def test_a_known_line_is_let_through_in_its_own_file_alone(tree, out):
    known = f"[public.known]\n'lib/toy_library.py' = ['{SECRET}']\n"
    world.write(tree.parent, "solutions/course.toml", world.COURSE + known)
    world.write(tree.parent, "lib/toy_library.py", f"{SECRET}\n")
    assert publish(tree, out)
    world.write(tree.parent, "LICENSE", f"{SECRET}\n")
    with pytest.raises(GraderFailure, match="LICENSE would tell"):
        publish(tree, out)


def test_an_import_of_a_solution_tells_nothing(tree, out):
    line = "from scipy.sparse.linalg import spsolve_triangular"
    apply = toy.APPLY.replace("    history = [x]", f"    {line}\n    history = [x]")
    toy.make_tree(tree.parent, value=toy.source_notebook(apply=apply))
    world.write(tree.parent, "lib/toy_library.py", f"{line}\n")
    assert publish(tree, out)


def add_an_archive(root: Path) -> None:
    with zipfile.ZipFile(root / "lib" / "more.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a/b.py", f"x = 1\n{SECRET}\n")


def add_a_link(root: Path) -> None:
    (root / "lib" / "more.py").symlink_to("../solutions/course.toml")


@pytest.mark.parametrize(
    ("add", "sentence"),
    [(add_an_archive, r"lib/more\.zip would tell"), (add_a_link, "no plain file")],
)
def test_an_archive_is_looked_into_and_a_link_is_not_followed(tree, out, add, sentence):
    add(tree.parent)
    world.track(tree.parent)
    with pytest.raises(GraderFailure, match=sentence):
        publish(tree, out)
    assert not out.exists()


@pytest.mark.parametrize(
    "line",
    [
        "from tests.answers import apply",
        "from tests import answers",
        "import tests.answers as a",
        "def later():\n    from .. import answers",
        "from ..answers import apply",
    ],
)
def test_a_test_that_imports_what_stays_private_stops_it(tree, out, line):
    world.write(tree.parent, "tests/lib/test_new.py", f"{line}\n")
    world.track(tree.parent)
    with pytest.raises(GraderFailure, match=r"tests/lib/test_new\.py imports tests/answers\.py"):
        publish(tree, out)
    assert not out.exists()


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ('"LICENSE"', '"LICENCE"', "lists LICENCE, and git tracks no such file"),
        ('"lib/private/"', '"lib/privat/"', "lists lib/privat/, and git tracks no such file"),
        ('"lib/private/"', '"../notes"', "without must be a list of paths inside"),
        ("files = ", "file = ", "unknown key 'file'"),
        ("[public]", "[public.known]\nx = 3\n[public]", "x has a value of the wrong type"),
        ('"autograder"', '"../autograder"', r"\[install.assignments\] takes package = its folder"),
        ("[public]", "[public", "is not valid TOML"),
        (world.COURSE[world.COURSE.index("[public]") :], "", r"has no \[public\]"),
    ],
)
def test_what_is_wrong_in_the_list_is_named(tree, out, old, new, sentence):
    world.write(tree.parent, "solutions/course.toml", world.COURSE.replace(old, new))
    with pytest.raises(WrongUse, match=sentence):
        publish(tree, out)
    assert not out.exists()


OTHERS: dict[str, Callable[[Path], object]] = {
    "a repository": lambda out: world.write(out, ".git/HEAD", "ref: refs/heads/main"),
    "a folder": lambda out: world.write(out, "letters.txt", "mine"),
    "a file": Path.touch,
}


@pytest.mark.parametrize("make", OTHERS.values(), ids=OTHERS)
def test_nothing_else_is_overwritten(tree, tmp_path, out, make):
    make(out)
    before = world.files(tmp_path)
    with pytest.raises(WrongUse, match="--out DIR"):
        publish(tree, out)
    assert world.files(tmp_path) == before


@pytest.mark.parametrize("where", [".", "..", "solutions", "solutions/x"])
def test_the_course_itself_is_never_overwritten(tree, where):
    with pytest.raises(WrongUse, match="holds the course's own files"):
        publish(tree, tree.parent / where)


def test_without_git_it_says_so(tmp_path):
    tree = toy.make_tree(tmp_path)
    world.write(tmp_path, "solutions/course.toml", world.COURSE)
    with pytest.raises(WrongUse, match=r"git cannot say .* not a git repository"):
        publish(tree, tmp_path / "public")


class TestInstallCell:
    """With a repository's address the book's notebooks can install what they need."""

    def test_it_stands_before_the_first_code(self, tmp_path, out):
        publish(world.make(tmp_path / "course", f"{world.URL}/"), out)
        value = json.loads((out / "chapters" / "00-one.ipynb").read_bytes())
        assert [cell["id"] for cell in value["cells"]] == ["intro", "install", "imports"]
        cell = value["cells"][1]
        assert cell["metadata"]["tags"] == ["remove-cell"]
        source = "".join(cell["source"])
        assert f'where = "git+{world.URL}@main#subdirectory=lib"' in source
        assert '%pip install -q "toy-library @ {where}"' in source
        assert "sys.version_info < (3, 11)" in source, "as the library's pyproject.toml says"

    @pytest.mark.parametrize(
        ("present", "python"), [(True, (3, 99)), (False, (3, 0)), (False, (3, 99))]
    )
    def test_it_installs_only_what_is_missing_and_says_if_that_failed(self, present, python):
        """IPython runs the cell, and a magic of ours, which installs nothing, stands for pip."""
        package = "robust-slam-autograder" if present else "no-such-library[extra]"
        repository = public.Repository(world.URL)
        source = "".join(install_cell({package: "some/folder"}, repository, python)["source"])
        program = (
            "from IPython.core.interactiveshell import InteractiveShell\n"
            "shell = InteractiveShell.instance()\n"
            "shell.register_magic_function(lambda line: print(line), 'line', 'pip')\n"
            f"print(repr(shell.run_cell({source!r}).error_in_exec))"
        )
        done = ended([sys.executable, "-c", program], check=True)
        wanted = f'install -q "{package} @ git+{world.URL}@main#subdirectory=some/folder"'
        said = done.stdout.strip().splitlines()
        if present:
            assert said == ["None"]
        elif python > sys.version_info:
            assert wanted not in said
            assert said[-1].startswith("ImportError('The library needs a newer Python than 3.")
        else:
            assert said[0] == wanted and said[-1].startswith("ImportError('The library was not")


def test_the_command_says_where_it_is(tree, out, autograder):
    command = ("--solutions", tree, "public", "--out")
    assert autograder(*command, out).worked(f"public course of 13 files: {out}")
    assert autograder(*command, tree)[0] == 2
