"""What student code behind the wall can see, reach and use up."""

import itertools
import json
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from robust_slam_autograder.executor.session import SessionFault
from robust_slam_autograder.reading.assignment import DEFAULT_PACKAGES
from robust_slam_autograder.sandbox import Fork, Unsandboxed, terms, view

from ..as_user import ROOT
from .probing import LAUNCH, is_private, run

TOKEN = "planted-token-77"

PROBE = """
import ctypes, errno, fcntl, mmap, os, resource, socket, struct, subprocess, sys

LIMITS = ("RLIMIT_AS", "RLIMIT_CORE", "RLIMIT_FSIZE", "RLIMIT_NOFILE")

def look():
    facts = {
        "environment": dict(os.environ),
        "identity": [os.getuid(), os.getgid(), os.getgroups()],
        "rights": rights(),
        "top": sorted(content("/") or []),
        "etc": sorted(content("/etc") or []),
        "descriptors": [n for n in range(200) if is_open(n)],
        "arguments": sys.argv,
        "limits": {name: resource.getrlimit(getattr(resource, name))[1] for name in LIMITS},
    }
    facts["writable"] = [path for path in (*WRITABLE, os.environ["HOME"]) if write(path)]
    return facts | {"reach": reach()}

def rights():
    c = ctypes.CDLL(None)
    found = (ctypes.c_uint * 6)()
    c.capget(bytes(struct.pack("Ii", 0x20080522, 0)), found)
    return {"capabilities": [found[n] for n in (0, 1, 3, 4)], "no new": c.prctl(39, 0, 0, 0, 0)}

def is_open(number):
    try:
        os.fstat(number)
        return True
    except OSError:
        return False

def content(path):
    try:
        return os.listdir(path) if os.path.isdir(path) else open(path, "rb").read(20)
    except OSError:
        return None

def write(folder):
    try:
        with open(os.path.join(folder, "mark"), "w") as file:
            return file.write("mark")
    except OSError:
        return 0

def attempt(what):
    try:
        return repr(what())
    except BaseException as error:
        return type(error).__name__

LIBC = ctypes.CDLL(None, use_errno=True)
OPTIONS = {"SO_SNDBUF": 7, "SO_RCVBUF": 8, "SO_SNDBUFFORCE": 32, "SO_RCVBUFFORCE": 33,
           "SO_RESERVE_MEM": 73, "SO_ATTACH_FILTER": 26}
CALLS = {"memfd_create": 319, "vmsplice": 278, "tee": 276, "shmget": 29, "semget": 64,
         "msgget": 68, "mq_open": 240, "landlock_create_ruleset": 444, "io_uring_setup": 425,
         "inotify_init": 253, "add_key": 248, "bpf": 321, "perf_event_open": 298,
         "fadvise64": 221, "readahead": 187, "mincore": 27, "cachestat": 451,
         "io_setup": 206, "sysinfo": 99, "ustat": 136}
if os.uname().machine != "x86_64":
    CALLS = {}  # they have other numbers

def refused():
    pair, pipe, folder = socket.socketpair(), os.pipe(), os.open(".", os.O_RDONLY)
    found = {
        "network": attempt(lambda: socket.create_connection(("127.0.0.1", 22), 0.2)),
        "another's limits": attempt(lambda: resource.prlimit(1, resource.RLIMIT_NOFILE)),
        "memory without a process": attempt(lambda: os.memfd_create("x")),
        "memory that nobody counts": attempt(lambda: mmap.mmap(-1, 4096)),
        "a lease": attempt(lambda: fcntl.fcntl(open(os.__file__), fcntl.F_SETLEASE, 0)),
        "datagrams": attempt(lambda: socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)),
        "a named socket": attempt(lambda: pair[0].bind(chr(0) + "taken")),
        "to a named socket": attempt(lambda: pair[0].connect(chr(0) + "taken")),
        "F_SETPIPE_SZ": attempt(lambda: fcntl.fcntl(pipe[1], 1031, 1 << 20)),
        "F_NOTIFY": attempt(lambda: fcntl.fcntl(folder, 1026, 0xFF)),
        "how full a disk is": attempt(lambda: os.statvfs("/")),
        "RWF_NOWAIT": attempt(lambda: os.preadv(folder, [bytearray(1)], 0, os.RWF_NOWAIT)),
    }
    for name, option in OPTIONS.items():
        found[name] = attempt(lambda: pair[0].setsockopt(socket.SOL_SOCKET, option, 1 << 26))
    for name, number in CALLS.items():
        result = LIBC.syscall(number, b"x", 0, 0, 0, 0)
        is_refused = result < 0 and ctypes.get_errno() == errno.EPERM
        found[name] = "PermissionError" if is_refused else "?"
    return found

def reach():
    return {
        "namespace": LIBC.unshare(0x10000000),
        "mount": LIBC.mount(b"x", b"/tmp", b"tmpfs", 0, None),
        "another's memory": LIBC.shmat(0, None, 0),
        "watches": LIBC.inotify_init(),
        "become root": attempt(lambda: os.setuid(0)),
        "kill the parent": attempt(lambda: os.kill(1, 9)),
        "raise a limit": attempt(lambda: resource.setrlimit(
            resource.RLIMIT_AS, (2**40, 2**40))),
        "survival": attempt(lambda: open("/proc/self/oom_score_adj", "w").write("-17")),
        "subprocess": subprocess.run(
            [sys.executable, "-S", "-c", "import os; print(os.getuid())"],
            capture_output=True, text=True).stdout,
        "a shell": attempt(lambda: subprocess.run(["/bin/sh", "-c", "true"])),
        "refused": refused(),
    }

def use_up():
    kids, full = 0, 0
    try:
        for _ in range(500):
            if os.fork() == 0:
                import time
                time.sleep(20)
                os._exit(0)
            kids += 1
    except OSError:
        pass
    try:
        for n in range(1000):
            with open(os.path.join(os.environ["HOME"], str(n)), "wb") as file:
                full += file.write(bytes(2**20))
    except OSError:
        pass
    return {
        "processes": kids,
        "disk": full,
        "memory": attempt(lambda: bytearray(2**34)),
        "files": attempt(lambda: [open("/dev/null") for _ in range(2000)]),
    }
"""


