"""The wall around student code: one small interface, one class per back end.

A back end starts ``untrusted.py`` with pipes for its standard input and output.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Protocol

from robust_slam_autograder import untrusted
from robust_slam_autograder.errors import WrongUse

START_SECONDS = 60.0
SCRATCH_BYTES = 64 * 1024 * 1024
MEMORY_BYTES = 4 * 1024**3
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
}


@dataclass(frozen=True)
class Launch:
    """What an untrusted process is started with."""

    withheld: tuple[str, ...]
    """Modules that it may not import."""
    cpu_seconds: int


@dataclass(frozen=True)
class Running:
    """An untrusted process with its pipes, and the scratch folder that goes with it."""

    process: subprocess.Popen[bytes]
    scratch: tempfile.TemporaryDirectory[str] | None = None

    def pipes(self) -> tuple[int, int]:
        """Descriptors to read its messages from and to write ours to."""
        assert self.process.stdin and self.process.stdout
        return self.process.stdout.fileno(), self.process.stdin.fileno()

    def await_ready(self) -> str | None:
        """Wait until it answers; else say what it wrote to its standard error."""
        assert self.process.stderr
        reader, _ = self.pipes()
        answers = select.select([reader], [], [], START_SECONDS)[0]
        if answers and os.read(reader, len(untrusted.READY)) == untrusted.READY:
            return None
        self.process.kill()
        said = self.process.stderr.read().decode(errors="replace").strip()
        return said[-500:] or "it says nothing"

    def stop(self) -> None:
        """End it and all that it started, and remove its scratch folder."""
        with contextlib.suppress(ProcessLookupError, PermissionError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            if pipe is not None:
                with contextlib.suppress(OSError):
                    pipe.close()
        if self.scratch is not None:
            self.scratch.cleanup()


class Sandbox(Protocol):
    """A back end."""

    name: str
    """As in a result's ``sandbox``: "bubblewrap", "none"."""

    def start(self, launch: Launch) -> Running:
        """Start an untrusted process whose stdin and stdout are pipes."""


class Unsandboxed:
    """No wall: the process has the user's own rights. For one's own code only."""

    name = "none"

    def start(self, launch: Launch) -> Running:
        """Start it in an empty folder of its own, with a clean environment."""
        scratch = tempfile.TemporaryDirectory(prefix="autograder-")
        environment = ENVIRONMENT | {"HOME": scratch.name, "MPLCONFIGDIR": scratch.name}
        process = _popen(_python(launch, uid=None), cwd=scratch.name, environment=environment)
        return Running(process, scratch)


class Bubblewrap:
    """Debian's bubblewrap: own namespaces, no network, only read-only files."""

    name = "bubblewrap"

    def start(self, launch: Launch) -> Running:
        """Start it behind the wall; as root, it then drops to a user id of its own."""
        uid = FIRST_UID + os.getpid() % UIDS if os.getuid() == 0 else None
        command = [*_walls(uid), *_mounts(launch.withheld), "--", *_python(launch, uid)]
        return Running(_popen(command, cwd="/", environment={}))


def choose(*, unsandboxed: bool) -> Sandbox:
    """Take the best back end that works here.

    Raises:
        WrongUse: none works and ``unsandboxed`` was not asked for; says what to install.
    """
    if unsandboxed:
        return Unsandboxed()
    problem = bubblewrap_problem()
    if problem:
        raise WrongUse(
            f"No sandbox works here ({problem}), so hidden tests are not run: "
            "install bubblewrap, or trust the submissions with --unsandboxed."
        )
    return Bubblewrap()


@cache
def bubblewrap_problem() -> str | None:
    """Say why bubblewrap does not work on this machine; None where it does."""
    if sys.platform != "linux" or shutil.which("bwrap") is None:
        return "bwrap is not installed"
    running = Bubblewrap().start(Launch(withheld=(), cpu_seconds=20))
    try:
        error = running.await_ready()
    finally:
        running.stop()
    return None if error is None else f"bwrap fails: {error}"


def _popen(
    command: Sequence[str], cwd: str, environment: dict[str, str]
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=cwd,
        env=environment,
        start_new_session=True,
    )


def _python(launch: Launch, uid: int | None) -> list[str]:
    limits = {
        "RLIMIT_AS": MEMORY_BYTES,
        "RLIMIT_CORE": 0,
        "RLIMIT_CPU": launch.cpu_seconds,
        "RLIMIT_FSIZE": SCRATCH_BYTES,
        "RLIMIT_NOFILE": 128,
        "RLIMIT_NPROC": 64,
    }
    if os.getuid() != 0 and uid is None:
        # All of the user's processes count: a low limit would stop the student's first thread.
        del limits["RLIMIT_NPROC"]
    settings = {
        "path": [str(path) for path in _import_path()],
        "withheld": launch.withheld,
        "limits": limits,
        "uid": uid,
    }
    return [sys.executable, "-I", "-S", "-B", str(Path(untrusted.__file__)), repr(settings)]


def _import_path() -> list[Path]:
    """The folders that student code imports from: the interpreter's and the installed packages."""
    base = Path(sys.base_prefix).resolve()
    prefix = Path(sys.prefix).resolve()
    packages = [package.parent for package in _packages()]
    inside = [
        path
        for path in (Path(entry).resolve() for entry in sys.path if entry)
        if path.exists() and (path.is_relative_to(base) or path.is_relative_to(prefix))
    ]
    return list(dict.fromkeys(inside + packages))


def _packages() -> list[Path]:
    """Folders of the two packages that may be installed from their source folders."""
    found = [Path(untrusted.__file__).resolve().parent]
    spec = importlib.util.find_spec("robust_slam")
    if spec is not None and spec.origin is not None:
        found.append(Path(spec.origin).resolve().parent)
    return found


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
    python = {Path(sys.base_prefix), Path(sys.prefix), Path(sys.executable).parent.parent}
    trees = sorted({path for path in python if not path.is_relative_to("/usr")})
    options: list[str] = []
    made: set[Path] = set()
    for path in shared:
        if path.is_symlink():
            options += ["--symlink", os.readlink(path), str(path)]
        elif path.exists():
            options += [*_make_parents(path, made), "--ro-bind", str(path), str(path)]
    for path in [*trees, *(package for package in _packages() if not _within(package, trees))]:
        options += [*_make_parents(path, made), "--ro-bind", str(path), str(path)]
    for module in withheld:
        options += _hide(module)
    size = str(SCRATCH_BYTES)
    options += ["--proc", "/proc", "--dev", "/dev", "--remount-ro", "/dev"]
    options += ["--perms", "1777", "--size", size, "--tmpfs", "/dev/shm"]
    options += ["--perms", "1777", "--size", size, "--tmpfs", "/tmp"]
    return [*options, "--remount-ro", "/", "--chdir", "/tmp"]


def _within(path: Path, trees: Sequence[Path]) -> bool:
    return any(path.is_relative_to(tree) for tree in trees)


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
    if spec is None or spec.origin is None:
        return []
    folder = Path(spec.origin).resolve().parent
    path = folder.joinpath(*rest)
    options: list[str] = []
    if path.is_dir():
        options += ["--tmpfs", str(path)]
    if rest and path.with_suffix(".py").is_file():
        options += ["--ro-bind", "/dev/null", str(path.with_suffix(".py"))]
    cached = path.parent / "__pycache__"
    if cached.is_dir():
        options += ["--tmpfs", str(cached)]
    return options
