"""The packages that students install, built as wheels that travel with an assignment.

A wheel's version names its content: ``0.2.0+d3f2a1c90b7``. So pip, which keeps what it has at the
same version, replaces a package when a later release has changed it, and only then.
"""

import base64
import hashlib
import os
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

from packaging.utils import canonicalize_name

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.publishing.course import COURSE_NAME, Course, name_of
from robust_slam_autograder.publishing.files import chosen, tracked

_BUILD = """\
import os, pkgutil, sys, tomllib
out, *folders = sys.argv[1:]
for folder in folders:
    os.chdir(folder)
    with open("pyproject.toml", "rb") as file:
        backend = tomllib.load(file)["build-system"]["build-backend"]
    pkgutil.resolve_name(backend).build_wheel(out)
"""
"""pip would do the same with several processes for each package, and take six times as long."""
_DIGITS = 10
"""Of the digest in a version: 40 bits tell all releases of a course apart."""


def build(course: Course, out: Path) -> dict[str, Path]:
    """Build a wheel of each package of ``[install.assignments]``, and return them by its name.

    The same files give the same bytes where the build backend does, as hatchling does.

    Raises:
        WrongUse: a folder holds no file that the public may have.
        GraderFailure: one cannot be built.
    """
    packages = course.packages()
    if not packages:
        return {}
    if course.public is not None:
        names = chosen(course.public, tracked(course.root), course.tree / COURSE_NAME)
    else:
        names = _below(course.root, list(packages.values()))
    for folder in packages.values():
        if not any(name.startswith(f"{folder}/") for name in names):
            raise WrongUse(
                f"{course.tree / COURSE_NAME}: [install.assignments] names {folder}/, and there "
                "is no file of it that the public may have."
            )
    _build_of(course.root, names, list(packages.values()), out)
    found = {canonicalize_name(path.name.split("-")[0]): path for path in out.glob("*.whl")}
    return {name_of(package): found[canonicalize_name(name_of(package))] for package in packages}


def build_tracked(root: Path, folders: Sequence[str], out: Path) -> None:
    """Build a wheel of each folder of a course, with a ``pyproject.toml``, into an empty folder.

    It is of the files that git tracks, or of all where there is no git, and at the version of
    its content.

    Raises:
        GraderFailure: one cannot be built.
    """
    try:
        names = tracked(root)
    except WrongUse:
        names = _below(root, folders)
    _build_of(root, names, folders, out)


def version(root: Path, folder: str) -> str:
    """Return the version at which a package of a folder is built: its number and its content.

    Raises:
        GraderFailure: it cannot be built.
    """
    with tempfile.TemporaryDirectory(prefix="version-") as out:
        build_tracked(root, [folder], Path(out))
        (wheel,) = Path(out).glob("*.whl")
        return wheel.name.split("-")[1]


def _build_of(root: Path, names: Sequence[str], folders: Sequence[str], out: Path) -> None:
    """Build a wheel of each folder with its own build backend, which must be installed here.

    Copies are built, with these files alone: a build sees and writes no more.
    """
    with tempfile.TemporaryDirectory(prefix="wheels-") as temporary:
        for name in names:
            if name.startswith(tuple(f"{folder}/" for folder in folders)):
                (Path(temporary) / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(root / name, Path(temporary) / name)
        places = [os.path.abspath(out), *(f"{temporary}/{folder}" for folder in folders)]
        # -P: a backend is never looked for in the folder itself.
        command = [sys.executable, "-P", "-c", _BUILD, *places]
        done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        said = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        why = said[-1] if said else "it gave no reason."
        raise GraderFailure(f"No wheels could be built of {', '.join(folders)}: {why}")
    for wheel in list(out.glob("*.whl")):
        _name_content(wheel)


def _name_content(wheel: Path) -> None:
    """Write a wheel again, at a version that its content alone decides."""
    with zipfile.ZipFile(wheel) as archive:
        files = {each.filename: archive.read(each) for each in archive.infolist()}
    name, version, tags = wheel.name.split("-", 2)
    old = f"{name}-{version}."
    info = f"{old}dist-info/"
    del files[f"{info}RECORD"]
    # The letter keeps a digest of figures alone from being read as a number.
    local = f"d{_digest(files)[:_DIGITS]}"
    new = f"{version}{'.' if '+' in version else '+'}{local}"
    stated = f"Version: {version}\n".encode()
    metadata = f"{info}METADATA"
    files[metadata] = files[metadata].replace(stated, f"Version: {new}\n".encode(), 1)
    files = {re.sub(f"^{re.escape(old)}", f"{name}-{new}.", path): files[path] for path in files}
    record = f"{name}-{new}.dist-info/RECORD"
    files[record] = _record(files, record)
    with zipfile.ZipFile(wheel.with_name(f"{name}-{new}-{tags}"), "w") as archive:
        for path, data in files.items():
            archive.writestr(zipfile.ZipInfo(path), data, zipfile.ZIP_DEFLATED)
    wheel.unlink()


def _digest(files: Mapping[str, bytes]) -> str:
    """Return the SHA-256 of files with their names, in hexadecimal digits."""
    digest = hashlib.sha256()
    for path, data in sorted(files.items()):
        digest.update(f"{path}\0{len(data)}\0".encode() + data)
    return digest.hexdigest()


def _record(files: Mapping[str, bytes], own: str) -> bytes:
    """Return a wheel's list of files, as pip checks it: path, digest, size."""
    lines = []
    for path, data in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
        lines.append(f"{path},sha256={digest},{len(data)}\n")
    return "".join([*lines, f"{own},,\n"]).encode()


def _below(root: Path, folders: Sequence[str]) -> list[str]:
    paths = [path for folder in folders for path in (root / folder).rglob("*") if path.is_file()]
    return [path.relative_to(root).as_posix() for path in paths]
