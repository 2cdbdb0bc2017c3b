"""Work in a child process that the kernel ends when it computes for too long.

No signal handler and no other thread of Python gets its turn while a long computation in C
goes on. So what could begin one runs in a child, which the kernel ends by a timer of its own,
and what it had told by then is kept.
"""

from __future__ import annotations

import contextlib
import os
import signal
import traceback
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NoReturn, TypeVar

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

T = TypeVar("T")
Run = Callable[[Callable[[], Iterator[T]]], Iterator[T]]
"""Does work, and yields what it yields."""

_is_guarded = False


class Overrun(Exception):
    """The work took more processor time than it had asked for."""


def plain(work: Callable[[], Iterator[T]]) -> Iterator[T]:
    """Do work here, where nothing ends it: for a student's own check."""
    return work()


def guarded(work: Callable[[], Iterator[T]]) -> Iterator[T]:
    """Do work in a child process, and yield what it yields.

    Raises:
        Overrun: the kernel ended the child; what it had yielded came before.
        Exception: what the work raised.
    """
    from multiprocessing.connection import Pipe  # a browser has none

    reader, writer = Pipe(duplex=False)
    alive, held = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(held)
        _work(work, writer, alive)
    writer.close()
    os.close(alive)
    is_cut_short = True
    try:
        with contextlib.suppress(EOFError):
            while True:
                kind, value = reader.recv()
                if kind == "raised":
                    raise value
                yield value
        is_cut_short = False
    finally:
        reader.close()
        os.close(held)
        if is_cut_short:
            os.kill(child, signal.SIGKILL)
        code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    if code == -signal.SIGPROF:
        raise Overrun
    if code < 0:  # who waits for this process learns of it
        os.kill(os.getpid(), -code)
    if code != 0:
        os._exit(code)


def _work(work: Callable[[], Iterator[T]], writer: Connection, alive: int) -> NoReturn:
    """Be the child, which prints nothing: LAPACK complains on the descriptors of its process."""
    global _is_guarded
    _is_guarded = True
    said = os.fdopen(os.dup(2), "w")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    end_with(alive)
    try:
        for value in work():
            writer.send(("yielded", value))
    except Exception as error:
        traceback.print_tb(error.__traceback__, file=said)  # its words may hold hidden inputs
        said.flush()
        writer.send(("raised", error))
    os._exit(0)


@contextlib.contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Have the kernel end this process, if it is a guarded one, after so much processor time."""
    if not _is_guarded:
        yield
        return
    signal.setitimer(signal.ITIMER_PROF, max(seconds, 0.001))
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def end_with(sentinel: int) -> None:
    """Have the kernel end this process when the other end of a pipe is closed, however that came.

    No thread watches it: a long computation would keep that from running.
    """
    import fcntl
    import select

    signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(sentinel, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(sentinel, fcntl.F_SETFL, fcntl.fcntl(sentinel, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([sentinel], [], [], 0)[0]:
        os.kill(os.getpid(), signal.SIGKILL)
