"""Calls that go both ways between the grader and student code, over a pair of pipes.

Both sides use the same class: a call waits for its answer and serves the
calls that come back meanwhile (a student's solver that calls the weight function
it was handed). The trusted side adds deadlines; it never trusts what it reads.
"""

from __future__ import annotations

import builtins
import contextlib
import math
import os
import select
import struct
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import Any

from robust_slam_autograder.protocol import wire
from robust_slam_autograder.protocol.wire import Handle, WireError

MAX_CALLABLES = 10_000
MAX_NESTED_CALLS = 40
MAX_TEXT = 1_000
MAX_LINE = 1_000_000
_PAGE = 65_536
_LENGTH = struct.Struct(">I")
_ENDS_OF_LOOPS = ("StopIteration", "StopAsyncIteration")

Check = Callable[[Callable[..., Any], list[Any], dict[str, Any]], None]


class Fault(BaseException):
    """The conversation is over. Not an Exception: code in between must not swallow it."""


class ChannelClosed(Fault):
    """The other side has gone, or writes what is no message."""


class DeadlineExceeded(Fault):
    """No answer came in time."""


class RaisedThere(Exception):
    """The called function raised: carries the names of its exception's classes, and where."""

    def __init__(self, error: Mapping[str, Any]) -> None:
        message, line = error.get("message"), error.get("line")
        self.types = _texts(error.get("types"))
        self.message = _text(message)
        self.functions = _texts(error.get("functions"))
        self.line = line if type(line) is int and 0 < line <= MAX_LINE else None
        super().__init__(self.message)


def _text(told: object) -> str:
    # Only texts: to print 30 million numbers would take minutes.
    return told[:MAX_TEXT] if isinstance(told, str) else f"({type(told).__name__})"


def _texts(told: object) -> tuple[str, ...]:
    return tuple(map(_text, told[:20])) if isinstance(told, list) else ()


def alike(raised: RaisedThere, *own: type[Exception]) -> Exception:
    """Make an exception that is caught by the builtin class that was raised on the other side.

    Only classes below Exception count, so that nothing raised there ends this side; and none
    that ends a loop over ``map`` or ``zip`` as if it had seen all. It has ``own`` ones besides.
    """
    known = (getattr(builtins, name, None) for name in raised.types if name not in _ENDS_OF_LOOPS)
    bases = [found for found in known if isinstance(found, type) and issubclass(found, Exception)]
    name = raised.types[0] if raised.types and raised.types[0].isidentifier() else "Exception"
    for base in bases:
        # Some builtins want other arguments than a message: then the next class has to do.
        with contextlib.suppress(TypeError):
            error: Exception = type(name, (*own, base), {})(raised.message)
            return error
    last: Exception = type(name, own or (Exception,), {})(raised.message)
    return last


class Remote:
    """A callable of the other side."""

    def __init__(self, channel: Conversation, handle: Handle) -> None:
        self._channel = channel
        self._handle = handle

    def __call__(self, *args: object, **kwargs: object) -> Any:  # noqa: ANN401
        """Call it across the pipe; arguments and result are copies."""
        try:
            return self._channel.invoke(self._handle, args, kwargs)
        except RaisedThere as raised:
            error = alike(raised)
        raise error


