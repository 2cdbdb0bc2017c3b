"""The wall around student code: one small interface, one class per back end.

A back end starts ``untrusted.py`` with pipes for its standard input and output.
"""

from __future__ import annotations

import contextlib
import importlib.util
import os
import platform
import select
import shutil
import signal
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Protocol

from robust_slam_autograder import seccomp, untrusted
from robust_slam_autograder.errors import WrongUse

START_SECONDS = 60.0
SCRATCH_BYTES = 64 * 1024 * 1024
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
        scratch = tempfile.TemporaryDirectory(prefix="autograder-", ignore_cleanup_errors=True)
        environment = ENVIRONMENT | {"HOME": scratch.name, "MPLCONFIGDIR": scratch.name}
        process = _popen(
            _python(launch, None, walled=False), cwd=scratch.name, environment=environment
        )
        return Running(process, scratch)


class Bubblewrap:
    """Debian's bubblewrap: own namespaces, no network, only read-only files."""

    name = "bubblewrap"

    def start(self, launch: Launch) -> Running:
        """Start it behind the wall; as root, it then drops to a user id of its own."""
        uid = FIRST_UID + os.getpid() % UIDS if os.getuid() == 0 else None
        mounts, python = _mounts(launch.withheld), _python(launch, uid, walled=True)
        with _filter() as (options, descriptors):
            command = [*_walls(uid), *options, *mounts, "--", *python]
            return Running(_popen(command, cwd="/", environment={}, pass_fds=descriptors))


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
    running = Bubblewrap().start(Launch(withheld=(), used=(), cpu_seconds=20))
    try:
        error = running.await_ready()
    finally:
        running.stop()
    return None if error is None else f"bwrap fails: {error}"


def _popen(
    command: Sequence[str], cwd: str, environment: dict[str, str], pass_fds: Sequence[int] = ()
) -> subprocess.Popen[bytes]:
    return subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        cwd=cwd,
        env=environment,
        pass_fds=pass_fds,
        start_new_session=True,
    )


def _python(launch: Launch, uid: int | None, *, walled: bool) -> list[str]:
    settings = {
        "path": [str(path) for path in _import_path()],
        "withheld": launch.withheld,
        "used": launch.used,
        "limits": _limits(launch, walled=walled),
        "uid": uid,
    }
    # The interpreter itself: a virtual environment's link may lead outside the wall.
    python = os.path.realpath(sys.executable)
    script = Path(untrusted.__file__).resolve()
    return [python, "-P", "-s", "-S", "-B", str(script), repr(settings)]


def _limits(launch: Launch, *, walled: bool) -> dict[str, int]:
    limits = {
        "RLIMIT_AS": MEMORY_BYTES,
        "RLIMIT_CORE": 0,
        "RLIMIT_CPU": launch.cpu_seconds,
        "RLIMIT_FSIZE": SCRATCH_BYTES,
        "RLIMIT_NOFILE": 128,
        "RLIMIT_NPROC": PROCESSES,
    }
    if os.getuid() != 0 and not (walled and _counts_processes_per_namespace()):
        # All of the user's processes count: the limit would stop the student's first thread.
        del limits["RLIMIT_NPROC"]
    return limits


def _counts_processes_per_namespace() -> bool:
    """Since Linux 5.14 a user's processes in a user namespace are counted apart."""
    major, minor, *_ = (*platform.release().split("."), "0")
    return major.isdigit() and minor.isdigit() and (int(major), int(minor)) >= (5, 14)


def _import_path() -> list[Path]:
    """The folders that student code imports from: the interpreter's and the installed packages."""
    trees = _trees()
    found = [Path(entry).resolve() for entry in sys.path if entry]
    inside = [path for path in found if path.exists() and _within(path, [Path("/usr"), *trees])]
    return list(dict.fromkeys([*inside, *(package.parent for package in packages_in_place())]))


def _trees() -> list[Path]:
    """Folders of the interpreter and of what is installed for it, and nothing beside them."""
    base = Path(sys.base_prefix)
    paths = [
        Path(sysconfig.get_path(key)) for key in ("stdlib", "platstdlib", "purelib", "platlib")
    ]
    paths += [Path(os.path.realpath(sys.executable)).parent, base / "lib"]
    found = sorted({path.resolve() for path in paths if path.is_dir()})
    return [path for path in found if not _within(path.parent, found)]


@cache
def packages_in_place() -> tuple[Path, ...]:
    """Packages that are imported from their source folders (``pip install --editable``)."""
    site = Path(sysconfig.get_path("purelib"))
    lines = [line for file in sorted(site.glob("*.pth")) for line in file.read_text().split("\n")]
    folders = [Path(line) for line in lines if line.startswith("/")]
    packages = [init.parent for folder in folders for init in sorted(folder.glob("*/__init__.py"))]
    packages.append(Path(untrusted.__file__).parent)
    return tuple(dict.fromkeys(path.resolve() for path in packages if not _within(path, _trees())))


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
    apart = [tree for tree in _trees() if not _within(tree, [Path("/usr")])]
    small = ["--perms", "1777", "--size", str(SCRATCH_BYTES), "--tmpfs"]
    options = ["--proc", "/proc", "--dev", "/dev", "--remount-ro", "/dev"]
    # First of all, lest they cover a course that lies in /tmp itself.
    options += [*small, "/dev/shm", *small, "/tmp"]
    made: set[Path] = set()
    for path in [*shared, *apart, *packages_in_place()]:
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
