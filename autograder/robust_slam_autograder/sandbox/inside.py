"""What every back end starts an untrusted process with: limits, environment, import path."""

from __future__ import annotations

import importlib.util
import os
import platform
import sys
import sysconfig
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Protocol

import robust_slam_autograder
from robust_slam_autograder.executor import untrusted

SCRATCH_BYTES = 64 * 1024 * 1024
SCRATCH_FILES = 20_000
"""Files and folders in a scratch folder; each takes a kilobyte of the kernel's memory."""
MEMORY_BYTES = 4 * 1024**3
PROCESSES = 32
"""Processes and threads of one sandbox."""
FIRST_UID = 61_000
UIDS = 4_000
"""As root, a sandbox runs under one of these user ids, which own nothing."""
ENVIRONMENT = {
    "HOME": "/tmp",
    "LANG": "C.UTF-8",
    "MPLBACKEND": "Agg",
    "MPLCONFIGDIR": "/tmp",
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "PATH": "/usr/bin:/bin",
    "PYTHONHASHSEED": "0",
}


@dataclass(frozen=True)
class Launch:
    """What an untrusted process is started with."""

    withheld: tuple[str, ...]
    """Modules that it may not import."""
    used: tuple[str, ...]
    """Names that tests use."""
    cpu_seconds: int
    preload: tuple[str, ...] = ()
    """Modules that it will want; a back end may have them ready."""


class Running(Protocol):
    """An untrusted process."""

    def pipes(self) -> tuple[int, int]:
        """Descriptors to read its messages from and to write ours to."""

    def await_ready(self) -> str | None:
        """Wait until it answers; else say what is wrong."""

    def cpu_seconds(self) -> float:
        """CPU time that it has used, with all its threads."""

    def stop(self) -> None:
        """End it and all that it started, and remove its scratch folder."""


class Sandbox(Protocol):
    """A back end."""

    name: str
    """As in a result's ``sandbox``."""

    def problem(self) -> str | None:
        """Say why it does not work on this machine; None where it does."""

    def start(self, launch: Launch) -> Running:
        """Start an untrusted process whose stdin and stdout are pipes."""


def python_command(launch: Launch, uid: int | None, *, walled: bool) -> list[str]:
    """The command that runs ``untrusted.py``.

    Args:
        launch: what it is started with.
        uid: the user id that it drops to, None where it keeps its own.
        walled: whether it runs in namespaces of its own.
    """
    settings = {
        "path": [str(path) for path in import_path()],
        "withheld": launch.withheld,
        "used": launch.used,
        "limits": limits(launch, walled=walled),
        "uid": uid,
    }
    return python_script(Path(untrusted.__file__), settings)


def python_script(script: Path, settings: dict[str, Any]) -> list[str]:
    """The command that runs a script of ours with nothing of the user's around it.

    Args:
        script: the file.
        settings: what it reads from its command line, as a Python literal.
    """
    # The interpreter itself: a virtual environment's link may lead outside the wall.
    python = os.path.realpath(sys.executable)
    return [python, "-P", "-s", "-S", "-B", str(script.resolve()), repr(settings)]


def limits(launch: Launch, *, walled: bool) -> dict[str, int]:
    """Resource limits by their names in the resource module; ``walled`` as above."""
    found = {
        "RLIMIT_AS": MEMORY_BYTES,
        "RLIMIT_CORE": 0,
        "RLIMIT_CPU": launch.cpu_seconds,
        "RLIMIT_FSIZE": SCRATCH_BYTES,
        "RLIMIT_NOFILE": 128,
        "RLIMIT_NPROC": PROCESSES,
        "RLIMIT_SIGPENDING": 256,
    }
    if os.getuid() != 0 and not (walled and _counts_processes_per_namespace()):
        # All of the user's processes count: the limit would stop the student's first thread.
        del found["RLIMIT_NPROC"]
    return found


def _counts_processes_per_namespace() -> bool:
    """Since Linux 5.14 a user's processes in a user namespace are counted apart."""
    major, minor, *_ = (*platform.release().split("."), "0")
    return major.isdigit() and minor.isdigit() and (int(major), int(minor)) >= (5, 14)


