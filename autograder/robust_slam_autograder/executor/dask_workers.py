"""Tasks on the workers of a Dask cluster: each on a worker that is fit for it, its answer once.

Which worker does what is decided here, and Dask carries it. A worker has one task at a time, so
that one that is unfit or gone is known by its name, and so is the task that ended it.
"""

from __future__ import annotations

import contextlib
import itertools
import logging
import queue
import re
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Generic, TypeVar
from urllib.parse import urlsplit

from robust_slam_autograder.errors import GraderFailure, WrongUse
from robust_slam_autograder.executor.trusted import Broken

if TYPE_CHECKING:
    from distributed import Client, Future

MOST_DEATHS = 3
"""A task whose worker ended so often is given up."""
CONNECT_SECONDS = 30.0
LOOK_SECONDS = 1.0
"""How often we look which workers there are."""
PATIENCE_SECONDS = 60.0
"""How long we wait for a worker that is fit, where there is none."""
FETCH_SECONDS = 60.0
"""How long an answer may be on its way."""
MOST_SAID = 300
LARGEST_TASK = "1 GiB"
"""Dask warns of larger ones; a notebook may have 20 MiB."""

_ADDRESS = re.compile(r"(tcp|tls)://(\[[0-9a-fA-F:]+\]|[^][/:@\s]+):[0-9]{1,5}")

T = TypeVar("T")
Call = tuple[Any, ...]
"""A function that workers can import, and its arguments."""


@dataclass(frozen=True)
class Unfit:
    """A worker's answer where it may not do such tasks."""

    why: str


@dataclass(frozen=True)
class _Item(Generic[T]):
    """A task, where it is, and how many workers have ended over it."""

    task: T
    worker: str = ""
    deaths: int = 0


@dataclass
class _Flow(Generic[T]):
    """The tasks of one run: those to come, those to be sent again, those that are out."""

    waiting: Iterator[T]
    again: deque[_Item[T]] = field(default_factory=deque)
    sent: dict[Future[Any], _Item[T]] = field(default_factory=dict)
    done: queue.SimpleQueue[Future[Any]] = field(default_factory=queue.SimpleQueue)

    def is_left(self) -> bool:
        """Tell whether there is a task to send; then it is the first of ``again``."""
        if not self.again:
            self.again.extend(_Item(task) for task in itertools.islice(self.waiting, 1))
        return bool(self.again)

    def died(self, item: _Item[T]) -> Iterator[tuple[T, Broken]]:
        """Have a task sent again, or give it up."""
        deaths = item.deaths + 1
        if deaths < MOST_DEATHS:
            self.again.append(_Item(item.task, deaths=deaths))
        else:
            yield item.task, Broken(f"lost its worker {deaths} times")


@contextlib.contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """Connect with a scheduler; certificates for ``tls://`` come from Dask's own configuration.

    Raises:
        WrongUse: Dask is not installed, or no scheduler answers there.
    """
    try:
        import dask
        from distributed import Client, Security
    except ImportError as error:
        raise WrongUse("--scheduler needs Dask: pip install distributed.") from error
    # Before Dask sees it: its client takes long to give up a wrong address.
    security = Security()
    if not _ADDRESS.fullmatch(address):
        raise WrongUse(
            f"{address} is not a scheduler's address: it needs tcp:// or tls://HOST:PORT."
        )
    if address.startswith("tls:") and not security.get_connection_args("client")["ssl_context"]:
        fix = "set distributed.comm.tls.ca-file and .client.cert and .key in Dask's configuration"
        raise WrongUse(f"{address} needs certificates: {fix}.")
    logging.getLogger("distributed.client").setLevel(logging.CRITICAL)  # we say it in a sentence
    dask.config.set({"distributed.admin.large-graph-warning-threshold": LARGEST_TASK})
    try:
        client = Client(address, timeout=CONNECT_SECONDS, security=security, set_as_default=False)
    except OSError as error:
        fix = "start one there with `dask scheduler`, or correct the address"
        raise WrongUse(f"No Dask scheduler answers at {address} ({error}): {fix}.") from error
    with client:
        yield Cluster(client, address)


