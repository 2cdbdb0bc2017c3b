"""An assignment as a student gets it: one archive, with what to do in a README."""

from __future__ import annotations

import textwrap
import zipfile
from collections.abc import Mapping
from pathlib import Path

from robust_slam_autograder.publishing.course import Course, name_of
from robust_slam_autograder.reading import assignment as assignments

README_NAME = "README.txt"
REQUIREMENTS_NAME = "requirements.txt"
PACKAGES_NAME = "packages"
ENVIRONMENT = "../.venv"
"""From an assignment's folder: assignments that are beside each other share it."""
INSTALL = (
    f"python3 -m venv {ENVIRONMENT}",
    f". {ENVIRONMENT}/bin/activate",
    f"pip install -r {REQUIREMENTS_NAME}",
)
"""What a student types in an assignment's folder."""
_IN = "   "
_README = """\
{title}

The notebook says what to write.
You need Python 3.11 or newer; on Windows, WSL.

1. Install
{install}
2. Open
   In the same folder:

     jupyter lab {notebook}

   Write your functions in the cells that say so. The cells below each of them
   check your work: run them as often as you like.

3. Check
   In another terminal, after the second line of 1:

     autograder check {notebook}

   It runs the checks that you see, from top to bottom, and says for each
   exercise what went wrong and why. The mark also counts hidden checks.

4. Hand in
   Save the notebook, {notebook}.
{hand_in}
   It need not be finished: every case that passes counts.
"""
_ENVIRONMENT = """\
   In a terminal, in the folder of this file:

     {}
     {}
     {}

   It takes a minute or two. In every new terminal type the second line again,
   in this folder.
   All assignments share this environment: unpack the next one beside this one,
   and type the second and the third line in its folder.
"""
_ASK = """\
   What the notebook imports, JupyterLab and the grader (autograder): your
   instructor says how. Then go to the folder of this file.
"""


def write(folder: Path, course: Course, wheels: Mapping[str, Path], archive: Path) -> None:
    """Write the archive of a released assignment; the same release gives the same bytes.

    Args:
        folder: the release, named as the assignment.
        course: what students install.
        wheels: the course's packages that students install, by their names.
        archive: the file to write.
    """
    paths = [path for path in folder.rglob("*") if path.is_file()]
    texts = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    texts.setdefault(README_NAME, readme(folder, course).encode())
    if wheels:
        texts.setdefault(REQUIREMENTS_NAME, requirements(folder.name, course, wheels).encode())
        texts |= {f"{PACKAGES_NAME}/{path.name}": path.read_bytes() for path in wheels.values()}
    # Stored as they are: what a compressor gives depends on its version.
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_STORED) as made:
        for name in sorted(texts):
            entry = zipfile.ZipInfo(f"{folder.name}/{name}")  # of no time of its own
            entry.external_attr = 0o100644 << 16
            made.writestr(entry, texts[name])


def requirements(name: str, course: Course, wheels: Mapping[str, Path]) -> str:
    """What pip installs for an assignment: the wheels beside it, and tools from the index."""
    packages = course.packages(name)
    lines = [
        f"./{PACKAGES_NAME}/{wheels[name_of(package)].name}{package[len(name_of(package)) :]}"
        for package in packages
    ]
    return "".join(f"{line}\n" for line in [*lines, *course.install.tools])


def readme(folder: Path, course: Course) -> str:
    """What a student is to do with a released assignment."""
    title = assignments.load_config(folder / assignments.CONFIG_NAME).title
    heading = f"{folder.name}: {title}" if title else folder.name
    return _README.format(
        title=f"{heading}\n{'=' * len(heading)}",
        notebook=assignments.notebook_path(folder).name,
        hand_in=textwrap.fill(course.hand_in, 79, initial_indent=_IN, subsequent_indent=_IN),
        install=_ENVIRONMENT.format(*INSTALL) if course.install.assignments else _ASK,
    )
