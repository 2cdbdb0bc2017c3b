"""A filter of system calls for all back ends, as a classic BPF program.

It refuses what student code has no use for and what reaches around the other
walls: namespaces and mounts of its own (with them it could mount as much memory as
it likes), sockets with a name or a larger buffer, memory that belongs to no process, key
rings, asynchronous input and output (which one sandbox could use up for all), leases and watches
on files, and whatever acts on another process. Refused too is what tells of the whole machine: how
full its disks and its memory are, what is mounted where, and which pages of files are in its
cache, or what puts them in or out. All sandboxes share these, so one could leave a message there
for another. The list follows the kernel's tables (arch/x86/entry/syscalls,
include/uapi/asm-generic).

Locks on files seem to succeed and do nothing. A real one could be held on a file that every
sandbox and the grader share, and many small ones take the kernel's memory; refused, they would
stop SQLite. Each sandbox has its scratch folder to itself.
"""

import errno
import platform
import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

_LOAD, _EQUAL, _AT_LEAST, _ANY_BIT, _AND, _RETURN = 0x20, 0x15, 0x35, 0x45, 0x54, 0x06
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT, _ARGUMENT_BYTES = 0, 4, 16, 8
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050000, 0x80000000
_PRETEND, _WHOLE = 0, 0xFFFFFFFF

_X32_BIT = 0x40000000
_CLONE_NAMESPACES = 0x7E020080

ARCHITECTURES = ("x86_64", "aarch64")
"""As ``platform.machine()`` names them. Below, numbers of calls come in this order."""
_AUDIT = (0xC000003E, 0xC00000B7)
_CLONE, _CLONE3 = (56, 220), 435
"""The flags of clone3 are behind a pointer, where no filter sees them; the C library falls back
to clone."""
_REFUSED = (
    ((155, 165, 166, 272, 308), (41, 40, 39, 97, 268)),  # pivot_root mount umount2 unshare setns
    ((248, 249, 250), (217, 218, 219)),  # add_key request_key keyctl
    ((298, 321, 323), (241, 280, 282)),  # perf_event_open bpf userfaultfd
    ((41, 319, 278, 276), (198, 279, 75, 77)),  # socket memfd_create vmsplice tee
    ((42, 49, 50, 54), (203, 200, 201, 208)),  # connect bind listen setsockopt
    ((29, 30, 31), (194, 196, 195)),  # shmget shmat shmctl
    ((64, 65, 66, 220), (190, 193, 191, 192)),  # semget semop semctl semtimedop
    ((68, 69, 70, 71), (186, 189, 188, 187)),  # msgget msgsnd msgrcv msgctl
    ((240, 241), (180, 181)),  # mq_open mq_unlink
    # ptrace process_vm_readv process_vm_writev kcmp
    ((101, 310, 311, 312), (117, 270, 271, 272)),
    ((141, 251, 256, 279), (140, 30, 238, 239)),  # setpriority ioprio_set migrate_pages move_pages
    ((253, 294, 300), (26, 262)),  # inotify_init (x86_64 alone) inotify_init1 fanotify_init
    ((221, 187, 27), (223, 213, 232)),  # fadvise64 readahead mincore
    # io_setup io_destroy io_submit io_cancel io_getevents io_pgetevents
    ((206, 207, 209, 210, 208, 333), (0, 1, 2, 3, 4, 292)),
    # sysinfo ustat (x86_64 alone) statfs fstatfs
    ((99, 136, 137, 138), (179, 43, 44)),
)
_REFUSED_EVERYWHERE = (
    *(425, 426, 427),  # io_uring_setup io_uring_enter io_uring_register
    *(428, 429, 430, 431, 432, 433, 442),  # open_tree move_mount fs… fspick mount_setattr
    *(438, 440, 447, 448),  # pidfd_getfd process_madvise memfd_secret process_mrelease
    *(444, 445, 446),  # landlock_create_ruleset landlock_add_rule landlock_restrict_self
    *(451, 457, 458),  # cachestat statmount listmount
)
"""New calls have one number on every architecture."""
_FLOCK = (73, 32)
_PRETENDED = (
    ((90, 91, 268), (52, 53)),  # chmod (x86_64 alone) fchmod fchmodat
    # chown fchown lchown (of these aarch64 has fchown) fchownat
    ((92, 93, 94, 260), (55, 54)),
    # setxattr lset… fset… removexattr lremove… fremove…
    ((188, 189, 190, 197, 198, 199), (5, 6, 7, 14, 15, 16)),
    ((132, 235, 261, 280), (88,)),  # utime utimes futimesat (x86_64 alone) utimensat
    ((87, 263), (35,)),  # unlink (x86_64 alone) unlinkat
)
_PRETENDED_EVERYWHERE = (452, 463, 466)
"""fchmodat2 setxattrat removexattrat."""
_OPENAT2 = 437


