"""The wheels beside Pyodide's: the course's packages, and others that it lacks.

All are made from what is installed, at the versions that the lock file pins: no network is needed.
"""

import hashlib
import json
import shutil
import tempfile
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path, PurePath
from typing import Any

from packaging.utils import canonicalize_name
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.publishing.wheels import build_tracked

from tools.runtime.compiled import compile_archives
from tools.runtime.pyodide import RuntimeUnavailable

_PACKED = (".py", ".pyi", ".typed", ".js", ".css", ".json")
LOCK, PAGE_LOCK, BYTES = "pyodide-lock.json", "page-lock.json", "bytes"
PYTHON = ("pyodide.asm.wasm", "python_stdlib.zip")
"""Files of Pyodide that each page loads before its first line."""
CUSTOM = Path(__file__).with_name("sitecustomize.py")
"""Goes into Python's own library, which imports it before anything else."""
ON_PAGES = ("robust-slam-course", "scipy", "matplotlib")
"""Packages that code on a page may import, beside all on which they depend."""
FIRST = ("robust-slam-course",)
"""What nearly every cell needs; the other packages are loaded where they are imported."""


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
    Package("matplotlib-fontlist", (), (), "tools/runtime/fonts"),
    Package("lazy-loader", ("lazy_loader",), ("packaging",)),
    Package("msgpack", ("msgpack",)),
    Package("robust-slam", ("robust_slam",), ("numpy", "lazy-loader"), "lib"),  # more on demand
    Package("robust-slam-course", ("robust_slam_course",), ("robust-slam",), "lib/course"),
    Package(
        "robust-slam-autograder",
        ("robust_slam_autograder",),
        # Every assignment's cells need the library, and what that imports.
        ("ipython", "msgpack", *ON_PAGES),
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

    With this list an import alone loads them. What pages load is compiled, and has a list of its
    own; how much a page loads until its first cell can run is written beside ``out``. Wheels that
    were there before are deleted.

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
        found = {canonicalize_name(path.name.split("-")[0]): path for path in made.glob("*.whl")}
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        lock = json.loads((pyodide / LOCK).read_text(encoding="utf-8"))
        for each in PACKAGES:
            wheel = found[canonicalize_name(each.name)]
            path = out / wheel.name.replace("+", "_")  # some servers read a plus as a blank
            shutil.copyfile(wheel, path)
            address = f"../wheels/{path.name}"
            lock["packages"][each.name] = entry(
                path, each.name, address, each.imports, each.depends
            )
    lock["packages"]["matplotlib"]["depends"].append("matplotlib-fontlist")
    _compile(lock["packages"], out, pyodide)
    (out / LOCK).write_text(json.dumps(lock), encoding="utf-8")
    page = page_lock(lock, out)
    (out / PAGE_LOCK).write_text(json.dumps(page), encoding="utf-8")
    first = sum(page["packages"][name]["size"] for name in closure(page["packages"], FIRST))
    (out.parent / BYTES).write_text(str(page["info"]["size"] + first))


def _compile(packages: dict[str, Any], out: Path, pyodide: Path) -> None:
    """Compile what pages load, into ``out``, and let the list name what came of it."""
    names = closure(packages, ON_PAGES)
    paths = {name: (pyodide / packages[name]["file_name"]).resolve() for name in names}
    own = [path for path in paths.values() if path.parent == out.resolve()]
    compile_archives([*paths.values(), pyodide / PYTHON[1]], out, pyodide, own)
    with zipfile.ZipFile(out / PYTHON[1], "a") as archive:
        archive.write(CUSTOM, CUSTOM.name)
    for name, path in paths.items():
        data = (out / path.name).read_bytes()
        packages[name]["sha256"] = hashlib.sha256(data).hexdigest()
        packages[name]["file_name"] = f"../wheels/{path.name}"


def closure(packages: dict[str, Any], names: Sequence[str]) -> list[str]:
    """Return the packages, and all on which they depend."""
    found = list(names)
    for name in found:  # it grows meanwhile
        found += [each for each in packages[name]["depends"] if each not in found]
    return found


def page_lock(lock: dict[str, Any], out: Path) -> dict[str, Any]:
    """Return the part of the list that pages need, with the sizes of files in bytes.

    The size beside the version of Pyodide is that of Python itself.
    """
    packages = {
        name: entry | {"size": (out / Path(entry["file_name"]).name).stat().st_size}
        for name in closure(lock["packages"], ON_PAGES)
        if (entry := lock["packages"][name])
    }
    paths = (out.parent / "pyodide" / PYTHON[0], out / PYTHON[1])
    size = sum(path.stat().st_size for path in paths)
    return {"info": lock["info"] | {"size": size}, "packages": packages}


def version(out: Path) -> str:
    """Return the version of the course's library that ``build`` has put into ``out``."""
    packages = json.loads((out / LOCK).read_text(encoding="utf-8"))["packages"]
    return str(packages["robust-slam"]["version"])


def _pack(name: str, made: Path) -> None:
    """Make a wheel of an installed package, without native code, which must be optional in it."""
    distribution = metadata.distribution(name)
    stem = f"{canonicalize_name(name).replace('-', '_')}-{distribution.version}"
    folder = f"{stem}.dist-info"
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
    wheel = made / f"{stem}-py3-none-any.whl"
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
