"""An assignment as a student gets it: one archive, with what to do in a README."""

from __future__ import annotations

import zipfile
from pathlib import Path

from robust_slam_autograder.publishing.course import Course
from robust_slam_autograder.reading import assignment as assignments

README_NAME = "README.txt"
_EPOCH = (1980, 1, 1, 0, 0, 0)
_README = """\
{title}

The notebook says what to write.
You need Python 3.11 or newer; on Windows, WSL.

1. Install, once for all assignments
{install}
2. Open
   Unpack this archive. In the folder {name}:

     jupyter lab {notebook}

   Write your functions in the cells that say so. The cells below each of them
   check your work: run them as often as you like.

3. Check

     autograder check {notebook}

   It runs the checks that you see, from top to bottom. Of each exercise it
   names those that fail, and the likely slip of the first. The mark also
   counts checks that you do not see.

4. Hand in
   Save the notebook and hand in {notebook}: this one file, under this name.
   It need not be finished: every case that passes counts.
"""
_ENVIRONMENT = """\
   In a terminal, in a folder of your own:

     python3 -m venv .venv
     . .venv/bin/activate
     pip install {packages}

   It takes a minute or two, and 1 GB of disk. In every new terminal the second
   line again.{where}
"""
_FROM_GIT = " pip needs git for the third."
_FROM_FOLDER = """

   COURSE is the course's folder, which holds {folders}:
   write its path."""
_ASK = """
   What the notebook imports, JupyterLab and the grader (autograder): your
   instructor says how.
"""


def write(folder: Path, course: Course, archive: Path) -> None:
    """Write the archive of a released assignment; the same release gives the same bytes.

    Args:
        folder: the release, named as the assignment.
        course: where students install from.
        archive: the file to write.
    """
    texts = {path.relative_to(folder).as_posix(): path.read_bytes() for path in _files(folder)}
    texts.setdefault(README_NAME, readme(folder, course).encode())
    # Stored as they are: what a compressor gives depends on its version.
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_STORED) as made:
        for name in sorted(texts):
            entry = zipfile.ZipInfo(f"{folder.name}/{name}", _EPOCH)
            entry.create_system = 3  # Unix, whose modes these are
            entry.external_attr = 0o100644 << 16
            made.writestr(entry, texts[name])


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())


def readme(folder: Path, course: Course) -> str:
    """What a student is to do with a released assignment."""
    title = assignments.load_config(folder / assignments.CONFIG_NAME).title
    notebook = assignments.notebook_path(folder).name
    heading = f"{folder.name}: {title}" if title else folder.name
    return _README.format(
        title=f"{heading}\n{'=' * len(heading)}",
        name=folder.name,
        notebook=notebook,
        install=_install(course),
    )


def _install(course: Course) -> str:
    packages = course.install.get("assignments", {})
    if not packages:
        return _ASK
    if course.repository.url:
        wanted = [course.repository.requirement(name, packages[name]) for name in packages]
        where = _FROM_GIT
    else:
        extras = {name: name[name.find("[") :] if "[" in name else "" for name in packages}
        wanted = [f"COURSE/{packages[name]}{extras[name]}" for name in packages]
        where = _FROM_FOLDER.format(folders=" and ".join(f"{f}/" for f in packages.values()))
    lines = " \\\n       ".join(f'"{each}"' for each in wanted)
    return _ENVIRONMENT.format(packages=lines, where=where)
