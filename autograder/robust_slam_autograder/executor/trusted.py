"""Trusted processes: each task in a fresh one, forked from a server that has imported already.

A batch that is killed takes them with it: none goes on by itself.
"""

import contextlib
import multiprocessing
import signal
import sys
import tempfile
import time
import types
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing import util
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Generic, TypeVar

from robust_slam_autograder.executor import guarded, memory, trusted_server

T = TypeVar("T")
R = TypeVar("R")


@dataclass(frozen=True)
class Broken:
    """What is known of a process that gave no answer; ``how`` completes "the grader …"."""

    how: str


@dataclass(frozen=True)
class _Worker(Generic[T]):
    task: T
    process: BaseProcess
    end: float
    """When it must be done (``time.monotonic``)."""


def run_each(
    tasks: Iterable[T],
    work: Callable[[T], R],
    *,
    at_once: int,
    seconds: Callable[[T], float],
    preload: Sequence[str] = (),
) -> Iterator[tuple[T, R | Broken]]:
    """Do tasks, each in a process of its own, and give the answers as they come.

    Args:
        tasks: taken one by one, as processes get free.
        work: what to do; a function that can be pickled.
        at_once: how many processes.
        seconds: what a task may take before its process is ended.
        preload: modules that ``work`` will want. The first call decides.
    """
    waiting = iter(tasks)
    running: dict[Connection, _Worker[T]] = {}
    try:
        while True:
            while len(running) < at_once and (task := next(waiting, None)) is not None:
                receiver, process = _start(work, task, preload)
                running[receiver] = _Worker(task, process, time.monotonic() + seconds(task))
            if not running:
                return
            yield from _collect(running)
    finally:
        for receiver, worker in running.items():
            guarded.ended(receiver, worker.process)


def _start(
    work: Callable[[T], R], task: T, preload: Sequence[str]
) -> tuple[Connection, BaseProcess]:
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([trusted_server.__name__])
    folder = util.get_temp_dir()
    with _without_main(), trusted_server.told(preload, folder):
        return guarded.started(context, _be, folder, work, task)


@contextlib.contextmanager
def _without_main() -> Iterator[None]:
    """Keep a new process from running the main script, whatever that is, once more."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = types.ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


def _collect(running: dict[Connection, _Worker[T]]) -> Iterator[tuple[T, R | Broken]]:
    """Wait for the next process, or processes, to be done or to be late."""
    first = min(worker.end for worker in running.values())
    ready = wait(list(running), timeout=max(0.0, first - time.monotonic()))
    now = time.monotonic()
    for receiver, worker in list(running.items()):
        if receiver not in ready and worker.end > now:
            continue
        del running[receiver]
        answer: R | Broken = Broken("took longer than its limits")
        if receiver in ready:
            answer = _receive(receiver, worker.process)
        guarded.ended(receiver, worker.process)
        yield worker.task, answer


def _receive(receiver: Connection, process: BaseProcess) -> R | Broken:
    try:
        answer: R = receiver.recv()
    except (EOFError, OSError):
        process.join()
        return Broken(f"ended with exit status {process.exitcode}")
    return answer


def _be(sender: Connection, folder: str, work: Callable[[T], R], task: T) -> None:
    """Be the trusted process, which the kernel ends when the batch is gone, however that came."""
    guarded.end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the batch ends this process itself
    tempfile.tempdir = folder  # so that what a killed process leaves goes with the batch's own
    memory.bound()
    sender.send(work(task))
    sender.close()
