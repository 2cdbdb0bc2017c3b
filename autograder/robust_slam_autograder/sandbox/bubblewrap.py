"""Debian's bubblewrap: own namespaces, no network, only read-only files."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

from robust_slam_autograder.sandbox import inside, seccomp
from robust_slam_autograder.sandbox.inside import ENVIRONMENT, SCRATCH_BYTES, Launch, within
from robust_slam_autograder.sandbox.process import Process, popen


class Bubblewrap:
    """Debian's bubblewrap: own namespaces, no network, only read-only files."""

    name = "bubblewrap"

    def problem(self) -> str | None:
        """Try it once."""
        return bubblewrap_problem()

    def start(self, launch: Launch) -> Process:
        """Start it behind the wall; as root, it then drops to a user id of its own."""
        uid = inside.FIRST_UID + os.getpid() % inside.UIDS if os.getuid() == 0 else None
        mounts, command = _mounts(launch.withheld), inside.python_command(launch, uid, walled=True)
        with _filter() as (options, descriptors):
            command = [*_walls(uid), *options, *mounts, "--", *command]
            return Process(popen(command, cwd="/", environment={}, pass_fds=descriptors))


@contextlib.contextmanager
def _filter() -> Iterator[tuple[list[str], tuple[int, ...]]]:
    """The system-call filter on a pipe: bubblewrap's options and the descriptors to hand on."""
    program = seccomp.program()
    if program is None:
        yield [], ()
        return
    reader, writer = os.pipe()
    os.write(writer, program)
    os.close(writer)
    try:
        yield ["--seccomp", str(reader)], (reader,)
    finally:
        os.close(reader)


@cache
def bubblewrap_problem() -> str | None:
    """Say why bubblewrap does not work on this machine; None where it does."""
    if sys.platform != "linux" or shutil.which("bwrap") is None:
        return "bwrap is not installed"
    running = Bubblewrap().start(Launch(withheld=(), used=(), cpu_seconds=20))
    try:
        error = running.await_ready()
    finally:
        running.stop()
    return None if error is None else f"bwrap fails: {error}"


def _walls(uid: int | None) -> list[str]:
    options = ["bwrap", "--die-with-parent", "--new-session", "--clearenv"]
    options += ["--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts"]
    options += ["--unshare-cgroup-try", "--hostname", "sandbox", "--cap-drop", "ALL"]
    if uid is None:
        options += ["--unshare-user", "--disable-userns"]
    else:
        options += ["--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    for name, value in ENVIRONMENT.items():
        options += ["--setenv", name, value]
    return options


def _mounts(withheld: Sequence[str]) -> list[str]:
    """Read-only interpreter and library, a small writable /tmp, and nothing else."""
    shared = [Path(path) for path in ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache")]
    apart = [tree for tree in inside.trees() if not within(tree, [Path("/usr")])]
    small = ["--perms", "1777", "--size", str(SCRATCH_BYTES), "--tmpfs"]
    options = ["--proc", "/proc", "--dev", "/dev", "--remount-ro", "/dev"]
    # First of all, lest they cover a course that lies in /tmp itself.
    options += [*small, "/dev/shm", *small, "/tmp"]
    made: set[Path] = set()
    for path in [*shared, *apart, *inside.packages_in_place()]:
        if path.is_symlink():
            options += ["--symlink", os.readlink(path), str(path)]
        elif path.exists():
            options += [*_make_parents(path, made), "--ro-bind", str(path), str(path)]
    for module in withheld:
        options += _hide(module)
    return [*options, *_font_list(), "--remount-ro", "/", "--chdir", "/tmp"]


def _font_list() -> list[str]:
    """Matplotlib's list of fonts, which it would else make anew for each student."""
    cache_folder = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "matplotlib"
    folder = Path(os.environ.get("MPLCONFIGDIR") or cache_folder)
    lists = [path for path in folder.glob("fontlist-v*.json") if path.is_file()]
    pairs = [[str(path), f"{ENVIRONMENT['MPLCONFIGDIR']}/{path.name}"] for path in lists]
    return [option for pair in pairs for option in ("--ro-bind", *pair)]


def _make_parents(path: Path, made: set[Path]) -> list[str]:
    """Make a mount's parent folders passable for the user id that the sandbox drops to."""
    options: list[str] = []
    for parent in reversed(path.parents[:-1]):
        if parent not in made:
            options += ["--perms", "0755", "--dir", str(parent)]
            made.add(parent)
    return options


def _hide(module: str) -> list[str]:
    """Cover a module's files, so that reading them gives nothing either."""
    top, *rest = module.split(".")
    spec = importlib.util.find_spec(top)
    if spec is None:
        return []
    if rest:
        folders = [Path(folder, *rest[:-1]) for folder in spec.submodule_search_locations or ()]
    else:
        packages = spec.submodule_search_locations or [spec.origin or ""]
        folders = [Path(package).parent for package in packages]
    return [option for folder in folders for option in _cover(folder.resolve(), module)]


def _cover(folder: Path, module: str) -> list[str]:
    name = module.rpartition(".")[2]
    files = sorted(path for path in folder.glob(f"{name}.*") if path.is_file())
    emptied = [path for path in (folder / name, folder / "__pycache__") if path.is_dir()]
    options = [part for path in files for part in ("--ro-bind", "/dev/null", str(path))]
    for path in emptied:
        options += ["--perms", "0555", "--size", "4096", "--tmpfs", str(path)]
        options += ["--remount-ro", str(path)]
    return options
