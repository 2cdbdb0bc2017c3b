"""The trusted end of the pipe: one untrusted process, replaced after a hang or a death."""

import contextlib
import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, cast

from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor import handed_over
from robust_slam_autograder.executor.budget import Deadline, Meter, soonest
from robust_slam_autograder.protocol.channel import (
    Conversation,
    DeadlineExceeded,
    RaisedThere,
    alike,
)
from robust_slam_autograder.protocol.channel import Fault as ChannelFault
from robust_slam_autograder.protocol.wire import Handle, WireError
from robust_slam_autograder.reading.assignment import Assignment, Piece
from robust_slam_autograder.reading.source import imported_modules
from robust_slam_autograder.sandbox import Launch, Running, Sandbox

Kind = Literal["timeout", "died"]


PRELOAD = ("matplotlib.pyplot", "IPython.core.inputtransformer2")
"""Modules that many a student's own cell imports, or that reading it takes."""


class SessionFault(ChannelFault):
    """Student code hung or died. Not an Exception: a test's ``except`` must not swallow it."""

    def __init__(self, kind: Kind) -> None:
        self.kind = kind
        super().__init__(kind)


class StudentError(Exception):
    """A student's function raised; it is also an instance of the builtin class that was raised."""

    line: int | None = None
    """Line in the student's cell, where known."""
    functions: tuple[str, ...] = ()
    """The function that was called and the one that raised, where known."""

    def __str__(self) -> str:  # KeyError's own would quote the message once more
        return str(self.args[0]) if self.args else ""