class Conversation(ABC):
    """Calls between two sides; how the messages travel is a subclass's business."""

    def __init__(
        self,
        *,
        named: Mapping[str, Callable[..., Any]] | None = None,
        describe: Callable[[BaseException], dict[str, Any]] | None = None,
        tells: type[BaseException] = Exception,
        check: Check | None = None,
        widen: bool = False,
    ) -> None:
        """Make one side of it.

        Args:
            named: functions that the other side may call by name.
            describe: turns an exception into what is told of it.
            tells: exceptions of our functions that the other side is told of.
            check: raises where the other side may not call one of our functions so.
            widen: as in ``wire.decode``.
        """
        self.patience: Callable[[], float] | None = None
        """Says how many seconds to wait before it is asked again; at the deadline none."""
        self.invoke: Callable[[Handle, tuple[Any, ...], Mapping[str, Any]], Any] = self.call
        """How callables of the other side are called; who adds a deadline puts it here."""
        self._asked: Callable[[], float] | None = None
        self._ask_again = 0.0
        self._named = named or {}
        self._describe = describe or describe_error
        self._tells = tells
        self._check = check
        self._widen = widen
        self._exported: list[Callable[..., Any]] = []
        self._keys: dict[int, int] = {}
        self._lock = threading.RLock()  # student code may call back from a thread of its own
        self._calls = 0
        self._depth = 0

    @abstractmethod
    def _send(self, payload: bytes) -> None:
        """Send a message."""

    @abstractmethod
    def _arrive(self) -> bytes:
        """Wait for a message."""

    @abstractmethod
    def is_quiet(self) -> bool:
        """Tell whether no message has come in unasked."""

    def call(self, target: Handle, args: tuple[Any, ...], kwargs: Mapping[str, Any]) -> Any:  # noqa: ANN401
        """Call a function of the other side and wait for its answer.

        Raises:
            WireError: an argument cannot cross.
            RaisedThere: the function raised.
            DeadlineExceeded: ``patience`` has come to its end.
            ChannelClosed: the other side has gone or broke the protocol.
        """
        with self._lock:
            self._calls += 1
            number = self._calls
            function = _as_theirs(target)
            message = ["call", number, [function.owner, function.key], list(args), dict(kwargs)]
            self._send(wire.encode(message, self._export))
            return self._await_answer(number)

    def _await_answer(self, number: int) -> Any:  # noqa: ANN401
        while True:
            kind, its_number, *rest = self._receive()
            if kind == "call":
                self._answer(its_number, *rest)
            elif its_number != number:
                raise ChannelClosed("an answer to no question")
            elif kind == "return":
                return rest[0]
            else:
                raise RaisedThere(rest[0])

    def serve(self) -> None:
        """Answer calls until the other side closes its end.

        Raises:
            ChannelClosed: it did, or broke the protocol.
        """
        while True:
            kind, number, *rest = self._receive()
            if kind != "call":
                raise ChannelClosed("an answer to no question")
            self._answer(number, *rest)

    def _answer(self, number: int, target: list[Any], args: list[Any], kwargs: Any) -> None:  # noqa: ANN401
        self._depth += 1
        try:
            if self._depth > MAX_NESTED_CALLS:
                raise RecursionError("calls across the pipe are nested too deeply")
            function = self._own(target)
            if self._check is not None:
                self._check(function, args, kwargs)
            value = function(*args, **kwargs)
            reply = wire.encode(["return", number, value], self._export)
        except Fault:
            raise
        except self._tells as error:
            reply = wire.encode(["raise", number, self._describe(error)], self._export)
        finally:
            self._depth -= 1
        self._send(reply)

    def _own(self, target: list[Any]) -> Callable[..., Any]:
        """Find our callable that the other side means."""
        owner, key = target
        if owner == "name" and key in self._named:
            return self._named[key]
        if owner == "yours" and type(key) is int and 0 <= key < len(self._exported):
            return self._exported[key]
        raise WireError("a call of an unknown function")

    def _export(self, function: Callable[..., Any]) -> Handle:
        if isinstance(function, Remote):
            return _as_theirs(function._handle)
        key = self._keys.get(id(function))
        if key is None:
            if len(self._exported) >= MAX_CALLABLES:
                raise WireError(f"more than {MAX_CALLABLES} functions crossed")
            self._exported.append(function)  # which also keeps its id from being used again
            key = self._keys[id(function)] = len(self._exported) - 1
        return Handle("mine", key)

    def _import(self, handle: Handle) -> Callable[..., Any]:
        if handle.owner == "mine":
            return Remote(self, handle)
        return self._own([handle.owner, handle.key])

    def _receive(self) -> list[Any]:
        self._time_left()  # a flood of messages never lets the reader wait
        try:
            message = wire.decode(self._arrive(), self._import, widen=self._widen)
        except (WireError, MemoryError) as error:
            raise ChannelClosed(str(error)) from error
        if not _is_message(message):
            raise ChannelClosed("a message of an unknown shape")
        return list(message)

    def _time_left(self) -> float | None:
        """Return seconds until ``patience`` is to be asked again, which takes system calls."""
        if self.patience is None:
            return None
        now = time.monotonic()
        if self.patience is not self._asked or now >= self._ask_again:
            left = self.patience()
            if left <= 0:
                raise DeadlineExceeded
            self._asked, self._ask_again = self.patience, now + left
        return self._ask_again - now