@dataclass(frozen=True)
class Guard:
    """A call that is judged by one of its arguments.

    Attributes:
        numbers: the call's number by architecture, None where there is no such call.
        argument: which one, from 0.
        mask: the bits of it that count.
        answers: errors by the value of these bits; 0 pretends that the call was made.
        otherwise: the error for every other value, None where the call is allowed.
    """

    numbers: tuple[int | None, ...]
    argument: int
    mask: int
    answers: Mapping[int, int | None]
    otherwise: int | None = None


def _of_itself_alone(*numbers: int) -> Guard:
    """Guard a call whose first argument is a process; 0 is the caller."""
    return Guard(numbers, 0, _WHOLE, {0: None}, errno.EPERM)


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
    Guard((9, 222), 3, _SHARED_ANONYMOUS, {_SHARED_ANONYMOUS: errno.EPERM}),
    # fcntl
    Guard(
        (72, 25),
        1,
        _WHOLE,
        dict.fromkeys((_SET_LEASE, _NOTIFY, _SET_PIPE_SIZE), errno.EPERM)
        | dict.fromkeys(_SET_LOCKS, _PRETEND),
    ),
    # madvise: pages that leave the cache.
    Guard((28, 233), 2, _WHOLE, dict.fromkeys(_EVICT, errno.EPERM)),
    # preadv2: its flags ask for what is cached alone.
    Guard((327, 286), 5, _WHOLE, {0: None}, errno.EPERM),
    # A datagram finds its way to any path: socketpair.
    Guard((53, 199), 1, _NOT_A_STREAM, {0: None}, errno.EPERM),
)
_GUARDS_ON_A_SHARED_DISK = (
    # Files without a name, which no one can count: open and openat.
    Guard((2, None), 1, _NAMELESS, {_NAMELESS: errno.EPERM}),
    Guard((257, 56), 2, _NAMELESS, {_NAMELESS: errno.EPERM}),
)


def program(machine: str | None = None, *, shared_disk: bool = False) -> bytes:
    """Return the filter for a machine's architecture.

    Args:
        machine: one of ``ARCHITECTURES``, by default this machine's.
        shared_disk: whether student code works on the grader's own disk. Landlock does not
            guard modes, owners and times of files there, so calls that change them do nothing,
            and say that all is well; no file loses its name, or is without one, so that all
            can be counted.

    Raises:
        ValueError: we do not know the machine's numbers.
    """
    which = ARCHITECTURES.index(machine or platform.machine())
    return b"".join(
        [
            _line(_LOAD, _ARCHITECTURE),
            _line(_EQUAL, _AUDIT[which], if_true=1),
            _line(_RETURN, _KILL),
            _line(_LOAD, _NUMBER),
            *_answer_if(_AT_LEAST, _X32_BIT, errno.ENOSYS),
            *_answers(which, shared_disk),
            *_guards(which, shared_disk),
            _line(_EQUAL, _CLONE[which], if_false=3),
            _line(_LOAD, _FIRST_ARGUMENT),
            *_answer_if(_ANY_BIT, _CLONE_NAMESPACES, errno.EPERM),
            _line(_RETURN, _ALLOW),
        ]
    )


def _answers(which: int, shared_disk: bool) -> Iterator[bytes]:
    """Yield what answers calls in place of making them."""
    refused = [number for row in _REFUSED for number in row[which]]
    answers = {_CLONE3: errno.ENOSYS}
    answers |= dict.fromkeys((*refused, *_REFUSED_EVERYWHERE), errno.EPERM)
    answers[_FLOCK[which]] = _PRETEND
    if shared_disk:
        pretended = [number for row in _PRETENDED for number in row[which]]
        answers |= dict.fromkeys((*pretended, *_PRETENDED_EVERYWHERE), _PRETEND)
        answers[_OPENAT2] = errno.ENOSYS  # its flags, too, are behind a pointer
    for number, answer in answers.items():
        yield from _answer_if(_EQUAL, number, answer)


def _guards(which: int, shared_disk: bool) -> Iterator[bytes]:
    for guard in (*_GUARDS, *(_GUARDS_ON_A_SHARED_DISK if shared_disk else ())):
        number = guard.numbers[which]
        if number is None:
            continue
        lines = [
            _line(_LOAD, _FIRST_ARGUMENT + _ARGUMENT_BYTES * guard.argument),
            _line(_AND, guard.mask),
            *(line for pair in guard.answers.items() for line in _answer_if(_EQUAL, *pair)),
            _line(_RETURN, _action(guard.otherwise)),
        ]
        yield _line(_EQUAL, number, if_false=len(lines))
        yield from lines


def _answer_if(test: int, value: int, error: int | None) -> list[bytes]:
    return [_line(test, value, if_false=1), _line(_RETURN, _action(error))]


def _action(error: int | None) -> int:
    return _ALLOW if error is None else _REFUSE | error


def _line(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    """Write one instruction; jumps count the instructions to skip."""
    return struct.pack("<HBBI", code, if_true, if_false, value)
