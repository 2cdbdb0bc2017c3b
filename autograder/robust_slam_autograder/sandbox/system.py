"""System calls that Python has no function for, each with an OSError that names it."""

import ctypes
import os
import platform
import signal
import struct
from pathlib import Path

NEW_NAMESPACE = {
    "mount": 0x00020000,
    "uts": 0x04000000,
    "ipc": 0x08000000,
    "user": 0x10000000,
    "pid": 0x20000000,
    "net": 0x40000000,
}
NO_SUID, NO_DEV = 2, 4
BIND, RECURSIVE, PRIVATE = 4096, 16384, 1 << 18
_DETACH = 2
_PIVOT_ROOT = {"x86_64": 155, "aarch64": 41}
_MOUNT_SETATTR, _AT_RECURSIVE, _AT_FDCWD = 442, 0x8000, -100
_ATTR_READ_ONLY, _ATTR_NO_SUID = 1, 2
_SET_PARENT_DEATH_SIGNAL = 1
_SET_DUMPABLE, _SET_SECCOMP, _SET_SUBREAPER, _SET_NO_NEW_PRIVS = 4, 22, 36, 38
_SECCOMP_FILTER = 2
_CAPABILITY_VERSION = 0x20080522
INSTRUCTION = 8
"""Bytes of one instruction of a seccomp filter."""

_libc = ctypes.CDLL(None, use_errno=True)


def call(number: int, *arguments: object) -> int:
    """Make a system call by its number.

    Raises:
        OSError: the kernel refuses it or does not know it.
    """
    return _checked(f"system call {number}", _libc.syscall(ctypes.c_long(number), *arguments))


def _checked(what: str, result: int) -> int:
    if result < 0:
        code = ctypes.get_errno()
        raise OSError(code, f"{what}: {os.strerror(code)}")
    return result


def unshare(*names: str) -> None:
    """Leave namespaces of these kinds for new ones; of "pid" only children live in the new one."""
    flags = sum(NEW_NAMESPACE[name] for name in names)
    _checked(f"unshare({', '.join(names)})", _libc.unshare(flags))


def leave(*names: str) -> None:
    """Leave namespaces as ``unshare`` does: who is not root may, in a namespace of users too."""
    uid, gid = os.getuid(), os.getgid()
    unshare(*(() if uid == 0 else ("user",)), *names)
    if uid != 0:
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{uid} {uid} 1")
        Path("/proc/self/gid_map").write_text(f"{gid} {gid} 1")


def join(process: int, *names: str) -> None:
    """Go to namespaces of a process, of which this is a descriptor, that left its own as above."""
    names = (*(() if os.getuid() == 0 else ("user",)), *names)
    flags = sum(NEW_NAMESPACE[name] for name in names)
    _checked(f"setns({', '.join(names)})", _libc.setns(process, flags))


def mount(source: str, target: str, kind: str = "", flags: int = 0, data: str = "") -> None:
    """Mount a file system, or bind a folder or a file."""
    texts = [text.encode() or None for text in (source, target, kind)]
    result = _libc.mount(*texts, ctypes.c_ulong(flags), data.encode() or None)
    _checked(f"mount {target}", result)


def make_read_only(folder: str) -> None:
    """Make every mount from a folder downwards read-only and deaf to set-user-id bits."""
    _change_mounts(folder, _AT_RECURSIVE, _ATTR_READ_ONLY | _ATTR_NO_SUID, 0)


def make_writable(folder: str) -> None:
    """Take one mount out of what ``make_read_only`` did."""
    _change_mounts(folder, 0, 0, _ATTR_READ_ONLY)


def _change_mounts(folder: str, flags: int, added: int, taken: int) -> None:
    attributes = struct.pack("=QQQQ", added, taken, 0, 0)
    size = ctypes.c_size_t(len(attributes))
    call(_MOUNT_SETATTR, _AT_FDCWD, folder.encode(), flags, attributes, size)


def enter_root(folder: str) -> None:
    """Make a mount the root of all paths, and drop the old root."""
    os.chdir(folder)
    call(_PIVOT_ROOT[platform.machine()], b".", b".")
    unmount(".")
    os.chdir("/")


def unmount(folder: str) -> None:
    """Take a mount away; what still uses it keeps it."""
    _checked(f"umount {folder}", _libc.umount2(folder.encode(), _DETACH))


def forbid_new_privileges() -> None:
    """Keep programs of this process from gaining rights by their set-user-id bit."""
    _prctl(_SET_NO_NEW_PRIVS, 1)


def let_trace(allowed: bool) -> None:
    """Say whether processes of the same user may look into this one."""
    _prctl(_SET_DUMPABLE, int(allowed))


def die_with_parent() -> None:
    """Be killed when the parent ends; a change of user undoes it."""
    _prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)


def adopt_orphans() -> None:
    """Become the parent of all descendants that lose theirs."""
    _prctl(_SET_SUBREAPER, 1)


def drop_capabilities() -> None:
    """Give up every capability for good."""
    header, nothing = struct.pack("=Ii", _CAPABILITY_VERSION, 0), bytes(24)
    _checked("capset", _libc.capset(header, nothing))


def install_filter(program: bytes) -> None:
    """Put a seccomp filter on this process and all that it starts."""
    code = ctypes.create_string_buffer(program, len(program))
    # struct sock_fprog: a count and a pointer.
    count = len(program) // INSTRUCTION
    pointer = struct.pack("@HP", count, ctypes.addressof(code))
    _prctl(_SET_SECCOMP, _SECCOMP_FILTER, pointer)


def _prctl(option: int, first: int, second: bytes | int = 0) -> None:
    argument = second if isinstance(second, bytes) else ctypes.c_ulong(second)
    zero = ctypes.c_ulong(0)
    result = _libc.prctl(option, ctypes.c_ulong(first), argument, zero, zero)
    _checked(f"prctl({option})", result)
