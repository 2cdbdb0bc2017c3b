"""An assignment as a student gets it: one archive, with what to do in a README."""

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


def write(folder: Path, course: Course, wheels: Mapping[str, Path], archive: Path) -> None:
    """Write the archive of a released assignment, with the course's packages by their names.

    The folder is named as the assignment. The same release gives the same bytes.
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
    """Return what pip installs for an assignment: the wheels beside it, and the course's tools."""
    packages = course.packages(name)
    lines = [
        f"./{PACKAGES_NAME}/{wheels[name_of(package)].name}{package[len(name_of(package)) :]}"
        for package in packages
    ]
    return "".join(f"{line}\n" for line in [*lines, *course.install.tools])


def readme(folder: Path, course: Course) -> str:
    """Return what a student is to do with a released assignment."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # of the extra `grading`

    title = assignments.load_config(folder / assignments.CONFIG_NAME).title
    templates = Environment(
        loader=PackageLoader(__package__),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return templates.get_template(README_NAME).render(
        heading=f"{folder.name}: {title}" if title else folder.name,
        notebook=assignments.notebook_path(folder).name,
        install=INSTALL if course.install.assignments else (),
        hand_in=" ".join(course.hand_in.split()),
    )