SECRETS = (
    *(ROOT / name for name in ("solutions", "chapters", "tests", "build", ".git", "README.md")),
    *map(Path, ("/etc/passwd", "/etc/shadow", "/var", "/home", "/run", "/sys", "/root/.ssh")),
    *map(Path, ("/proc/1/environ", "/proc/1/root/etc/passwd", "/proc/1/cwd/etc/passwd")),
    *(Path("/proc", name) for name in ("vmstat", "meminfo", "stat", "net/dev", "sys/fs/aio-nr")),
    *(Path("/proc/self", name) for name in ("cmdline", "mountinfo", "maps", "status")),
    *map(Path, ("/usr/bin", "/bin", "/usr/src", "/usr/include", "/opt", "/srv")),
)
WRITABLE = ("/", "/usr", "/etc", "/dev", "/proc", "/tmp", "/dev/shm", str(ROOT), sys.prefix)


@pytest.fixture(scope="module")
def facts(wall):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COURSE_TOKEN", TOKEN)
        patch.setenv("ROBUST_SLAM_SEED", "31415926")
        found: dict[str, Any] = run(wall, "look", PROBE, f"WRITABLE = {WRITABLE!r}")
    return found


@pytest.mark.sandbox
class TestWhatIsSeen:
    def test_the_root_holds_no_more_than_is_needed(self, facts, wall):
        assert facts["etc"] == (["ld.so.cache"] if is_private(wall) else [])
        known = {"dev", "etc", "lib", "lib64", "tmp", "usr"}
        way = {path.parts[1] for path in (ROOT, Path(sys.base_prefix), Path(sys.prefix))}
        assert set(facts["top"]) <= known | way

    def test_the_environment_is_the_sandboxs_own(self, facts):
        assert set(facts["environment"]) <= {*terms.ENVIRONMENT, "PWD", "LC_CTYPE", "TMPDIR"}
        assert TOKEN not in json.dumps(facts) and "31415926" not in json.dumps(facts)
        assert facts["arguments"] == [""]

    def test_it_has_no_rights_and_no_files_open(self, facts):
        assert facts["rights"] == {"capabilities": [0] * 4, "no new": 1}
        assert facts["identity"][0] != 0
        assert os.getuid() != 0 or facts["identity"][2] == []
        assert len(facts["descriptors"]) == 6  # four that lead nowhere, and the two pipes

    def test_the_kernel_limits_each_process(self, facts):
        assert facts["limits"] == {
            "RLIMIT_AS": terms.MEMORY_BYTES,
            "RLIMIT_CORE": 0,
            "RLIMIT_FSIZE": terms.SCRATCH_BYTES,
            "RLIMIT_NOFILE": 128,
        }

    def test_only_scratch_folders_are_writable(self, facts, wall):
        own = facts["environment"]["HOME"]
        # The way to a course below /tmp is made of folders in the sandbox's own /tmp.
        writable = [p for p in facts["writable"] if p == own or not p.startswith("/tmp/")]
        assert writable == (["/tmp", "/dev/shm", own] if is_private(wall) else [own])
        assert not (ROOT / "mark").exists()


