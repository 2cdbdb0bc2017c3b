"""Landlock: the kernel's own list of what a process may still open (Linux 5.13 and newer).

The list grows with the kernel: from version 4 of the interface on it covers TCP,
from version 6 on signals to processes outside. What is not on it (sockets of other
kinds, modes and owners of files) the system-call filter has to refuse. Numbers are
those of include/uapi/linux/landlock.h.
"""

import os
import struct
from collections.abc import Iterable
from pathlib import Path

from robust_slam_autograder.sandbox import system

_CREATE, _ADD_RULE, _RESTRICT = 444, 445, 446
_ASK_VERSION, _PATH_BENEATH = 1, 1
SIGNALS_VERSION = 6
"""From this version on a process cannot signal those outside its domain."""

_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_FOLDER = 1, 2, 4, 8
_TRUNCATE, _MAKE_FILE = 1 << 14, 1 << 8
_ON_FILES = _EXECUTE | _WRITE_FILE | _READ_FILE | _TRUNCATE
_RIGHTS_BY_VERSION = {1: 13, 2: 14, 3: 15, 5: 16}
"""How many rights on files each version knows, from the lowest bit up."""
_NET_VERSION, _NET_ALL = 4, 3
_SCOPE_ALL = 3

READ = _EXECUTE | _READ_FILE | _READ_FOLDER
LIST = _READ_FOLDER
USE = _READ_FILE | _WRITE_FILE
ALL = (1 << 16) - 1
FLAT = READ | _WRITE_FILE | _TRUNCATE | _MAKE_FILE
"""A folder of files, in which no other folder can be made and nothing loses its name."""


def version() -> int:
    """Return the kernel's version of Landlock; 0 where it has none."""
    try:
        return system.call(_CREATE, None, 0, _ASK_VERSION)
    except OSError:
        return 0


def rules(allowed: Iterable[tuple[Path, int]]) -> int:
    """Make a list of what may be opened.

    Args:
        allowed: paths with the rights on them and all beneath: ``READ``, ``LIST``,
            ``USE`` (a device), ``FLAT`` or ``ALL``. A path that does not exist is passed over.

    Returns:
        a descriptor for ``enter``.

    Raises:
        OSError: the kernel has no Landlock.
    """
    known = version()
    bits = max(count for first, count in _RIGHTS_BY_VERSION.items() if first <= max(known, 1))
    rights = (1 << bits) - 1
    attributes = struct.pack("=Q", rights)
    if known >= _NET_VERSION:
        attributes += struct.pack("=Q", _NET_ALL)
    if known >= SIGNALS_VERSION:
        attributes += struct.pack("=Q", _SCOPE_ALL)
    ruleset = system.call(_CREATE, attributes, len(attributes), 0)
    for path, wanted in allowed:
        _allow(ruleset, path, wanted & rights)
    return ruleset


def _allow(ruleset: int, path: Path, rights: int) -> None:
    try:
        descriptor = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        if not path.is_dir():
            rights &= _ON_FILES
        rule = struct.pack("=Qi", rights, descriptor)
        system.call(_ADD_RULE, ruleset, _PATH_BENEATH, rule, 0)
    finally:
        os.close(descriptor)


def enter(ruleset: int) -> None:
    """Hold this process, and all that it starts, to a list for good."""
    system.call(_RESTRICT, ruleset, 0)
