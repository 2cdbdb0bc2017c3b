"""A small course in a repository of its own: the toy assignment, a book, a library, tests."""

import json
import subprocess
from pathlib import Path

from .. import toy

URL = "https://github.com/owner/course"
COURSE = """\
[install]
tools = ["a-lab>=4"]
[install.book]
toy-library = "lib"
[install.assignments]
toy-library = "lib"
the-grader = "autograder"
[install.also]
07-toy = ["toy-library[extra]"]
[public]
files = [
  "LICENSE", "run.sh", "autograder/", "chapters/", "lib/", "tests/__init__.py",
  "tests/lib/",
]
without = ["lib/private/"]
readme = "public.md"
"""
PROJECT = """\
[build-system]
requires = ["hatchling"]
build-backend = "hatchling.build"
[project]
name = "{name}"
version = "1.0"
requires-python = ">=3.11"
[project.optional-dependencies]
extra = ["numpy"]
"""
BOOK = "repository:\n  url: {url}\n"


def make(root: Path, url: str = "") -> Path:
    """Write the course, have git track it, and give its source tree."""
    tree = toy.make_tree(root, 'title = "Double and apply"\n')
    chapter = toy.notebook([{**toy.cell("# One"), "id": "intro", "cell_type": "markdown"}])
    chapter["cells"].append({**toy.cell("import toy_library"), "id": "imports"})
    texts = {
        "solutions/course.toml": COURSE,
        "_config.yml": BOOK.format(url=url or '""'),
        "README.md": "Keep this to yourself.\n",
        "solutions/public.md": "# Toy\n",
        "LICENSE": "free",
        "run.sh": "#!/bin/sh\n",
        "chapters/00-one.ipynb": json.dumps(chapter),
        "autograder/pyproject.toml": PROJECT.format(name="the-grader"),
        "autograder/the_grader.py": "",
        "lib/pyproject.toml": PROJECT.format(name="toy-library"),
        "lib/toy_library.py": "def double(x):\n    return x + x\n",
        "lib/private/notes.md": "notes",
        "tests/__init__.py": "",
        "tests/answers.py": toy.APPLY,
        "tests/lib/test_library.py": "import json\n\nfrom toy_library import double\n",
        "tests/test_answers.py": "from tests import answers\n",
    }
    for name, text in texts.items():
        write(root, name, text)
    (root / "run.sh").chmod(0o755)
    subprocess.run(["git", "-C", str(root), "init", "-q"], check=True)
    track(root)
    return tree


def write(root: Path, name: str, text: str) -> None:
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def track(root: Path) -> None:
    subprocess.run(["git", "-C", str(root), "add", "-A"], check=True)


def files(folder: Path) -> dict[str, bytes]:
    """Every file below a folder, and what is in it."""
    paths = [path for path in folder.rglob("*") if path.is_file()]
    found = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    return dict(sorted(found.items()))
