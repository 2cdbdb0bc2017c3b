"""A container for a grader that is not to be trusted with hostile submissions.

Bubblewrap with its own processes, network and files: the interpreter read-only, a course on a
small disk in memory, and nothing else of the machine. What runs in it has a user id of its
own and limits on memory, processes, file size and processor time. Its first process cannot be
killed from within; at the end it ends all others and hands out the course's files.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import shlex
import signal
import stat
import subprocess
import sys
import tarfile
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import psutil
from robust_slam_autograder.sandbox import inside, view

COURSE = Path("/course")
SYSTEM = tuple(map(Path, ("/usr", "/lib", "/lib64", "/bin", "/etc/ld.so.cache")))
"""Plain nbgrader starts programs, so it sees all of these."""
FIRST_UID = 52_000
UIDS = 5_000
LIMITS = {
    "nproc": 160,
    "as": 4 * 2**30,
    "fsize": 512 * 2**20,
    "cpu": 600,
    "core": 0,
}
MEMORY_BYTES = 5 * 2**30
"""Of all processes of a container together: above it the largest is ended."""
LONGEST_FILE = 8 * 2**20
"""Larger ones stay in the container."""
LOOK_SECONDS = 0.5
WATCHED = ("submitted", "solutions", "release", "outside")
"""Folders of a course that no grader and no submission has to change."""
MADE = ("gradebook.db", "autograded", "feedback")

# The first process: steps run beside it, lest one that is stopped stops it too.
SCRIPT = """\
alive() { grep -qs '^State:.[^ZX]' /proc/$1/status; }
step() {
  number=$1; shift
  ( $AS "$@" >&2 </dev/null; echo "step $number ends with $?" >&2 ) &
  while alive $! && [ ! -e /given/stop-$number ]; do sleep 0.2; done
}
$AS cp -a /given/course/. /course
cd /course
STEPS
$AS sh -c 'kill -9 -1'
{ $AS find MADE -maxdepth 4 SMALL; $AS find WATCHED SMALL; } |
  $AS tar --null --no-recursion --files-from - --create
exit 0
"""


@dataclass(frozen=True)
class File:
    """One file of a course, or a link."""

    kind: str
    mode: int
    target: str
    """Where a link leads."""
    data: bytes

    @property
    def state(self) -> tuple[object, ...]:
        """What must not change."""
        return self.kind, self.mode, self.target, hashlib.sha256(self.data).hexdigest()


@dataclass(frozen=True)
class Outcome:
    """How a run ended."""

    files: Mapping[str, File]
    """By their paths in the course; empty where the container did not hand them out."""
    log: Path
    hung: frozenset[int]
    """Numbers of the steps that were ended because nothing went on."""


def problem() -> str | None:
    """Say why there is no container here; None where it works."""
    try:
        done = subprocess.run(
            [*_walls(FIRST_UID, {}), *_mounts(), "--", "sh", "-c", f"{_as(FIRST_UID)} true"],
            capture_output=True,
            text=True,
        )
    except FileNotFoundError as error:
        return f"{error.filename} is not installed"
    return done.stderr.strip() if done.returncode else None


def run(
    given: Path,
    steps: Sequence[Sequence[str]],
    environment: Mapping[str, str],
    *,
    number: int,
    stall_seconds: float,
) -> Outcome:
    """Run steps in a container, one after the other.

    Args:
        given: a folder of ours; ``given/course`` is copied to ``COURSE``.
        steps: commands.
        environment: variables that they see.
        number: makes the user id.
        stall_seconds: a step whose log grows no longer is ended after so long.
    """
    (given / "passwd").write_text(f"grader:x:{_uid(number)}:{_uid(number)}::/home:/bin/sh\n")
    bound = ["--ro-bind", str(given), "/given", "--ro-bind", str(given / "passwd"), "/etc/passwd"]
    script = _script(steps, _uid(number))
    command = [*_walls(_uid(number), environment), *_mounts(), *bound, "--chdir", "/"]
    log, out = given / "log", given / "course.tar"
    with open(log, "ab") as errors, open(out, "wb") as files:
        process = subprocess.Popen(
            [*command, "--", "sh", "-c", script],
            stdin=subprocess.DEVNULL,
            stdout=files,
            stderr=errors,
        )
        try:
            hung = _watch(process, given, len(steps), stall_seconds)
        finally:
            _end(process)
    return Outcome(dict(_unpacked(out)), log, hung)


def _uid(number: int) -> int:
    return FIRST_UID + number % UIDS


def _script(steps: Sequence[Sequence[str]], uid: int) -> str:
    lines = [f"step {n} {shlex.join(step)}" for n, step in enumerate(steps, 1)]
    words = {
        "STEPS": "\n".join(lines),
        "SMALL": rf"! -type d \( ! -type f -o -size -{LONGEST_FILE // 1024}k \) -print0",
        "MADE": " ".join(MADE),
        "WATCHED": " ".join(WATCHED),
        "$AS": _as(uid),
    }
    text = SCRIPT
    for word, value in words.items():
        text = text.replace(word, value)
    return text


def _as(uid: int) -> str:
    """The start of a command that runs as the container's user, within its limits."""
    limits = ["prlimit", *(f"--{name}={value}" for name, value in LIMITS.items())]
    if os.getuid() != 0:
        return shlex.join(limits)
    become = ["setpriv", "--reuid", str(uid), "--regid", str(uid), "--clear-groups"]
    return shlex.join([*become, "--no-new-privs", *limits])


