"""The wheels beside Pyodide's: the course's packages, and pure Python ones that it lacks."""

from __future__ import annotations

import hashlib
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.publishing.files import tracked

from tools.runtime.pyodide import RuntimeUnavailable

_PIP = (sys.executable, "-m", "pip", "--disable-pip-version-check", "--quiet")
_PURE = ("--platform=any", "--implementation=py", "--abi=none", "--python-version=3.12")
INDEX = "wheels.json"
LOCK = "pyodide-lock.json"


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
    Package(
        "robust-slam",
        ("robust_slam", "robust_slam_course"),
        ("numpy", "scipy", "matplotlib", "matplotlib-fontlist", "lazy-loader"),
        "lib",
    ),
    Package(
        "robust-slam-autograder",
        ("robust_slam_autograder",),
        ("ipython", "numpy", "packaging"),
        "autograder",
    ),
    Package("typing-extensions", ("typing_extensions",)),
    Package("comm", ("comm",)),
    Package("psygnal", ("psygnal",)),
    Package("ipywidgets", ("ipywidgets",), ("comm", "ipython", "traitlets")),
    Package("anywidget", ("anywidget",), ("ipywidgets", "psygnal", "typing-extensions")),
)
"""In the order in which they can be loaded one after the other."""
LOADED = ("matplotlib-fontlist", "lazy-loader", "robust-slam")
"""What the chapters need; assignments need the rest too."""


def build(root: Path, out: Path, pyodide: Path) -> None:
    """Put the wheels of ``PACKAGES`` into ``out``, with two lists of them.

    ``wheels.json`` names the wheels in the order of loading: ``chapters`` those that a chapter
    needs, ``all`` all of them; ``packages`` are Pyodide's own that a chapter needs.
    ``pyodide-lock.json`` is Pyodide's list with these wheels added, so that an import alone
    loads them.

    Args:
        root: the course's folder.
        out: where the wheels go; wheels that were there before are deleted.
        pyodide: the folder with Pyodide's own list.

    Raises:
        RuntimeUnavailable: a wheel cannot be built or downloaded.
    """
    (out / INDEX).unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(prefix="wheels-") as temporary:
        made = Path(temporary)
        _build_own(root, made)
        _download(root, made, out)
        found = {_normal(path.name.split("-")[0]): path for path in made.glob("*.whl")}
        shutil.rmtree(out, ignore_errors=True)
        out.mkdir(parents=True)
        wheels = {each.name: out / found[_normal(each.name)].name for each in PACKAGES}
        for each in PACKAGES:
            shutil.copyfile(found[_normal(each.name)], wheels[each.name])
    lock = _add_to_lock(json.loads((pyodide / LOCK).read_text(encoding="utf-8")), wheels)
    (out / LOCK).write_text(json.dumps(lock), encoding="utf-8")
    index = {
        "packages": ["numpy", "scipy", "matplotlib"],
        "chapters": [wheels[name].name for name in LOADED],
        "all": [path.name for path in wheels.values()],
    }
    (out / INDEX).write_text(json.dumps(index, indent=1) + "\n", encoding="utf-8")


def _build_own(root: Path, made: Path) -> None:
    """Build the wheels of this repository's packages, of the files that git tracks alone."""
    folders = [each.folder for each in PACKAGES if each.folder]
    offline = ("--no-deps", "--no-index", "--no-build-isolation")
    with tempfile.TemporaryDirectory(prefix="sources-") as temporary:
        for name in _files(root, folders):
            copy = Path(temporary) / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(root / name, copy)
        sources = [str(Path(temporary) / folder) for folder in folders]
        _run("wheel", *offline, "--wheel-dir", str(made), *sources)


def _files(root: Path, folders: Sequence[str]) -> list[str]:
    try:
        names = tracked(root)
    except WrongUse:  # a copy without git's records
        names = [path.relative_to(root).as_posix() for path in root.rglob("*") if path.is_file()]
    return [name for name in names if name.startswith(tuple(f"{folder}/" for folder in folders))]


def _download(root: Path, made: Path, earlier: Path) -> None:
    """Download the others at the versions of the course's lock file, or take earlier ones."""
    text = (root / "requirements.lock").read_text(encoding="utf-8")
    names = {each.name for each in PACKAGES if not each.folder}
    pins = re.findall(r"^((?P<name>[\w.-]+)==[^\n]*\n(?:    [^\n]*\n)*)", text, re.M)
    wanted = "".join(pin for pin, name in pins if name in names)
    wanted = re.sub(r"^([\w.-]+==[^\s;]+) ;[^\\\n]*", r"\1 ", wanted, flags=re.M)
    with tempfile.TemporaryDirectory(prefix="pins-") as temporary:
        pinned = Path(temporary) / "requirements.txt"
        pinned.write_text(wanted, encoding="utf-8")
        only = ("--no-deps", "--require-hashes", "--only-binary=:all:", *_PURE)
        command = ("download", *only, "--dest", str(made), "--requirement", str(pinned))
        try:
            _run(*command, "--no-index", "--find-links", str(earlier))
        except RuntimeUnavailable:
            _run(*command)


def _run(*arguments: str) -> None:
    done = subprocess.run([*_PIP, *arguments], capture_output=True, text=True, check=False)
    if done.returncode:
        lines = [line.strip() for line in done.stderr.splitlines() if line.strip()]
        errors = [line for line in lines if line.startswith("ERROR")] or lines or ["no reason"]
        raise RuntimeUnavailable(f"pip {arguments[0]}: {errors[-1]}")


def _add_to_lock(lock: dict, wheels: dict[str, Path]) -> dict:
    """Add the wheels to Pyodide's list of packages, with addresses from its own folder."""
    for each in PACKAGES:
        path = wheels[each.name]
        lock["packages"][each.name] = {
            "name": each.name,
            "version": path.name.split("-")[1],
            "file_name": f"../wheels/{path.name}",
            "install_dir": "site",
            "sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
            "package_type": "package",
            "imports": list(each.imports),
            "depends": list(each.depends),
            "unvendored_tests": False,
        }
    return lock


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "_", name).lower()
