"""No process of its own: for a student's own check in a browser, where there is only one.

Student code gets a fresh ``__main__``, its own copies of the packages that are withheld in
part, and an empty working folder. Nothing else is apart, and nothing is guarded.
"""

from __future__ import annotations

import contextlib
import getpass
import importlib
import io
import sys
import tempfile
import types
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any, NoReturn

from robust_slam_autograder.protocol.channel import ChannelClosed, Check, Conversation
from robust_slam_autograder.protocol.notebook import Notebook, do_nothing
from robust_slam_autograder.sandbox.terms import Launch
from robust_slam_autograder.student import imports

TOOL = 4
"""The number under which ``sys.monitoring`` knows us."""
LOOPS = 256
"""How many rounds of loops go by between two looks at the clock."""
Around = Callable[[], AbstractContextManager[None]]
"""What is done around the code of one side."""


class InProcess:
    """No wall, and no other process."""

    name = "none"

    def problem(self) -> str | None:
        """Return None: it works everywhere, and guards nothing."""
        return None

    def start(self, launch: Launch) -> Here:
        """Prepare this process."""
        return Here(launch)


class Here:
    """This process, as far as student code is concerned."""

    def __init__(self, launch: Launch) -> None:
        self._launch = launch
        self._modules = _Modules(launch.withheld)
        self._clean_up = contextlib.ExitStack()
        folder = self._clean_up.enter_context(tempfile.TemporaryDirectory(prefix="autograder-"))
        self._clean_up.enter_context(contextlib.chdir(folder))
        self._clean_up.enter_context(_hidden_figures())
        self._clean_up.enter_context(_no_keyboard())

    def connect(self, check: Check) -> End:
        """Connect the grader with a fresh notebook; ``check`` as in ``Conversation``."""
        near = End(lambda: self._modules.of(student=False), check=check, widen=True)
        watch = self._clean_up.enter_context(_watching(near.look_at_the_time))
        with self._modules.of(student=True):
            notebook = _Watched(types.ModuleType("__main__"), self._launch.used, watch)
        notebook.names["__builtins__"] = _builtins(self._launch)
        what = ("read", "run", "kinds", "reached", "value", "call")
        far = End(
            lambda: self._modules.of(student=True),
            named={name: getattr(notebook, name) for name in what},
            describe=notebook.describe,
            tells=BaseException,
        )
        near.join(far)
        return near

    def await_ready(self) -> str | None:
        """Return None: it is ready."""
        return None

    def cpu_seconds(self) -> float:
        """Return nothing beside what this process itself counts."""
        return 0.0

    def stop(self) -> None:
        """Undo what was done to this process."""
        self._clean_up.close()


class End(Conversation):
    """One side of a conversation in one process; it works while the other one waits.

    What crosses is copied as it is between processes, so the same values cross and the same
    errors are raised.
    """

    def __init__(self, around: Around, **options: Any) -> None:  # noqa: ANN401
        """Make one side: its functions run within ``around``; options as in ``Conversation``."""
        super().__init__(**options)
        self._around = around
        self._inbox: deque[bytes] = deque()
        self._other = self

    def join(self, other: End) -> None:
        """Connect the two sides."""
        self._other, other._other = other, self

    def look_at_the_time(self) -> None:
        """Raise DeadlineExceeded where this side has waited for as long as it may."""
        self._time_left()

    def is_quiet(self) -> bool:
        """Tell whether no message has come in unasked."""
        return not self._inbox

    def _send(self, payload: bytes) -> None:
        self._other._inbox.append(payload)

    def _arrive(self) -> bytes:
        while not self._inbox:
            self._other._answer_one()
        return self._inbox.popleft()

    def _answer_one(self) -> None:
        kind, number, *rest = self._receive()
        if kind != "call":
            raise ChannelClosed("an answer to no question")
        with self._around():
            self._answer(number, *rest)


Watch = Callable[[types.CodeType], None]
"""Has code end when its time is up."""


