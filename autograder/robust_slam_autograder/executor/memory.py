"""What a trusted process may hold: answers that a test gathers, and results of its functions.

Student code chooses how large they are. With a limit of the kernel's, too much of them is
a MemoryError inside the test, which costs the student that case. A part of the limit is
kept back from tests, so that the grader itself still has memory to go on.
"""

import contextlib
import sys
from collections.abc import Iterator
from pathlib import Path

if sys.platform != "emscripten":  # a browser has no limits to set
    import resource

HELD_BYTES = 1024**3
"""What the tests of one submission may hold beyond what the process held at its start."""
KEPT_BACK_BYTES = 128 * 1024**2
"""Within this much more the grader works while tests have nothing left."""


def bound() -> None:
    """Limit, for good, what this process may hold beyond what it holds now."""
    if (held := _private_bytes()) is not None:
        most = held + HELD_BYTES + KEPT_BACK_BYTES
        resource.setrlimit(resource.RLIMIT_DATA, (most, most))


@contextlib.contextmanager
def for_tests() -> Iterator[None]:
    """Keep the part that is kept back from what runs within this context.

    Without ``bound``, as in a student's own check, they have as much beyond what is held now.
    """
    held = _private_bytes()
    if held is None:
        yield
        return
    before, most = resource.getrlimit(resource.RLIMIT_DATA)
    here = held + HELD_BYTES if most == resource.RLIM_INFINITY else most - KEPT_BACK_BYTES
    resource.setrlimit(resource.RLIMIT_DATA, (here, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (before, most))


def _private_bytes() -> int | None:
    """Read the bytes that count for RLIMIT_DATA; None where the kernel does not tell them."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return None
    (line,) = [line for line in lines if line.startswith("VmData:")]
    return int(line.split()[1]) * 1024
