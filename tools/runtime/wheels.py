"""The wheels beside Pyodide's: the course's packages, and others that it lacks.

All are made from what is installed, at the versions that the lock file pins: no network is needed.
"""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path, PurePath
from typing import Any

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.publishing.wheels import build_tracked

from tools.runtime.pyodide import RuntimeUnavailable

_PACKED = (".py", ".pyi", ".typed", ".js", ".css", ".json")
LOCK, BYTES = "pyodide-lock.json", "bytes"


@dataclass(frozen=True)
class Package:
    """A package of the page, and what Pyodide's loader has to know of it.

    ``depends`` are names of Pyodide's own list or of this one; ``folder`` is where a package
    of this repository is.
    """

    name: str
    imports: tuple[str, ...]
    depends: tuple[str, ...] = ()
    folder: str = ""


PACKAGES = (
    Package("matplotlib-fontlist", (), ("matplotlib",), "tools/runtime/fonts"),
    Package("lazy-loader", ("lazy_loader",), ("packaging",)),
    Package("msgpack", ("msgpack",)),
    Package(
        "robust-slam",
        ("robust_slam", "robust_slam_course"),
        ("numpy", "scipy", "matplotlib", "matplotlib-fontlist", "lazy-loader"),
        "lib",
    ),
    Package(
        "robust-slam-autograder",
        ("robust_slam_autograder",),
        ("ipython", "msgpack", "robust-slam"),  # every assignment's cells need the library
        "autograder",
    ),
    Package("typing-extensions", ("typing_extensions",)),
    Package("comm", ("comm",)),
    Package("psygnal", ("psygnal",)),
    Package("ipywidgets", ("ipywidgets",), ("comm", "ipython", "traitlets")),
    Package("anywidget", ("anywidget",), ("ipywidgets", "psygnal", "typing-extensions")),
)


def build(root: Path, out: Path, pyodide: Path) -> None:
    """Put the wheels of ``PACKAGES`` into ``out``, with Pyodide's list, to which they are added.

    With this list an import alone loads them. How much a page loads is written beside ``out``.

    Args:
        root: the course's folder.
        out: where the wheels go; wheels that were there before are deleted.
        pyodide: the folder with Pyodide's own list.

    Raises:
        RuntimeUnavailable: a wheel cannot be built.
    """
    with tempfile.TemporaryDirectory(prefix="wheels-") as temporary:
        made = Path(temporary)
        try:
            build_tracked(root, [each.folder for each in PACKAGES if each.folder], made)
        except GraderFailure as error:
            raise RuntimeUnavailable(str(error)) from error
        for each in PACKAGES:
            if not each.folder:
                _pack(each.name, made)
        found = {_normal(path.name.split("-")[0]): path for path in made.glob("*.whl")}
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        lock = json.loads((pyodide / LOCK).read_text(encoding="utf-8"))
        for each in PACKAGES:
            wheel = found[_normal(each.name)]
            path = out / wheel.name.replace("+", "_")  # some servers read a plus as a blank
            shutil.copyfile(wheel, path)
            address = f"../wheels/{path.name}"
            lock["packages"][each.name] = entry(
                path, each.name, address, each.imports, each.depends
            )
    (out / LOCK).write_text(json.dumps(lock), encoding="utf-8")
    (out.parent / BYTES).write_text(str(loaded_bytes(lock["packages"], pyodide)))


def loaded_bytes(packages: dict[str, Any], pyodide: Path) -> int:
    """Return the size of the files that a page fetches until its first cell can run."""
    names = ["robust-slam"]
    for name in names:  # it grows meanwhile
        names += [each for each in packages[name]["depends"] if each not in names]
    files = [packages[name]["file_name"] for name in names]
    files += ["pyodide.asm.wasm", "python_stdlib.zip", f"../wheels/{LOCK}"]
    return sum((pyodide / name).stat().st_size for name in files)


def version(out: Path) -> str:
    """Return the version of the course's library that ``build`` has put into ``out``."""
    packages = json.loads((out / LOCK).read_text(encoding="utf-8"))["packages"]
    return str(packages["robust-slam"]["version"])


def _pack(name: str, made: Path) -> None:
    """Make a wheel of an installed package, without native code, which must be optional in it."""
    distribution = metadata.distribution(name)
    folder = f"{_normal(name)}-{distribution.version}.dist-info"
    files = {
        path.as_posix(): Path(str(distribution.locate_file(path))).read_bytes()
        for path in sorted(distribution.files or [])
        if _is_packed(path)
    }
    files |= {
        f"{folder}/METADATA": (distribution.read_text("METADATA") or "").encode(),
        f"{folder}/WHEEL": b"Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        f"{folder}/RECORD": b"",
    }
    wheel = made / f"{_normal(name)}-{distribution.version}-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, data in files.items():
            archive.writestr(zipfile.ZipInfo(path), data, zipfile.ZIP_DEFLATED)


def _is_packed(path: PurePath) -> bool:
    """Tell whether a file is the package's own and of use in a browser, or is its licence."""
    if ".." in path.parts or "__pycache__" in path.parts:
        return False
    if path.parts[0].endswith(".dist-info"):
        return "licen" in path.as_posix().lower()
    return path.suffix in _PACKED


def entry(
    path: Path, name: str, address: str, imports: Sequence[str], depends: Sequence[str]
) -> dict[str, Any]:
    """Return what Pyodide's list says of a wheel; ``address`` starts from Pyodide's folder."""
    return {
        "name": name,
        "version": path.name.split("-")[1].replace("_", "+"),
        "file_name": address,
        "install_dir": "site",
        "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
        "package_type": "package",
        "imports": list(imports),
        "depends": list(depends),
        "unvendored_tests": False,
    }


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "_", name).lower()