@pytest.mark.sandbox
def test_what_is_out_of_reach(facts):
    found = dict(facts["reach"])
    assert found.pop("subprocess").strip().isdecimal()
    # Where a folder can be seen and not opened, and where there is none.
    assert found.pop("survival") in ("PermissionError", "FileNotFoundError")
    assert found.pop("a shell") in ("FileNotFoundError", "PermissionError")
    # A user namespace does not know root; outside one, root is there and out of reach.
    assert found.pop("become root") in ("PermissionError", "OSError")
    refused = found.pop("refused")
    assert {what for what, said in refused.items() if said != "PermissionError"} == set()
    assert found == {
        "another's memory": -1,
        "watches": -1,
        "namespace": -1,
        "mount": -1,
        "kill the parent": "PermissionError",
        "raise a limit": "ValueError",
    }


EVERYTHING = """
import os

def readable():
    found = []
    for path in (*GUESSES, *everywhere()):
        try:
            if os.path.isdir(path):
                found += [os.path.join(path, name) for name in os.listdir(path)]
            else:
                open(path, "rb").read(1)
                found.append(path)
        except OSError:
            pass
    return found

def everywhere():
    for top, folders, files in os.walk("/"):
        if top == "/":
            folders[:] = [name for name in folders if name not in ("proc", "sys", "dev", "tmp")]
        yield from (os.path.join(top, name) for name in files)
"""


def guesses() -> list[str]:
    """Files of this machine, one a folder: for student code that can list none of its folders."""
    found = [str(STANDARD / "os.py")]
    for top in ("/etc", "/usr", "/opt", "/var/lib", str(ROOT), str(SITE), str(STANDARD)):
        for folder, folders, files in os.walk(top):
            deep = folder.count("/") - top.count("/") > 3
            folders[:] = [] if deep else [name for name in folders if name != ".git"]
            plain = (f"{folder}/{name}" for name in files)
            found += list(itertools.islice(filter(os.path.isfile, plain), 1))
    return found


STANDARD = Path(os.__file__).resolve().parent
SITE = Path(np.__file__).resolve().parents[1]
SHOWN = ("/etc/ld.so.cache", "/usr/share/zoneinfo/", "/usr/lib/locale/C.utf8/")
LEFT_OUT = ("site-packages", "dist-packages", "ensurepip", "test", "tkinter")
NOT_NEEDED = ("gtsam", "evo", "networkx", "pandas", "nbgrader", "pytest", "cvxpy", "robust_slam")


def is_needed(path: str) -> bool:
    """Whether a file belongs to the interpreter, to numpy and the like, or to the grader."""
    if path.startswith(f"{STANDARD}/"):
        return Path(path).relative_to(STANDARD).parts[0] not in LEFT_OUT
    if path.startswith(f"{SITE}/"):
        return not Path(path).relative_to(SITE).parts[0].startswith(NOT_NEEDED)
    own = (*SHOWN, str(Path(terms.__file__).parents[1]), os.path.realpath(sys.executable))
    return ".so" in Path(path).name or path.startswith(own)