@dataclass
class Session:
    """Runs the set-up and a student's code in a sandbox, and calls its functions.

    A test cell is announced with ``begin``; from its first fault on every call raises
    that fault again, until the next cell begins with a fresh process.

    Attributes:
        errors: per piece label, the error that its cell raised or the fault that it caused.
        fault: what went wrong since ``begin``.
    """

    sandbox: Sandbox
    assignment: Assignment
    pieces: Sequence[Piece]
    """The student's code."""
    total: Deadline
    """Of the whole submission."""
    skip: set[int] = field(default_factory=set)
    """Pieces that hung or died: they are left out from then on."""
    errors: dict[str, StudentError | SessionFault] = field(default_factory=dict)
    fault: SessionFault | None = None
    _cell: Deadline | None = None
    _running: Running | None = None
    _channel: Conversation | None = None
    _depth: int = 0

    @property
    def _preload(self) -> tuple[str, ...]:
        """List what the process will want: imports of the instructor's cells, and plots."""
        found = [
            name for piece in self.assignment.setup for name in imported_modules(piece.source)
        ]
        return tuple(dict.fromkeys([*PRELOAD, *found, *self.assignment.libraries]))

    def begin(self) -> None:
        """Forget the last cell's fault and make sure that a process runs.

        Raises:
            SessionFault: the submission's time is used up.
            GraderFailure: the sandbox or the instructor's set-up does not work.
        """
        self._cell = None
        if self._channel is not None and not self._channel.is_quiet():
            # Its code forked, or talks by itself: the next cell shall not suffer for it.
            self.close()
        if self._channel is None:
            self._start()
        self.fault = None
        self._cell = self.total.meter.start(self.assignment.config.limits.cell_seconds)

    @property
    def lacks_own_cells(self) -> bool:
        """Tell whether a cell of the student's own hung or died, and is left out."""
        setup = len(self.assignment.setup)
        return any(self.pieces[number - setup].own for number in self.skip)

    def time_left(self) -> float:
        """Say how many seconds the present cell surely has; 0 or less where it has none."""
        return soonest(self._deadlines())

    def _deadlines(self) -> list[Deadline]:
        return [self.total] if self._cell is None else [self._cell, self.total]

    def fail(self, kind: Kind) -> SessionFault:
        """End the process after a fault, and give the fault to raise."""
        self.close()
        self.fault = SessionFault(kind)
        return self.fault

    def bindings(self) -> dict[str, Any]:
        """Return the names that tests see: a proxy for a function, a copy of a value.

        Raises:
            SessionFault: the process died, or student code changed what answers there.
        """
        found: dict[str, Any] = {}
        try:
            kinds = self._request("kinds", [list(self.assignment.names)])
        except StudentError:  # our own code does not raise there
            raise self.fail("died") from None
        for name in self.assignment.names:
            kind = kinds.get(name) if isinstance(kinds, dict) else None
            if not isinstance(kind, str):
                continue
            if kind == "function":
                found[name] = self._proxy(name)
            elif kind == "value":
                with contextlib.suppress(StudentError):
                    found[name] = self._request("value", [name])
        return found

    def reached(self) -> dict[str, set[str]]:
        """Return by name the other names that it depends on, as the student's process says."""
        names = list(self.assignment.names)
        try:
            told = self._request("reached", [names])
            return {name: {*told[name]}.intersection(names) for name in names}
        except (StudentError, SessionFault, LookupError, TypeError):
            return {}

    def close(self) -> None:
        """End the untrusted process and all that it started."""
        running, self._running, self._channel = self._running, None, None
        self.total.meter.leave()
        if running is not None:
            running.stop()

    def _proxy(self, name: str) -> Callable[..., Any]:
        def student_function(*args: object, **kwargs: object) -> Any:  # noqa: ANN401
            return self._request("call", [name, list(args), kwargs])

        student_function.__name__ = student_function.__qualname__ = name
        return student_function

    def _request(self, what: str, args: Sequence[Any]) -> Any:  # noqa: ANN401
        """Call one of the untrusted process's own functions."""
        if self.fault or self._channel is None:
            raise self.fault or SessionFault("died")
        return self._channel.invoke(Handle("name", what), tuple(args), {})

    def _invoke(
        self,
        channel: Conversation,
        target: Handle,
        args: tuple[Any, ...],
        kwargs: Mapping[str, Any],
    ) -> Any:  # noqa: ANN401
        """Call a function of the untrusted process, be it named or handed over before."""
        if self.fault or channel is not self._channel:  # that process has ended
            raise self.fault or SessionFault("died")
        return self._ask(channel, target, args, kwargs, self.assignment.config.limits.call_seconds)

    def _ask(
        self,
        channel: Conversation,
        target: Handle,
        args: tuple[Any, ...],
        kwargs: Mapping[str, Any],
        seconds: float,
    ) -> Any:  # noqa: ANN401
        if self._depth == 0:
            call = self.total.meter.start(seconds)
            channel.patience = functools.partial(soonest, [call, *self._deadlines()])
        self._depth += 1
        try:
            return channel.call(target, args, kwargs)
        except RaisedThere as error:
            raise student_error(error) from None
        except WireError as error:
            raise TypeError(f"the test hands over what cannot cross: {error}") from error
        except DeadlineExceeded:
            raise self.fail("timeout") from None
        except ChannelFault as fault:
            # A SessionFault comes from a call inside this one, or from the cell's alarm.
            raise self.fail(getattr(fault, "kind", "died")) from None
        finally:
            self._depth -= 1

    def _start(self) -> None:
        """Start a process and run the program, leaving out cells that hung before."""
        while self._channel is None:
            channel = self._spawn()
            try:
                if self._run_program(channel):
                    channel.invoke = functools.partial(self._invoke, channel)
                    self._channel = channel
            except BaseException:
                self.close()
                raise

    def _spawn(self) -> Conversation:
        if self.total.left() <= 0:
            raise self.fail("timeout")
        launch = Launch(
            withheld=self.assignment.config.withheld,
            used=self.assignment.names,
            cpu_seconds=int(self.assignment.config.limits.notebook_seconds) + 5,
            preload=self._preload,
            packages=self.assignment.config.packages,
        )
        self._running = self.sandbox.start(launch)
        problem = self._running.await_ready()
        if problem is not None:
            self.close()
            raise GraderFailure(f"The sandbox ({self.sandbox.name}) did not start: {problem}")
        self.total.meter.follow(self._running.cpu_seconds)
        return self._running.connect(handed_over.check)

    def _run_program(self, channel: Conversation) -> bool:
        """Read all cells, then run them; False when the student's hung: a fresh start is due."""
        setup = len(self.assignment.setup)
        cells = list(enumerate([*self.assignment.setup, *self.pieces]))
        unreadable: set[int] = set()
        for what in (self._read, self._run):
            for number, piece in cells:
                if number in self.skip | unreadable:
                    continue
                try:
                    what(channel, number, piece)
                except (StudentError, SessionFault) as error:
                    if number < setup:
                        self._judge_setup(piece, error)
                        continue
                    self.errors[piece.label] = error
                    if isinstance(error, SessionFault):
                        self.skip.add(number)
                        return False
                    unreadable.add(number)
        return True

    def _judge_setup(self, piece: Piece, error: StudentError | SessionFault) -> None:
        """Pass over a set-up cell that only shows answers; else find out whose fault it is.

        The student's cells were read before the set-up ran. Where the set-up fails without
        them too, the instructor's cells are to blame; else what was read is.
        """
        if not isinstance(error, SessionFault) and shows_answers(error, self.assignment.names):
            return
        if isinstance(error, SessionFault) and self.total.left() <= 0:
            raise error
        if not self.pieces:
            said = f": {error.kind}" if isinstance(error, SessionFault) else f", fails: {error}"
            raise GraderFailure(f"The instructor's cell, {piece.label}{said.rstrip('.')}.")
        self._try_setup_alone()
        raise self.fail("died")

    def _try_setup_alone(self) -> None:
        """Run the set-up in a process that never sees the student's code.

        Raises:
            GraderFailure: it fails there too.
        """
        self.close()
        total = Meter().start(self.assignment.config.limits.notebook_seconds)
        alone = Session(self.sandbox, self.assignment, (), total)
        try:
            alone.begin()
        finally:
            alone.close()

    def _read(self, channel: Conversation, number: int, piece: Piece) -> None:
        try:
            self._do(channel, "read", number, piece.label, piece.source, piece.own)
        except TypeError as error:
            if isinstance(error, StudentError):
                raise
            raise StudentError(f"the cell cannot be read: {error.__cause__}") from error

    def _run(self, channel: Conversation, number: int, piece: Piece) -> None:
        self._do(channel, "run", number)

    def _do(self, channel: Conversation, what: str, *args: object) -> None:
        """Call one of the untrusted process's own functions on a cell, for as long as it may."""
        seconds = self.assignment.config.limits.cell_seconds
        self._ask(channel, Handle("name", what), args, {}, seconds)


def shows_answers(error: Exception, names: Sequence[str]) -> bool:
    """Tell whether a set-up cell stopped because it uses what the student is to write."""
    return isinstance(error, NameError) and any(f"'{name}'" in str(error) for name in names)


def student_error(raised: RaisedThere) -> StudentError:
    """Make an exception that tests can catch by the builtin class that the student raised."""
    error = cast("StudentError", alike(raised, StudentError))
    error.line, error.functions = raised.line, raised.functions
    return error
