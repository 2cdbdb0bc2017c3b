"""A filter of system calls for all back ends, as a classic BPF program.

It refuses what student code has no use for and what reaches around the other
walls: namespaces and mounts of its own (with them it could mount as much memory as
it likes), sockets with a name or a larger buffer, memory that belongs to no process, key
rings, asynchronous input and output (which one sandbox could use up for all), leases and watches
on files, and whatever acts on another process. Refused too is what tells of the whole machine: how
full its disks and its memory are, and which pages of files are in its cache, or what puts them in
or out. All sandboxes share these, so one could leave a message there for another. The list follows
the kernel's tables (arch/x86/entry/syscalls, include/uapi/asm-generic).

Locks on files seem to succeed and do nothing. A real one could be held on a file that every
sandbox and the grader share, and many small ones take the kernel's memory; refused, they would
stop SQLite. Each sandbox has its scratch folder to itself.
"""

from __future__ import annotations

import errno
import platform
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _AND, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x54, 0x06
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT, _ARGUMENT_BYTES = 0, 4, 16, 8
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050000, 0x80000000
_PRETEND, _WHOLE = 0, 0xFFFFFFFF

_AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_X32_BIT = 0x40000000
_CLONE = {"x86_64": 56, "aarch64": 220}
_CLONE_NAMESPACES = 0x7E020080
_CLONE3 = 435
"""Its flags are behind a pointer, where no filter sees them; the C library falls back to clone."""
_REFUSED = {
    "x86_64": (
        *(155, 165, 166, 272, 308),  # pivot_root mount umount2 unshare setns
        *(248, 249, 250),  # add_key request_key keyctl
        *(298, 321, 323),  # perf_event_open bpf userfaultfd
        *(41, 319, 278, 276),  # socket memfd_create vmsplice tee
        *(42, 49, 50, 54),  # connect bind listen setsockopt
        *(29, 30, 31),  # shmget shmat shmctl
        *(64, 65, 66, 220),  # semget semop semctl semtimedop
        *(68, 69, 70, 71),  # msgget msgsnd msgrcv msgctl
        *(240, 241),  # mq_open mq_unlink
        *(101, 310, 311, 312),  # ptrace process_vm_readv process_vm_writev kcmp
        *(141, 251, 256, 279),  # setpriority ioprio_set migrate_pages move_pages
        *(253, 294, 300),  # inotify_init inotify_init1 fanotify_init
        *(221, 187, 27),  # fadvise64 readahead mincore
        # io_setup io_destroy io_submit io_cancel io_getevents io_pgetevents
        *(206, 207, 209, 210, 208, 333),
        *(99, 136, 137, 138),  # sysinfo ustat statfs fstatfs
    ),
    "aarch64": (
        *(41, 40, 39, 97, 268),
        *(217, 218, 219),
        *(241, 280, 282),
        *(198, 279, 75, 77),
        *(203, 200, 201, 208),
        *(194, 196, 195),
        *(190, 193, 191, 192),
        *(186, 189, 188, 187),
        *(180, 181),
        *(117, 270, 271, 272),
        *(140, 30, 238, 239),
        *(26, 262),
        *(223, 213, 232),
        *(0, 1, 2, 3, 4, 292),
        *(179, 43, 44),
    ),
}
_REFUSED_EVERYWHERE = (
    *(425, 426, 427),  # io_uring_setup io_uring_enter io_uring_register
    *(428, 429, 430, 431, 432, 433, 442),  # open_tree move_mount fs… fspick mount_setattr
    *(438, 440, 447, 448),  # pidfd_getfd process_madvise memfd_secret process_mrelease
    *(444, 445, 446),  # landlock_create_ruleset landlock_add_rule landlock_restrict_self
    451,  # cachestat
)
"""New calls have one number on every architecture."""
_FLOCK = {"x86_64": 73, "aarch64": 32}
_PRETENDED = {
    "x86_64": (
        *(90, 91, 268),  # chmod fchmod fchmodat
        *(92, 93, 94, 260),  # chown fchown lchown fchownat
        *(188, 189, 190, 197, 198, 199),  # setxattr lset… fset… removexattr lremove… fremove…
        *(132, 235, 261, 280),  # utime utimes futimesat utimensat
        *(87, 263),  # unlink unlinkat
    ),
    "aarch64": (52, 53, 54, 55, 5, 6, 7, 14, 15, 16, 88, 35),
}
_PRETENDED_EVERYWHERE = (452, 463, 466)
"""fchmodat2 setxattrat removexattrat."""
_OPENAT2 = 437


@dataclass(frozen=True)
class Guard:
    """A call that is judged by one of its arguments.

    Attributes:
        numbers: the call's number by architecture.
        argument: which one, from 0.
        mask: the bits of it that count.
        answers: errors by the value of these bits; 0 pretends that the call was made.
        otherwise: the error for every other value, None where the call is allowed.
    """

    numbers: Mapping[str, int]
    argument: int
    mask: int
    answers: Mapping[int, int | None]
    otherwise: int | None = None


def _of_itself_alone(x86_64: int, aarch64: int) -> Guard:
    """Guard a call whose first argument is a process; 0 is the caller."""
    return Guard({"x86_64": x86_64, "aarch64": aarch64}, 0, _WHOLE, {0: None}, errno.EPERM)