class _Watched(Notebook):
    """A notebook whose loops end when their time is up."""

    def __init__(self, module: types.ModuleType, used: tuple[str, ...], watch: Watch) -> None:
        super().__init__(module, used)
        self._watch = watch

    def compiled(self, *args: Any, **kwargs: Any) -> types.CodeType:  # noqa: ANN401
        """Compile as a notebook does it, and watch the code."""
        code = super().compiled(*args, **kwargs)
        self._watch(code)
        return code


class _Modules:
    """The packages that are withheld in part, once for each side, and ``__main__``."""

    def __init__(self, withheld: tuple[str, ...]) -> None:
        self._tops = {"__main__", *(name.partition(".")[0] for name in withheld)}
        self._finder = imports.Withheld(withheld)
        self._away: dict[str, types.ModuleType] = {}
        self._is_student = False

    @contextlib.contextmanager
    def of(self, *, student: bool) -> Iterator[None]:
        """Have one side's modules there within this context."""
        before = self._is_student
        self._change(student)
        try:
            yield
        finally:
            self._change(before)

    def _change(self, student: bool) -> None:
        if student == self._is_student:
            return
        # No module is there without the package that it is in.
        names = self._tops.intersection(sys.modules)
        if len(names) > 1:
            names = {name for name in sys.modules if name.partition(".")[0] in names}
        taken = {name: sys.modules.pop(name) for name in names}
        sys.modules.update(self._away)
        self._away, self._is_student = taken, student
        if student:
            sys.meta_path.insert(0, self._finder)
        else:
            sys.meta_path.remove(self._finder)


def _builtins(launch: Launch) -> types.ModuleType:
    found = imports.student_builtins(launch.packages, launch.withheld)
    quiet = {"exit": sys.exit, "quit": sys.exit, "help": do_nothing, "input": _no_input}
    found.__dict__.update(quiet)
    return found


def _no_input(*args: object, **options: object) -> NoReturn:
    raise EOFError("EOF when reading a line")


@contextlib.contextmanager
def _no_keyboard() -> Iterator[None]:
    """Let who asks for a line find the end of a file: a lab's kernel would wait for an answer."""
    before, asked = sys.stdin, getpass.getpass
    sys.stdin, getpass.getpass = io.StringIO(), _no_input
    try:
        yield
    finally:
        sys.stdin, getpass.getpass = before, asked


@contextlib.contextmanager
def _hidden_figures() -> Iterator[None]:
    """Draw figures without showing them, and forget them in the end."""
    try:
        pyplot = importlib.import_module("matplotlib.pyplot")
    except ImportError:
        yield
        return
    backend, there = pyplot.get_backend(), set(pyplot.get_fignums())
    use, switch = pyplot.matplotlib.use, pyplot.switch_backend
    switch("agg")
    try:
        yield
    finally:
        for number in set(pyplot.get_fignums()) - there:
            pyplot.close(number)
        vars(pyplot.matplotlib)["use"], vars(pyplot)["switch_backend"] = use, switch
        switch(backend)


@contextlib.contextmanager
def _watching(look: Callable[[], None]) -> Iterator[Watch]:
    """Have the loops of code look at the time; before Python 3.12 nothing can do that."""
    if sys.version_info < (3, 12):
        yield lambda code: None
        return
    monitoring = sys.monitoring
    rounds = 0

    def jumped(code: types.CodeType, start: int, end: int) -> None:
        nonlocal rounds
        rounds += 1
        if rounds % LOOPS == 0:
            look()

    def watch(code: types.CodeType) -> None:
        monitoring.set_local_events(TOOL, code, monitoring.events.JUMP)
        for inner in code.co_consts:
            if isinstance(inner, types.CodeType):
                watch(inner)

    monitoring.use_tool_id(TOOL, "autograder")
    monitoring.register_callback(TOOL, monitoring.events.JUMP, jumped)
    try:
        yield watch
    finally:
        monitoring.register_callback(TOOL, monitoring.events.JUMP, None)
        monitoring.free_tool_id(TOOL)