@pytest.mark.sandbox
def test_every_file_that_can_be_read_is_one_that_is_needed(wall, tmp_path):
    """Of the whole disk; a course may lie anywhere, such as in /usr/src or /usr/local/share."""
    planted = tmp_path / "secret.txt"
    planted.write_text(TOKEN)
    paths = [*guesses(), *map(str, (*SECRETS, tmp_path, planted))]
    found = run(wall, "readable", EVERYTHING, f"GUESSES = {paths!r}")
    assert str(STANDARD / "os.py") in found and len(found) > 100
    assert [path for path in found if not is_needed(path)] == []


@pytest.mark.sandbox
def test_what_is_limited(wall):
    if not is_private(wall):
        with pytest.raises(SessionFault):  # its keeper ends it
            run(wall, "use_up", PROBE)
        return
    found = run(wall, "use_up", PROBE)
    assert 0 < found["processes"] <= terms.PROCESSES
    assert 0 < found["disk"] <= terms.SCRATCH_BYTES
    assert (found["memory"], found["files"]) == ("MemoryError", "OSError")


MANY = """
import os

def make():
    return {folder: files_in(folder) for folder in FOLDERS}

def files_in(folder):
    made = 0
    try:
        for n in range(200_000):
            os.close(os.open(os.path.join(folder, str(n)), os.O_CREAT | os.O_WRONLY))
            made += 1
    except OSError:
        pass
    return made
"""


@pytest.mark.sandbox
def test_files_of_no_size_are_counted(wall):
    """Each takes some of the kernel's memory, which no process's size shows."""
    if is_private(wall):
        made = run(wall, "make", f"{MANY}\nFOLDERS = ('/tmp', '/dev/shm')\n")
        assert min(made.values()) > 0 and max(made.values()) <= terms.SCRATCH_FILES
        return
    with pytest.raises(SessionFault) as caught:  # its keeper ends it
        run(wall, "make", f"{MANY}\nFOLDERS = [os.environ['HOME']]\n")
    assert caught.value.kind == "died"


PACKAGE = {
    "__init__.py": "",
    "given.py": "ANSWER = 'given'\n",
    "answers.py": "ANSWER = 'secret'\n",
    "deep/__init__.py": "ANSWER = 'secret'\n",
    "deep/inner.py": "ANSWER = 'secret'\n",
}
TRICKS = """
import importlib, importlib.machinery, importlib.util, os, sys
import withheld_demo
FOLDER = os.path.dirname(withheld_demo.__file__)

def times():
    return [os.lstat(os.path.join(FOLDER, name)).st_atime_ns for name in ("given.py", "link", "")]

def moved():
    before = times()
    open(os.path.join(FOLDER, "given.py")).read()
    os.readlink(os.path.join(FOLDER, "link"))
    os.listdir(FOLDER)
    return [now != then for now, then in zip(times(), before)]

def read(path):
    try:
        with open(path, "rb") as file:
            return file.read()
    except OSError:
        return b""

def answer(load):
    try:
        return getattr(load(), "ANSWER", None)
    except (ImportError, OSError):
        return "no module"

def from_file(path):
    loader = importlib.machinery.SourceFileLoader("x", path)
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("x", loader))
    loader.exec_module(module)
    return module

def search():
    access_times = moved()
    fonts = os.access("/tmp/fontlist-v1.json", os.R_OK)
    files = [os.path.join(top, name) for top, _, names in os.walk(FOLDER) for name in names]
    sys.meta_path[:] = [importlib.machinery.PathFinder]
    sys.path_importer_cache.clear()
    names = ("given", "answers", "alias", "deep", "deep.inner")
    got = [answer(lambda: importlib.import_module("withheld_demo." + name)) for name in names]
    got.append(answer(lambda: from_file(os.path.join(FOLDER, "answers.py"))))
    seen = [path for path in files if b"secret" in read(path)]
    return {"moved": access_times, "fonts": fonts, "files": seen, "got": got}
"""


