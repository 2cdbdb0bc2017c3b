"""A filter of system calls for bubblewrap, as a classic BPF program.

It refuses what student code has no use for and what reaches around the other
walls: namespaces of its own (with them it could mount as much memory as it likes),
mounts, and the kernel's key rings, which no namespace keeps apart. The list
follows the kernel's tables (arch/x86/entry/syscalls, include/uapi/asm-generic).
"""

from __future__ import annotations

import errno
import platform
import struct

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT = 0, 4, 16
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050000, 0x80000000

_AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_X32_BIT = 0x40000000
_CLONE = {"x86_64": 56, "aarch64": 220}
_CLONE_NAMESPACES = 0x7E020080
_CLONE3 = 435
"""Its flags lie behind a pointer, where no filter sees them; the C library falls back to clone."""
_REFUSED = {
    "x86_64": (
        *(155, 165, 166, 272, 308),  # pivot_root mount umount2 unshare setns
        *(248, 249, 250),  # add_key request_key keyctl
        *(298, 321, 323),  # perf_event_open bpf userfaultfd
    ),
    "aarch64": (*(41, 40, 39, 97, 268), *(217, 218, 219), *(241, 280, 282)),
}
_REFUSED_EVERYWHERE = (425, 426, 427, 428, 429, 430, 431, 432, 433, 442)
"""io_uring_setup …enter …register open_tree move_mount fsopen fsconfig fsmount fspick
mount_setattr: new calls have one number on every architecture."""


def program(machine: str | None = None) -> bytes | None:
    """The filter for this machine's architecture; None where we do not know its numbers.

    Args:
        machine: as ``platform.machine()`` names it.
    """
    machine = machine or platform.machine()
    if machine not in _AUDIT:
        return None
    refused = [*_REFUSED[machine], *_REFUSED_EVERYWHERE]
    lines = [
        _line(_LOAD, _ARCHITECTURE),
        _line(_EQUAL, _AUDIT[machine], if_true=1),
        _line(_RETURN, _KILL),
        _line(_LOAD, _NUMBER),
        *_refuse_if(_AT_LEAST, _X32_BIT, errno.ENOSYS),
        *_refuse_if(_EQUAL, _CLONE3, errno.ENOSYS),
    ]
    for number in refused:
        lines += _refuse_if(_EQUAL, number, errno.EPERM)
    lines += [
        _line(_EQUAL, _CLONE[machine], if_false=3),
        _line(_LOAD, _FIRST_ARGUMENT),
        *_refuse_if(_ANY_BIT, _CLONE_NAMESPACES, errno.EPERM),
        _line(_RETURN, _ALLOW),
    ]
    return b"".join(lines)


def _refuse_if(test: int, value: int, error: int) -> list[bytes]:
    return [_line(test, value, if_false=1), _line(_RETURN, _REFUSE | error)]


def _line(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    """One instruction; jumps count the instructions to skip."""
    return struct.pack("<HBBI", code, if_true, if_false, value)
