"""The trusted end of the pipe: one untrusted process, replaced after a hang or a death."""

from __future__ import annotations

import builtins
import contextlib
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

from robust_slam_autograder.assignment import Limits
from robust_slam_autograder.channel import (
    Channel,
    ChannelClosed,
    DeadlineExceeded,
    RaisedThere,
)
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.sandbox import Launch, Running, Sandbox
from robust_slam_autograder.submission import Piece
from robust_slam_autograder.wire import Handle, WireError

Fault = Literal["timeout", "died"]


class SessionFault(BaseException):
    """Student code hung or died. Not an Exception: a test's ``except`` must not swallow it."""

    def __init__(self, kind: Fault) -> None:
        self.kind = kind
        super().__init__(kind)


class StudentError(Exception):
    """A student's function raised; it is also an instance of the builtin class that was raised."""

    line: int | None = None
    """Line in the student's cell, where known."""


@dataclass(frozen=True)
class Program:
    """What an untrusted process runs before it answers calls."""

    setup: Sequence[str]
    pieces: Sequence[Piece]
    names: Sequence[str]
    """Names that tests may use."""
    withheld: tuple[str, ...]


@dataclass
class Session:
    """Runs a program in a sandbox and calls its functions.

    Attributes:
        errors: per piece label, the error that its cell raised or the fault that it caused.
        started: how many processes were used.
    """

    sandbox: Sandbox
    program: Program
    limits: Limits
    end: float
    """When the whole submission's time is used up (``time.monotonic``)."""
    errors: dict[str, StudentError | SessionFault] = field(default_factory=dict)
    started: int = 0
    _running: Running | None = None
    _channel: Channel | None = None
    _skip: set[int] = field(default_factory=set)
    _depth: int = 0

    def bindings(self) -> dict[str, Any]:
        """The names that tests see: a proxy for a function, a copy of a value."""
        found: dict[str, Any] = {}
        kinds = self._request("kinds", [list(self.program.names)])
        for name in self.program.names:
            kind = kinds.get(name) if isinstance(kinds, dict) else None
            if kind == "function":
                found[name] = self._proxy(name)
            elif kind == "value":
                with contextlib.suppress(StudentError):
                    found[name] = self._request("value", [name])
        return found

    def close(self) -> None:
        """End the untrusted process and all that it started."""
        running, self._running, self._channel = self._running, None, None
        if running is not None:
            running.stop()

    def _proxy(self, name: str) -> Callable[..., Any]:
        def student_function(*args: object, **kwargs: object) -> Any:  # noqa: ANN401
            return self._request("call", [name, list(args), kwargs])

        student_function.__name__ = student_function.__qualname__ = name
        return student_function

    def _request(self, what: str, args: Sequence[Any]) -> Any:  # noqa: ANN401
        """Ask the untrusted process, starting one where none runs."""
        channel = self._channel or self._start()
        return self._ask(channel, what, args, self.limits.call_seconds)

    def _ask(self, channel: Channel, what: str, args: Sequence[Any], seconds: float) -> Any:  # noqa: ANN401
        if self._depth == 0:
            channel.deadline = min(time.monotonic() + seconds, self.end)
        self._depth += 1
        try:
            return channel.call(Handle("name", what), tuple(args), {})
        except RaisedThere as error:
            raise student_error(error) from None
        except WireError as error:
            raise TypeError(f"the test hands over what cannot cross: {error}") from error
        except DeadlineExceeded:
            self.close()
            raise SessionFault("timeout") from None
        except ChannelClosed:
            self.close()
            raise SessionFault("died") from None
        finally:
            self._depth -= 1

    def _start(self) -> Channel:
        """Start a process and run the program, leaving out cells that hung before."""
        while True:
            channel = self._spawn()
            try:
                self._run_setup(channel)
                if self._run_pieces(channel):
                    self._channel = channel
                    return channel
            except BaseException:
                self.close()
                raise

    def _spawn(self) -> Channel:
        if time.monotonic() > self.end:
            raise SessionFault("timeout")
        cpu = int(self.limits.notebook_seconds) + 5
        launch = Launch(withheld=self.program.withheld, cpu_seconds=cpu)
        self._running = self.sandbox.start(launch)
        self.started += 1
        problem = self._running.await_ready()
        if problem is not None:
            raise GraderFailure(f"The sandbox ({self.sandbox.name}) did not start: {problem}")
        return Channel(*self._running.pipes())

    def _run_setup(self, channel: Channel) -> None:
        for number, source in enumerate(self.program.setup, start=1):
            try:
                self._ask(channel, "run", [f"set-up {number}", source], self.limits.cell_seconds)
            except StudentError as error:
                raise GraderFailure(f"Set-up cell {number} fails: {error}") from None
            except SessionFault as fault:
                raise GraderFailure(f"Set-up cell {number}: {fault.kind}.") from None

    def _run_pieces(self, channel: Channel) -> bool:
        """Run the student's cells; False when one hung or died and a fresh start is due."""
        for number, piece in enumerate(self.program.pieces):
            if number in self._skip:
                continue
            try:
                self._ask(channel, "run", [piece.label, piece.source], self.limits.cell_seconds)
            except StudentError as error:
                self.errors[piece.label] = error
            except SessionFault as fault:
                self.errors[piece.label] = fault
                self._skip.add(number)
                return False
        return True


def student_error(raised: RaisedThere) -> StudentError:
    """Make an exception that tests can catch by the builtin class that the student raised.

    Only classes below Exception count, so that nothing a student raises ends the grader.
    """
    bases: tuple[type, ...] = (StudentError,)
    for name in raised.types:
        builtin = getattr(builtins, name, None)
        if isinstance(builtin, type) and issubclass(builtin, Exception):
            if builtin not in (Exception, UnicodeDecodeError, UnicodeEncodeError):
                bases = (StudentError, builtin)
            break
    name = raised.types[0] if raised.types else "Exception"
    try:
        error: StudentError = type(name, bases, {})(raised.message)
    except TypeError:  # a builtin whose layout does not mix, or that wants other arguments
        error = type(name, (StudentError,), {})(raised.message)
    error.line = raised.line
    return error
