"""Work in a child process that the kernel ends when it computes for too long.

No signal handler and no other thread of Python gets its turn while a long computation in C
goes on. So what could begin one runs in a child, which the kernel ends by a timer of its own,
and what it had told by then is kept.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import signal
import traceback
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, NoReturn, TypeVar

if TYPE_CHECKING:  # a browser has none
    from multiprocessing.connection import Connection
    from multiprocessing.context import ForkContext, ForkServerContext
    from multiprocessing.process import BaseProcess

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
    reader, child = started(multiprocessing.get_context("fork"), _work, work)
    try:
        with contextlib.suppress(EOFError):
            while True:
                kind, value = reader.recv()
                if kind == "raised":
                    raise value
                yield value
        child.join()
    finally:
        code = ended(reader, child)
    if code == -signal.SIGPROF:
        raise Overrun
    if code < 0:  # who waits for this process learns of it
        os.kill(os.getpid(), -code)
    if code != 0:
        os._exit(code)


def started(
    context: ForkContext | ForkServerContext, target: Callable[..., object], *args: object
) -> tuple[Connection, BaseProcess]:
    """Start a child process, in which ``target`` is called with a pipe to us and ``args``."""
    # Only to a daemon are children denied, such as a trusted process, or a worker of Dask's nanny.
    multiprocessing.current_process().daemon = False
    reader, writer = context.Pipe(duplex=False)
    child = context.Process(target=target, args=(writer, *args), daemon=True)
    child.start()
    writer.close()
    return reader, child


def ended(reader: Connection, child: BaseProcess) -> int:
    """End a child process if it goes on, and return its exit status."""
    child.kill()
    child.join()
    code = child.exitcode or 0
    child.close()
    reader.close()
    return code


def _work(writer: Connection, work: Callable[[], Iterator[T]]) -> NoReturn:
    """Be the child, which prints nothing: LAPACK complains on the descriptors of its process."""
    global _is_guarded
    _is_guarded = True
    said = os.fdopen(os.dup(2), "w")
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    end_with_parent()
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


def end_with_parent() -> None:
    """Have the kernel end this ``started`` process when its parent is gone, however that came.

    No thread watches it: a long computation would keep that from running.
    """
    import fcntl
    import select

    parent = multiprocessing.parent_process()
    assert parent is not None
    sentinel = parent.sentinel
    signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(sentinel, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(sentinel, fcntl.F_SETFL, fcntl.fcntl(sentinel, fcntl.F_GETFL) | os.O_ASYNC)
    if select.select([sentinel], [], [], 0)[0]:
        os.kill(os.getpid(), signal.SIGKILL)