class Channel(Conversation):
    """One side of a conversation over a pair of pipes."""

    def __init__(self, read_fd: int, write_fd: int, **options: Any) -> None:  # noqa: ANN401
        """Take over two descriptors; the options are those of ``Conversation``."""
        super().__init__(**options)
        self._read_fd, self._write_fd = read_fd, write_fd
        os.set_blocking(read_fd, False)
        os.set_blocking(write_fd, False)
        self._readable = _poller(read_fd, select.POLLIN)
        self._writable = _poller(write_fd, select.POLLOUT)
        self._arrived = bytearray()

    def is_quiet(self) -> bool:
        """Tell whether no message has come in unasked."""
        return not self._arrived and not self._readable.poll(0)

    def _send(self, payload: bytes) -> None:
        data = memoryview(_LENGTH.pack(len(payload)) + payload)
        while data:
            try:
                data = data[os.write(self._write_fd, data) :]
            except BlockingIOError:
                self._wait(self._writable)
            except OSError as error:
                raise ChannelClosed("the other side has gone") from error

    def _arrive(self) -> bytes:
        (length,) = _LENGTH.unpack(self._read_exactly(_LENGTH.size))
        if length > wire.MAX_MESSAGE:
            raise ChannelClosed("a message larger than the limit")
        return self._read_exactly(length)

    def _read_exactly(self, size: int) -> bytes:
        while len(self._arrived) < size:
            self._wait(self._readable)
            # A small message comes with its length in one piece.
            most = min(max(size - len(self._arrived), _PAGE), 1 << 20)
            try:
                part = os.read(self._read_fd, most)
            except BlockingIOError:
                continue
            except OSError as error:
                raise ChannelClosed("the other side has gone") from error
            if not part:
                raise ChannelClosed("the other side has gone")
            self._arrived += part
        found = bytes(self._arrived[:size])
        del self._arrived[:size]
        return found

    def _wait(self, poller: select.poll) -> None:
        """Wait until a descriptor is ready."""
        while True:
            left = self._time_left()
            if poller.poll(None if left is None else math.ceil(left * 1000)):
                return


def _poller(descriptor: int, event: int) -> select.poll:
    poller = select.poll()
    poller.register(descriptor, event)
    return poller


def _as_theirs(handle: Handle) -> Handle:
    """Say a handle of the other side's own back to it, where it is yours."""
    return Handle("yours", handle.key) if handle.owner == "mine" else handle


def describe_error(error: BaseException) -> dict[str, Any]:
    """Tell the names of an exception's classes and its message."""
    try:
        message = str(error)
    except BaseException:  # a student's own __str__ may fail in any way
        message = ""
    message = message.encode("utf-8", "replace").decode()[:MAX_TEXT]
    names = [cls.__name__ for cls in type(error).__mro__ if issubclass(cls, BaseException)]
    return {"types": names[:20], "message": message, "line": None, "functions": []}


def _is_message(message: object) -> bool:
    if not isinstance(message, list) or len(message) < 3:
        return False
    kind, number, *rest = message
    if not isinstance(kind, str) or type(number) is not int:
        return False
    if kind == "call":
        shapes = (list, list, dict)
        if len(rest) != len(shapes):
            return False
        fits = all(isinstance(part, shape) for part, shape in zip(rest, shapes, strict=True))
        return fits and len(rest[0]) == 2 and all(isinstance(key, str) for key in rest[2])
    return len(rest) == 1 and (kind == "return" or (kind == "raise" and isinstance(rest[0], dict)))
