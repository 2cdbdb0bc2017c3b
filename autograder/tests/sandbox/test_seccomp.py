"""The filter's decisions, as the kernel's own rules for classic BPF give them."""

import errno
import struct

import pytest
from robust_slam_autograder.sandbox import seccomp

ALLOW = 0x7FFF0000
CALLS = {
    "x86_64": {"read": 0, "clone": 56, "unshare": 272, "mount": 165, "keyctl": 250}
    | {"ptrace": 101, "fadvise64": 221, "readahead": 187, "mincore": 27},
    "aarch64": {"read": 63, "clone": 220, "unshare": 97, "mount": 40, "keyctl": 219}
    | {"ptrace": 117, "fadvise64": 223, "readahead": 213, "mincore": 232},
}
AUDIT = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}


def decide(machine, number, first=0, audit=None, *, rest=(0, 0, 0), shared_disk=False) -> int:
    """Run the program on one call, as a machine for classic BPF does."""
    program = seccomp.program(machine, shared_disk=shared_disk)
    architecture = AUDIT[machine] if audit is None else audit
    call = struct.pack("<IIQQQQQ", number, architecture, 0, first, *rest)
    lines = list(struct.iter_unpack("<HBBI", program))
    at = value = 0
    tests = {0x15: lambda k: value == k, 0x35: lambda k: value >= k, 0x45: lambda k: value & k}
    while True:
        code, if_true, if_false, k = lines[at]
        at += 1
        if code == 0x06:
            return int(k)
        if code == 0x20:
            (value,) = struct.unpack_from("<I", call, k)
        elif code == 0x54:
            value &= k
        else:
            at += if_true if tests[code](k) else if_false


def refused(error: int) -> int:
    return 0x00050000 | error


@pytest.mark.parametrize("machine", CALLS)
def test_what_acts_on_others_is_refused(machine):
    """And what tells of the machine's mounts and which pages are in its cache, or changes that."""
    calls = CALLS[machine]
    for name in set(calls) - {"read", "clone"}:
        assert decide(machine, calls[name]) == refused(errno.EPERM), name
    assert decide(machine, calls["clone"], first=0x10000000 | 17) == refused(errno.EPERM)
    assert {decide(machine, mounts) for mounts in (457, 458)} == {refused(errno.EPERM)}
    assert decide(machine, 435) == refused(errno.ENOSYS)


@pytest.mark.parametrize("machine", CALLS)
def test_reading_forks_and_threads_are_allowed(machine):
    calls = CALLS[machine]
    assert decide(machine, calls["read"]) == ALLOW
    assert decide(machine, calls["clone"], first=17) == ALLOW
    assert decide(machine, calls["clone"], first=0x3D0F00) == ALLOW


def test_another_architecture_is_no_way_round():
    assert decide("x86_64", 0, audit=0x40000003) == 0x80000000
    assert decide("x86_64", 0x40000000 | 272) == refused(errno.ENOSYS)


def test_an_unknown_machine_has_no_filter():
    with pytest.raises(ValueError):
        seccomp.program("pdp11")


def test_calls_are_judged_by_their_arguments():
    no = refused(errno.EPERM)
    mmap, fcntl, socketpair, prlimit = 9, 72, 53, 302
    assert decide("x86_64", mmap, rest=(0, 3, 0x21)) == no  # shared and anonymous
    assert decide("x86_64", mmap, rest=(0, 3, 0x22)) == ALLOW
    assert decide("x86_64", mmap, rest=(0, 3, 0x01)) == ALLOW
    assert decide("x86_64", fcntl, 3, rest=(1024, 1, 0)) == no  # a lease
    assert decide("x86_64", fcntl, 3, rest=(1, 0, 0)) == ALLOW
    assert decide("x86_64", socketpair, 1, rest=(2 | 0x80000, 0, 0)) == no  # datagrams
    assert decide("x86_64", socketpair, 1, rest=(1 | 0x80000, 0, 0)) == ALLOW
    assert decide("x86_64", prlimit, first=1) == no
    assert decide("x86_64", prlimit, first=0) == ALLOW
    madvise = 28
    for advice in (20, 21):  # out of the machine's cache
        assert decide("x86_64", madvise, rest=(0, advice, 0)) == no
    assert decide("x86_64", madvise, rest=(0, 4, 0)) == ALLOW


def test_on_a_shared_disk_modes_stay_and_files_keep_their_names():
    chmod, unlink, openat, openat2 = 90, 87, 257, 437
    for number in (chmod, unlink):
        assert decide("x86_64", number) == ALLOW
        assert decide("x86_64", number, shared_disk=True) == refused(0)
    no = refused(errno.EPERM)
    assert decide("x86_64", openat, rest=(0, 0x410002, 0), shared_disk=True) == no
    assert decide("x86_64", openat, rest=(0, 0x2, 0), shared_disk=True) == ALLOW
    assert decide("x86_64", openat2, shared_disk=True) == refused(errno.ENOSYS)