def import_path() -> list[Path]:
    """The folders that student code imports from: the interpreter's and the installed packages."""
    roots = trees()
    found = [Path(entry).resolve() for entry in sys.path if entry]
    inside = [path for path in found if path.exists() and within(path, [Path("/usr"), *roots])]
    return list(dict.fromkeys([*inside, *(package.parent for package in packages_in_place())]))


def trees() -> list[Path]:
    """Folders of the interpreter and of what is installed for it, and nothing beside them."""
    base = Path(sys.base_prefix)
    paths = [
        Path(sysconfig.get_path(key)) for key in ("stdlib", "platstdlib", "purelib", "platlib")
    ]
    paths += [Path(os.path.realpath(sys.executable)).parent, base / "lib"]
    found = sorted({path.resolve() for path in paths if path.is_dir()})
    return [path for path in found if not within(path.parent, found)]


@cache
def packages_in_place() -> tuple[Path, ...]:
    """Packages that are imported from their source folders (``pip install --editable``)."""
    site = Path(sysconfig.get_path("purelib"))
    lines = [line for file in sorted(site.glob("*.pth")) for line in file.read_text().split("\n")]
    folders = [Path(line) for line in lines if line.startswith("/")]
    packages = [init.parent for folder in folders for init in sorted(folder.glob("*/__init__.py"))]
    packages.append(Path(robust_slam_autograder.__file__).parent)
    return tuple(dict.fromkeys(path.resolve() for path in packages if not within(path, trees())))


def within(path: Path, folders: Sequence[Path]) -> bool:
    """Whether a path lies in one of these folders."""
    return any(path.is_relative_to(folder) for folder in folders)


@dataclass(frozen=True)
class Files:
    """What student code finds on its disk."""

    visible: tuple[Path, ...]
    """It may read these: the system's programs, the interpreter and the packages."""
    hidden: tuple[Path, ...]
    """Not these, which hold withheld modules or their compiled copies."""
    fonts: tuple[Path, ...]
    """Matplotlib's lists of fonts."""


def files(withheld: Sequence[str]) -> Files:
    """Find what student code may read here, without the withheld modules."""
    shared = [Path(path) for path in ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache")]
    apart = [tree for tree in trees() if not within(tree, [Path("/usr")])]
    found = [path for module in withheld for path in _files_of(module)]
    lists = (path for path in font_folder().glob("fontlist-v*.json") if path.is_file())
    return Files(
        visible=(*shared, *apart, *packages_in_place()),
        # What lies in a hidden folder is hidden with it, and no longer there to be covered.
        hidden=tuple(path for path in dict.fromkeys(found) if not within(path.parent, found)),
        fonts=tuple(lists),
    )


def _files_of(module: str) -> list[Path]:
    top, *rest = module.split(".")
    spec = importlib.util.find_spec(top)
    if spec is None:
        return []
    if rest:
        folders = [Path(folder, *rest[:-1]) for folder in spec.submodule_search_locations or ()]
    else:
        packages = spec.submodule_search_locations or [spec.origin or ""]
        folders = [Path(package).parent for package in packages]
    name = module.rpartition(".")[2]
    found = []
    for folder in (folder.resolve() for folder in folders):
        found += sorted(path for path in folder.glob(f"{name}.*") if path.is_file())
        found += [path for path in (folder / name, folder / "__pycache__") if path.is_dir()]
    return found


def font_folder() -> Path:
    """Where matplotlib keeps its list of fonts, which takes it seconds to make."""
    cache_folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "matplotlib"
    return Path(os.environ.get("MPLCONFIGDIR") or cache_folder)


def readable(files: Files) -> list[tuple[Path, bool]]:
    """What of the visible remains without the hidden, as a list of what may be opened.

    Returns:
        paths; and whether all beneath may be read, or the names in the folder alone.
    """
    hidden = [path.resolve() for path in files.hidden]
    found: list[tuple[Path, bool]] = []
    waiting = [path.resolve() for path in files.visible if path.exists()]
    seen: set[Path] = set()
    while waiting:
        path = waiting.pop()
        if path in seen:
            continue
        seen.add(path)
        if not any(hid.is_relative_to(path) for hid in hidden):
            found.append((path, True))
        elif path not in hidden:
            found.append((path, False))
            waiting += (inner.resolve() for inner in path.iterdir())  # a link may lead to it
    return found
