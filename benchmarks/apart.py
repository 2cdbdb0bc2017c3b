"""A task in a process of its own, with a limit on its CPU time.

A limit in the process that works would not do: a solver in compiled code hears of nothing
until it is done. A process is ended from outside, and takes no other with it.
"""

from __future__ import annotations

import multiprocessing
import resource
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import TypeVar

T = TypeVar("T")
_FORK = multiprocessing.get_context("fork")
_GRACE = 5


class Ended(Exception):
    """The process was ended by a signal: SIGXCPU where its time was over."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.over = number == signal.SIGXCPU


def apart(task: Callable[[], T], limit: int) -> T:
    """Return what ``task`` returns, run in a process that may take ``limit`` s of CPU time.

    Raises:
        Ended: a signal ended the process.
        RuntimeError: the task raised an error, which is printed.
    """
    receiver, sender = _FORK.Pipe(duplex=False)
    process = _FORK.Process(target=_answer, args=(sender, task, limit))
    process.start()
    sender.close()
    try:
        answer: T = receiver.recv()
        return answer
    except EOFError:
        process.join()
        if process.exitcode is not None and process.exitcode < 0:
            raise Ended(-process.exitcode) from None
        raise RuntimeError("see the error above") from None
    finally:
        process.join()


def _answer(sender: Connection, task: Callable[[], T], limit: int) -> None:
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + _GRACE))
    sender.send(task())