def _walls(uid: int, environment: Mapping[str, str]) -> list[str]:
    options = ["bwrap", "--die-with-parent", "--new-session", "--clearenv", "--as-pid-1"]
    options += ["--unshare-pid", "--unshare-net", "--unshare-ipc", "--unshare-uts"]
    options += ["--unshare-cgroup-try", "--hostname", "grader", "--cap-drop", "ALL"]
    if os.getuid() == 0:
        options += ["--cap-add", "CAP_SETUID", "--cap-add", "CAP_SETGID"]
    else:
        options += ["--unshare-user", "--disable-userns", "--uid", str(uid), "--gid", str(uid)]
    values = inside.ENVIRONMENT | {"HOME": "/home", "USER": "grader", "MPLCONFIGDIR": "/home"}
    values |= {"PATH": f"{Path(sys.prefix, 'bin')}:{values['PATH']}", **environment}
    for name, value in values.items():
        options += ["--setenv", name, value]
    return options


def _mounts() -> list[str]:
    options = ["--proc", "/proc", "--dev", "/dev"]
    for place, size in {"/dev/shm": 256, "/tmp": 256, "/home": 64, COURSE: 1024}.items():
        options += ["--perms", "1777", "--size", str(size * 2**20), "--tmpfs", str(place)]
    made: set[Path] = set()
    for path in [*SYSTEM, *_programs()]:
        for parent in reversed(path.parents[:-1]):
            if parent not in made:
                options += ["--perms", "0755", "--dir", str(parent)]
                made.add(parent)
        if path.is_symlink():
            options += ["--symlink", os.readlink(path), str(path)]
        elif path.exists():
            options += ["--ro-bind", str(path), str(path)]
    return options


def _programs() -> list[Path]:
    """The interpreter, its environment, and the course's packages where they are in place."""
    specs = [importlib.util.find_spec(name) for name in ("robust_slam", "robust_slam_autograder")]
    packages = [Path(spec.origin).parent for spec in specs if spec and spec.origin]
    resolved = dict.fromkeys(Path(path).resolve() for path in (sys.base_prefix, sys.prefix))
    apart = [path for path in resolved if not view.within(path, SYSTEM)]
    return [*apart, *(path for path in packages if not view.within(path, apart))]


def _watch(
    process: subprocess.Popen[bytes], given: Path, steps: int, stall_seconds: float
) -> frozenset[int]:
    """Wait until a container ends; end the steps that stall, and what takes too much memory."""
    hung: list[int] = []
    size, since = -1, time.monotonic()
    while process.poll() is None:
        time.sleep(LOOK_SECONDS)
        _spare_the_machine(process.pid)
        now = (given / "log").stat().st_size
        if now != size:
            size, since = now, time.monotonic()
        elif time.monotonic() - since > stall_seconds:
            current = 1 + _ended(given / "log")
            if current > steps or current in hung:
                break
            hung.append(current)
            (given / f"stop-{current}").touch()
            since = time.monotonic()
    return frozenset(hung)


def _ended(log: Path) -> int:
    with open(log, "rb") as file:
        return sum(line.startswith(b"step ") and b" ends with " in line for line in file)


def _spare_the_machine(pid: int) -> None:
    """End the largest process of a container that takes too much memory, as a kernel would."""
    sizes = {}
    with suppress(psutil.Error):
        for process in psutil.Process(pid).children(recursive=True):
            with suppress(psutil.Error):
                sizes[process] = process.memory_info().rss
    if sum(sizes.values()) > MEMORY_BYTES:
        with suppress(psutil.Error):
            max(sizes, key=lambda process: sizes[process]).kill()


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a container with all that is in it: its first process takes the others along."""
    with suppress(psutil.Error):
        for child in psutil.Process(process.pid).children():
            child.send_signal(signal.SIGKILL)
    process.kill()
    process.wait()


def _unpacked(archive: Path) -> Iterator[tuple[str, File]]:
    """What a container handed out, as far as it can be read."""
    with suppress(tarfile.TarError, EOFError), tarfile.open(archive, errorlevel=0) as files:
        for member in files:
            data = files.extractfile(member) if member.isreg() else None
            kind = "file" if member.isreg() else "link" if member.issym() else "other"
            content = data.read() if data else b""
            yield member.name, File(kind, member.mode & 0o777, member.linkname, content)


def states(course: Path) -> dict[str, tuple[object, ...]]:
    """The files that must stay as they are, before a course is graded."""
    found = {}
    for folder in WATCHED:
        for top, folders, files in os.walk(course / folder):
            links = [name for name in folders if Path(top, name).is_symlink()]
            for path in (Path(top, name) for name in [*files, *links]):
                file = _file(path)
                if file is not None:
                    found[str(path.relative_to(course))] = file.state
    return found


def _file(path: Path) -> File | None:
    facts = path.lstat()
    mode = stat.S_IMODE(facts.st_mode) & 0o777
    if stat.S_ISLNK(facts.st_mode):
        return File("link", mode, os.readlink(path), b"")
    if not stat.S_ISREG(facts.st_mode):
        return File("other", mode, "", b"")
    return File("file", mode, "", path.read_bytes()) if facts.st_size < LONGEST_FILE else None