_SHARED_ANONYMOUS, _NOT_A_STREAM, _NAMELESS = 0x21, 0xE, 0x400000
# A lease makes all others wait who open the file; a watch and a larger pipe take memory.
_SET_LEASE, _NOTIFY, _SET_PIPE_SIZE = 1024, 1026, 1031
_EVICT = (20, 21)
"""MADV_COLD MADV_PAGEOUT."""
_SET_LOCKS = (6, 7, 37, 38)
"""F_SETLK F_SETLKW F_OFD_SETLK F_OFD_SETLKW."""
_GUARDS = (
    _of_itself_alone(302, 261),  # prlimit64
    _of_itself_alone(142, 118),  # sched_setparam
    _of_itself_alone(144, 119),  # sched_setscheduler
    _of_itself_alone(203, 122),  # sched_setaffinity
    _of_itself_alone(314, 274),  # sched_setattr
    # Pages that no process's size shows.
    Guard({"x86_64": 9, "aarch64": 222}, 3, _SHARED_ANONYMOUS, {_SHARED_ANONYMOUS: errno.EPERM}),
    # fcntl
    Guard(
        {"x86_64": 72, "aarch64": 25},
        1,
        _WHOLE,
        dict.fromkeys((_SET_LEASE, _NOTIFY, _SET_PIPE_SIZE), errno.EPERM)
        | dict.fromkeys(_SET_LOCKS, _PRETEND),
    ),
    # madvise: pages that leave the cache.
    Guard({"x86_64": 28, "aarch64": 233}, 2, _WHOLE, dict.fromkeys(_EVICT, errno.EPERM)),
    # preadv2: its flags ask for what is cached alone.
    Guard({"x86_64": 327, "aarch64": 286}, 5, _WHOLE, {0: None}, errno.EPERM),
    # A datagram finds its way to any path: socketpair.
    Guard({"x86_64": 53, "aarch64": 199}, 1, _NOT_A_STREAM, {0: None}, errno.EPERM),
)
_GUARDS_ON_A_SHARED_DISK = (
    # Files without a name, which no one can count: open and openat.
    Guard({"x86_64": 2}, 1, _NAMELESS, {_NAMELESS: errno.EPERM}),
    Guard({"x86_64": 257, "aarch64": 56}, 2, _NAMELESS, {_NAMELESS: errno.EPERM}),
)


def program(machine: str | None = None, *, shared_disk: bool = False) -> bytes | None:
    """Return the filter for this machine's architecture; None where we do not know its numbers.

    Args:
        machine: as ``platform.machine()`` names it.
        shared_disk: whether student code works on the grader's own disk. Landlock does not
            guard modes, owners and times of files there, so calls that change them do nothing,
            and say that all is well; no file loses its name, or is without one, so that all
            can be counted.
    """
    machine = machine or platform.machine()
    if machine not in _AUDIT:
        return None
    return b"".join(
        [
            _line(_LOAD, _ARCHITECTURE),
            _line(_EQUAL, _AUDIT[machine], if_true=1),
            _line(_RETURN, _KILL),
            _line(_LOAD, _NUMBER),
            *_refuse_if(_AT_LEAST, _X32_BIT, errno.ENOSYS),
            *_answers(machine, shared_disk),
            *_guards(machine, shared_disk),
            _line(_EQUAL, _CLONE[machine], if_false=3),
            _line(_LOAD, _FIRST_ARGUMENT),
            *_refuse_if(_ANY_BIT, _CLONE_NAMESPACES, errno.EPERM),
            _line(_RETURN, _ALLOW),
        ]
    )


def _answers(machine: str, shared_disk: bool) -> Iterator[bytes]:
    """Yield what answers calls in place of making them."""
    answers = {_CLONE3: errno.ENOSYS}
    answers |= dict.fromkeys((*_REFUSED[machine], *_REFUSED_EVERYWHERE), errno.EPERM)
    answers[_FLOCK[machine]] = _PRETEND
    if shared_disk:
        answers |= dict.fromkeys((*_PRETENDED[machine], *_PRETENDED_EVERYWHERE), _PRETEND)
        answers[_OPENAT2] = errno.ENOSYS  # its flags, too, are behind a pointer
    for number, answer in answers.items():
        yield from _refuse_if(_EQUAL, number, answer)


def _guards(machine: str, shared_disk: bool) -> Iterator[bytes]:
    for guard in (*_GUARDS, *(_GUARDS_ON_A_SHARED_DISK if shared_disk else ())):
        if machine not in guard.numbers:
            continue
        lines = [
            _line(_LOAD, _FIRST_ARGUMENT + _ARGUMENT_BYTES * guard.argument),
            _line(_AND, guard.mask),
            *(line for value, error in guard.answers.items() for line in _judge(value, error)),
            _line(_RETURN, _action(guard.otherwise)),
        ]
        yield _line(_EQUAL, guard.numbers[machine], if_false=len(lines))
        yield from lines


def _judge(value: int, error: int | None) -> list[bytes]:
    return [_line(_EQUAL, value, if_false=1), _line(_RETURN, _action(error))]


def _action(error: int | None) -> int:
    return _ALLOW if error is None else _REFUSE | error


def _refuse_if(test: int, value: int, error: int) -> list[bytes]:
    return [_line(test, value, if_false=1), _line(_RETURN, _REFUSE | error)]


def _line(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    """Write one instruction; jumps count the instructions to skip."""
    return struct.pack("<HBBI", code, if_true, if_false, value)
