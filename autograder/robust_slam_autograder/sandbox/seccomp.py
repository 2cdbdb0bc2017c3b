"""A filter of system calls for all back ends, as a classic BPF program.

It refuses what student code has no use for and what reaches around the other
walls: namespaces and mounts of its own (with them it could mount as much memory as
it likes), sockets, memory that belongs to no process, key rings, and whatever acts on
another process. Landlock does not guard modes, owners and times of files: where
student code runs as the grader's own user, they would be in its reach, so calls that
change them do nothing, and say that all is well. The list follows the kernel's tables
(arch/x86/entry/syscalls, include/uapi/asm-generic).
"""

from __future__ import annotations

import errno
import platform
import struct

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x06
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT = 0, 4, 16
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050000, 0x80000000
_PRETEND = 0

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
        *(41, 319, 29, 68, 64, 240),  # socket memfd_create shmget msgget semget mq_open
        *(101, 310, 311, 312),  # ptrace process_vm_readv process_vm_writev kcmp
        *(141, 251, 256, 279),  # setpriority ioprio_set migrate_pages move_pages
    ),
    "aarch64": (
        *(41, 40, 39, 97, 268),
        *(217, 218, 219),
        *(241, 280, 282),
        *(198, 279, 194, 186, 190, 180),
        *(117, 270, 271, 272),
        *(140, 30, 238, 239),
    ),
}
_REFUSED_EVERYWHERE = (
    *(425, 426, 427),  # io_uring_setup io_uring_enter io_uring_register
    *(428, 429, 430, 431, 432, 433, 442),  # open_tree move_mount fs… fspick mount_setattr
    *(438, 440, 447, 448),  # pidfd_getfd process_madvise memfd_secret process_mrelease
)
"""New calls have one number on every architecture."""
_OF_ITSELF_ALONE = {
    "x86_64": (302, 142, 144, 203, 314),  # prlimit64 sched_setparam …scheduler …affinity …attr
    "aarch64": (261, 118, 119, 122, 274),
}
"""Their first argument is a process; 0 is the caller."""
_PRETENDED = {
    "x86_64": (
        *(90, 91, 268),  # chmod fchmod fchmodat
        *(92, 93, 94, 260),  # chown fchown lchown fchownat
        *(188, 189, 190, 197, 198, 199),  # setxattr lset… fset… removexattr lremove… fremove…
        *(132, 235, 261, 280),  # utime utimes futimesat utimensat
    ),
    "aarch64": (52, 53, 54, 55, 5, 6, 7, 14, 15, 16, 88),
}
_PRETENDED_EVERYWHERE = (452, 463, 466)
"""fchmodat2 setxattrat removexattrat."""


def program(machine: str | None = None) -> bytes | None:
    """The filter for this machine's architecture; None where we do not know its numbers.

    Args:
        machine: as ``platform.machine()`` names it.
    """
    machine = machine or platform.machine()
    if machine not in _AUDIT:
        return None
    answers = dict.fromkeys((*_REFUSED[machine], *_REFUSED_EVERYWHERE), errno.EPERM)
    answers |= dict.fromkeys((*_PRETENDED[machine], *_PRETENDED_EVERYWHERE), _PRETEND)
    lines = [
        _line(_LOAD, _ARCHITECTURE),
        _line(_EQUAL, _AUDIT[machine], if_true=1),
        _line(_RETURN, _KILL),
        _line(_LOAD, _NUMBER),
        *_refuse_if(_AT_LEAST, _X32_BIT, errno.ENOSYS),
        *_refuse_if(_EQUAL, _CLONE3, errno.ENOSYS),
    ]
    for number, answer in answers.items():
        lines += _refuse_if(_EQUAL, number, answer)
    for number in _OF_ITSELF_ALONE[machine]:
        lines += [
            _line(_EQUAL, number, if_false=4),
            _line(_LOAD, _FIRST_ARGUMENT),
            _line(_EQUAL, 0, if_true=1),
            _line(_RETURN, _REFUSE | errno.EPERM),
            _line(_RETURN, _ALLOW),
        ]
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