class Cluster:
    """The workers of a scheduler; whom we found unfit stays so while it is there."""

    def __init__(self, client: Client, address: str) -> None:
        self._client = client
        self._address = address
        self._present: set[str] = set()
        self._unfit: dict[str, str] = {}
        self._next_look = 0.0
        self._last_fit = time.monotonic()

    def run_each(
        self, tasks: Iterable[T], call: Callable[[T], Call], *, alone: bool = False
    ) -> Iterator[tuple[T, Any]]:
        """Do tasks, and give the answers as they come.

        Args:
            tasks: taken one by one, as workers get free.
            call: what a worker is to do for a task: a function, which may answer ``Unfit``,
                and its arguments.
            alone: whether a machine gets one task at a time.

        Returns:
            each task once, with what the function gave, or ``Broken``.

        Raises:
            GraderFailure: the scheduler is gone, or there is no fit worker for a minute.
        """
        flow = _Flow(iter(tasks))
        try:
            while flow.sent or flow.is_left():
                self._look()
                yield from self._give_up_on_the_gone(flow)
                self._send(flow, call, alone)
                yield from self._collect(flow)
        finally:
            if flow.sent:
                with contextlib.suppress(Exception):  # the scheduler may be gone
                    self._client.cancel(list(flow.sent), force=True)

    def _look(self) -> None:
        now = time.monotonic()
        if now < self._next_look:
            return
        self._next_look = now + LOOK_SECONDS
        try:
            threads = self._client.nthreads()
        except OSError as error:
            raise self._gone() from error
        self._present = set(threads)
        self._unfit = {worker: why for worker, why in self._unfit.items() if worker in threads}
        for worker, count in threads.items():
            if count != 1:
                self._refuse(worker, f"it has {count} threads: start it with --nthreads 1")
        if self._fit():
            self._last_fit = now
        elif now - self._last_fit > PATIENCE_SECONDS:
            raise GraderFailure(self._none_is_fit())

    def _fit(self) -> list[str]:
        return sorted(self._present - self._unfit.keys())

    def _refuse(self, worker: str, why: str) -> None:
        if worker not in self._unfit:
            self._unfit[worker] = why
            print(f"The worker {worker} is left out: {why}.", file=sys.stderr)

    def _give_up_on_the_gone(self, flow: _Flow[T]) -> Iterator[tuple[T, Broken]]:
        gone = [future for future, item in flow.sent.items() if item.worker not in self._present]
        if gone:
            self._client.cancel(gone, force=True)
        for future in gone:
            yield from flow.died(flow.sent.pop(future))

    def _send(self, flow: _Flow[T], call: Callable[[T], Call], alone: bool) -> None:
        """Give each worker a task that has none; where it is to be alone, each machine."""
        busy = {_place(item.worker, alone) for item in flow.sent.values()}
        for worker in self._fit():
            place = _place(worker, alone)
            if place in busy or not flow.is_left():
                continue
            busy.add(place)
            item = flow.again.popleft()
            function, *arguments = call(item.task)
            future = self._client.submit(function, *arguments, workers=[worker], pure=False)
            flow.sent[future] = replace(item, worker=worker)
            future.add_done_callback(flow.done.put)

    def _collect(self, flow: _Flow[T]) -> Iterator[tuple[T, Any]]:
        """Wait for the next answer; of a task that was given up nothing counts any more."""
        try:
            future = flow.done.get(timeout=LOOK_SECONDS)
        except queue.Empty:
            return
        item = flow.sent.pop(future, None)
        if item is None:
            return
        if future.status in ("cancelled", "lost"):
            raise self._gone()
        try:
            answer = future.result(timeout=FETCH_SECONDS)
        except Exception as error:
            if not _is_death(error):
                said = " ".join(str(error).split())[:MOST_SAID]
                self._refuse(item.worker, f"it failed ({type(error).__name__}: {said})")
            yield from flow.died(item)
            return
        if isinstance(answer, Unfit):
            self._refuse(item.worker, answer.why)
            flow.again.append(item)
        else:
            yield item.task, answer

    def _gone(self) -> GraderFailure:
        fix = "start it again, with its workers; the same command goes on from here"
        return GraderFailure(f"The Dask scheduler at {self._address} is gone: {fix}.")

    def _none_is_fit(self) -> str:
        found = "; ".join(f"{worker}: {why}" for worker, why in sorted(self._unfit.items()))
        command = f"`dask worker {self._address} --nthreads 1`"
        return (
            f"No worker of {self._address} can be used ({found or 'there is none'}): "
            f"start some with {command}; the same command goes on from here."
        )


def _place(worker: str, alone: bool) -> str:
    """Say what may hold so many tasks: a worker, or all workers of a machine."""
    return urlsplit(worker).hostname or worker if alone else worker


def _is_death(error: Exception) -> bool:
    """Tell whether it says that a worker ended, and nothing of whether it was fit."""
    from distributed import KilledWorker

    return isinstance(error, (KilledWorker, TimeoutError))
