"""A clean clone, and what it is lent so that its doors need neither network nor minutes."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from autograder.tests.as_user import ROOT
from autograder.tests.ci.running import repository
from solutions.classes import answers
from tests.book.built_site import built

ASSIGNMENTS = ("02-four-costs", "03-irls")
"""Those that the page names."""
_MADE = (Path("build", "_build", ".jupyter_cache"), Path("build", "fonts"))
_BUILDER = f"#!/bin/sh\nmkdir -p build/_build && cp -R {ROOT}/build/_build/html build/_build/\n"
"""In place of the book's builder: copies the book that these tests have built."""


def make(folder: Path) -> None:
    """Copy what git tracks, and what it would, with some of the assignments: a repository."""
    command = ["git", "-C", str(ROOT), "ls-files", "-z", "-co", "--exclude-standard"]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    left_out = {*answers.assignments()} - {*ASSIGNMENTS}
    for name in filter(None, listed.split("\0")):
        if (ROOT / name).is_file() and not left_out.intersection(Path(name).parts):
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)
    repository(folder)


def lend_environment(folder: Path) -> None:
    """Let make find the environment of these tests, as if it had set one up in the clone."""
    own = folder / ".venv"
    own.mkdir()
    for path in Path(sys.prefix).iterdir():
        if path.name not in (".ready", "bin"):
            (own / path.name).symlink_to(path)
    (own / "bin").mkdir()
    for path in Path(sys.prefix, "bin").iterdir():
        (own / "bin" / path.name).symlink_to(path)
    (own / ".ready").touch()


def lend_book(folder: Path, *, pages: bool) -> None:
    """Build the book here, and lend its executed notebooks and its fonts: none is made twice.

    The class on the site is of other assignments, and made by tests of its own. With ``pages``
    the clone, which has an environment, is lent those too, by a builder that copies them.
    """
    built()
    for part in _MADE:
        shutil.copytree(ROOT / part, folder / part)
    (folder / "build" / "shown").mkdir()
    (folder / "build" / ".misconceptions").touch()
    (folder / "build" / "shown" / ".pages").touch()
    if pages:
        builder = folder / ".venv" / "bin" / "jupyter-book"
        builder.unlink()
        builder.write_text(_BUILDER)
        builder.chmod(0o755)


def environment(home: Path) -> dict[str, str]:
    """A new user's, on a machine that must not set the environment up again."""
    apart = Path(sys.prefix, "bin")
    folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
    path = os.pathsep.join(name for name in folders if Path(name) != apart)
    # Notebooks run again where other public graphs are there than those that they showed.
    data = {name: value for name, value in os.environ.items() if name == "ROBUST_SLAM_DATA"}
    # make would write through the lent environment's links: without a Python it cannot.
    return data | {"PATH": path, "HOME": str(home), "LANG": "C.UTF-8", "PYTHON": "false"}