@pytest.mark.sandbox
def test_of_a_withheld_module_nothing_is_there_and_what_is_read_tells_nobody(
    wall, tmp_path_factory, monkeypatch
):
    """Neither its source nor its cached code is there, should a student clear the import hooks."""
    folder = tmp_path_factory.mktemp("packages")
    package = folder / "withheld_demo"
    for name, text in PACKAGE.items():
        (package / name).parent.mkdir(exist_ok=True)
        (package / name).write_text(text)
    (package / "alias.py").symlink_to("answers.py")
    (package / "link").symlink_to("given.py")
    compile_all = [sys.executable, "-m", "compileall", "-q", str(package)]
    assert os.spawnv(os.P_WAIT, sys.executable, compile_all) == 0
    assert list(package.glob("__pycache__/answers.*"))
    (folder / "fontlist-v1.json").write_text("{}")
    # What was not read since it was made has an access time that the next one moves.
    for path in (package / "link", package / "given.py", package):
        os.utime(path, (0, 0), follow_symlinks=False)
    for way in (folder, *folder.parents):
        if way.is_relative_to(tempfile.gettempdir()) and way != Path(tempfile.gettempdir()):
            way.chmod(0o755)
    withheld = tuple(f"withheld_demo.{name}" for name in ("answers", "deep", "deep.inner"))
    # Not the same ones for each back end: the package lies elsewhere.
    allowed = (*DEFAULT_PACKAGES, "withheld_demo", folder.name)
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setenv("MPLCONFIGDIR", str(folder))
    # The same back end, without the servers that it has started already.
    fresh = Fork(namespaces=is_private(wall))
    found = run(fresh, "search", TRICKS, withheld=withheld, packages=allowed)
    assert found["files"] == []
    assert found["got"][0] == "given" and "secret" not in found["got"]
    assert found["moved"] == [False] * 3
    assert found["fonts"] is is_private(wall), "matplotlib finds its list of fonts"


@pytest.mark.sandbox
def test_a_whole_package_and_a_single_file_are_withheld_and_nothing_beside():
    single, site = "ipython_pygments_lexers", Path(np.__file__).parents[1]
    files = view.files(DEFAULT_PACKAGES, ("numpy", single, "no_such_module.part"))
    shown = [path for path, is_shown in files.rules if is_shown]
    assert site / "numpy" not in shown and site / f"{single}.py" not in shown
    assert site / "IPython" in shown and "no_such_module" not in str(files.rules)


def test_a_process_that_does_not_start_says_why(monkeypatch):
    command = [sys.executable, "-c", "import sys; sys.exit('no such luck')"]
    monkeypatch.setattr(terms, "python_script", lambda script, settings: command)
    running = Unsandboxed().start(LAUNCH)
    assert running.await_ready() == "no such luck"
    running.stop()


def test_a_stopped_process_leaves_no_scratch_folder():
    running = Unsandboxed().start(LAUNCH)
    assert running.await_ready() is None
    assert running.scratch is not None and Path(running.scratch.name).is_dir()
    running.stop()
    assert not Path(running.scratch.name).exists()
    assert running.process.returncode is not None


PLAIN_WORK = """
import asyncio, concurrent.futures, subprocess, sys, tempfile, threading
import numpy as np
import matplotlib.pyplot as plt

def work():
    with tempfile.NamedTemporaryFile("w+") as file:
        file.write("1")
        plt.plot([1, 2])
        plt.savefig("picture.png")
    with tempfile.TemporaryFile() as file:
        file.write(b"1")
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        squares = list(pool.map(lambda x: x * x, range(5)))
    printed = subprocess.run([sys.executable, "-S", "-c", "print(6 * 7)"], capture_output=True)
    return [asyncio.run(answer()), squares, printed.stdout.decode(), np.random.random() < 1]

async def answer():
    await asyncio.sleep(0)
    return 42
"""


@pytest.mark.sandbox
def test_plain_work_goes_on(wall):
    assert run(wall, "work", PLAIN_WORK) == [42, [0, 1, 4, 9, 16], "42\n", True]
