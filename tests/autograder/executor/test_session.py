"""A session survives whatever student code does, one fault at a time."""

from __future__ import annotations

import time
from collections.abc import Iterator

import numpy as np
import pytest
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor.budget import Meter
from robust_slam_autograder.executor.session import (
    Program,
    Session,
    SessionFault,
    StudentError,
    student_error,
)
from robust_slam_autograder.reading.assignment import Limits, Piece
from robust_slam_autograder.sandbox import Unsandboxed
from robust_slam_autograder.student.channel import RaisedThere

NAMES = ("f", "g", "make", "value")
QUICK = Limits(call_seconds=0.3, cell_seconds=10, notebook_seconds=20)


@pytest.fixture
def sessions() -> Iterator[list[Session]]:
    made: list[Session] = []
    yield made
    for session in made:
        session.close()


def begin(
    sessions: list[Session],
    *pieces: str,
    setup: tuple[str, ...] = (),
    limits: Limits = QUICK,
    withheld: tuple[str, ...] = (),
) -> Session:
    program = Program(
        setup=[Piece(f"set-up {n}", text, own=False) for n, text in enumerate(setup)],
        pieces=[Piece(f"cell {n}", text, own=False) for n, text in enumerate(pieces)],
        names=NAMES,
        withheld=withheld,
    )
    total = Meter().start(limits.notebook_seconds)
    sessions.append(Session(Unsandboxed(), program, limits, total))
    sessions[-1].begin()
    return sessions[-1]


def test_functions_are_proxies_and_values_are_copies(sessions: list[Session]) -> None:
    names = begin(sessions, "value = [1, (2, 3)]\ndef f(x, y=1): return x + y\n").bindings()
    assert names["value"] == [1, (2, 3)]
    assert names["f"](2, y=3) == 5 and names["f"].__name__ == "f"
    assert set(names) == {"f", "value"}


def test_only_names_that_tests_ask_for_are_bound(sessions: list[Session]) -> None:
    text = "np = rng = isinstance = len = 0\ndef AssertionError(): pass\nf = 1\n"
    assert begin(sessions, text).bindings() == {"f": 1}


def test_a_function_that_a_function_returned_has_the_same_deadline(
    sessions: list[Session],
) -> None:
    text = "import time\ndef make(k): return lambda x: time.sleep(x) or k * x\ndef g(): return 1\n"
    session = begin(sessions, text)
    names = session.bindings()
    slow = names["make"](3)
    for _ in range(5):
        assert slow(0.1) == pytest.approx(0.3)
    with pytest.raises(SessionFault) as caught:
        slow(100)
    assert caught.value.kind == "timeout"
    session.begin()
    assert names["g"]() == 1
    with pytest.raises(SessionFault):
        slow(0)


def test_an_error_of_a_returned_function_is_caught_by_its_class(sessions: list[Session]) -> None:
    text = "def make():\n    def inner(): raise KeyError('k')\n    return inner\n"
    inner = begin(sessions, text).bindings()["make"]()
    with pytest.raises(KeyError, match="k"):
        inner()


def test_after_a_fault_every_call_fails_until_the_next_cell(sessions: list[Session]) -> None:
    session = begin(sessions, "import os\ndef f(): os._exit(0)\ndef g(): return 1\n")
    names = session.bindings()
    for name in ("f", "g"):
        with pytest.raises(SessionFault) as caught:
            names[name]()
        assert caught.value.kind == "died"
    assert session.fault is not None
    session.begin()
    assert session.fault is None and names["g"]() == 1


def test_a_forked_child_stays_out_of_the_conversation(sessions: list[Session]) -> None:
    text = "import os\ndef f():\n    os.fork()\n    return 1\ndef g(): return 2\n"
    names = begin(sessions, text).bindings()
    assert [names["f"]() for _ in range(5)] == [1] * 5
    assert [names["g"]() for _ in range(20)] == [2] * 20


def test_a_process_that_talks_by_itself_is_replaced_for_the_next_cell(
    sessions: list[Session],
) -> None:
    text = """
import gc, os, threading
def f():
    (channel,) = [o for o in gc.get_objects() if type(o).__name__ == "Channel"]
    threading.Timer(0.1, lambda: os.write(channel._write_fd, bytes(9))).start()
def g(): return 2
"""
    session = begin(sessions, text)
    names = session.bindings()
    assert names["f"]() is None
    time.sleep(0.3)
    session.begin()
    assert names["g"]() == 2


def test_a_fault_inside_a_callback_is_told_as_what_it_is(sessions: list[Session]) -> None:
    text = "def f(h): return h()\ndef g():\n    while True: pass\n"
    names = begin(sessions, text).bindings()
    with pytest.raises(SessionFault) as caught:
        names["f"](names["g"])
    assert caught.value.kind == "timeout"


@pytest.mark.parametrize("end", ["while True: pass", "import os; os._exit(0)"])
def test_a_cell_that_hangs_or_dies_costs_its_own_names(sessions: list[Session], end: str) -> None:
    limits = Limits(call_seconds=5, cell_seconds=1.5, notebook_seconds=20)
    session = begin(sessions, "def f(): return 1\n", end, "def g(): return 2\n", limits=limits)
    names = session.bindings()
    assert names["f"]() == 1 and names["g"]() == 2
    assert isinstance(session.errors["cell 1"], SessionFault)
    assert session.skip == {1}


def test_a_cell_with_an_error_keeps_what_it_defined_before(sessions: list[Session]) -> None:
    session = begin(sessions, "def f(): return 1\n1 / 0\ndef g(): pass\n", "def make(:\n")
    assert set(session.bindings()) == {"f"}
    first, second = session.errors["cell 0"], session.errors["cell 1"]
    assert isinstance(first, ZeroDivisionError) and first.line == 2
    assert isinstance(second, SyntaxError) and second.line == 1


def test_cells_may_await_as_in_a_notebook(sessions: list[Session]) -> None:
    """A task of one cell is awaited in another: they share an event loop."""
    first = "import asyncio\ntask = asyncio.ensure_future(asyncio.sleep(0, result=2))\n"
    start = "async def later(x):\n    await asyncio.sleep(0)\n    return task if x else 1\n"
    second = "value = 1 + await (await later(True))\ndef f(): return value\n"
    session = begin(sessions, f"await_ = 0\n{first}{start}await later(False)\n", second, "g = 1")
    assert session.errors == {}
    assert session.bindings()["value"] == 3 and session.bindings()["f"]() == 3


def test_set_up_that_fails_is_the_instructors_fault(sessions: list[Session]) -> None:
    with pytest.raises(GraderFailure, match=r"set-up 0, fails: no such thing"):
        begin(sessions, setup=("raise ValueError('no such thing')",))
    session = begin(sessions, "f = 1", setup=("print(f)", "x = 1"))
    assert session.bindings() == {"f": 1}


def test_time_that_is_used_up_is_the_students_fault(sessions: list[Session]) -> None:
    limits = Limits(call_seconds=5, cell_seconds=5, notebook_seconds=0.2)
    with pytest.raises(SessionFault) as caught:
        begin(sessions, "import time\ntime.sleep(5)", setup=("x = 1",), limits=limits)
    assert caught.value.kind == "timeout"


def test_a_withheld_module_is_refused_with_a_sentence(sessions: list[Session]) -> None:
    texts = ("from xml import dom", "import xml.dom.minidom", "import xml.sax; f = 1")
    session = begin(sessions, *texts, withheld=("xml.dom",))
    assert session.bindings() == {"f": 1}
    for label in ("cell 0", "cell 1"):
        error = session.errors[label]
        assert isinstance(error, ImportError) and "xml.dom is withheld" in str(error)


def test_arrays_keep_type_shape_and_values(sessions: list[Session]) -> None:
    names = begin(sessions, "def f(x): return x\n").bindings()
    for array in (np.arange(6).reshape(2, 3), np.zeros((0, 3)), np.array(True)):
        got = names["f"](array)
        assert got.dtype == array.dtype and got.shape == array.shape
        assert np.array_equal(got, array)


@pytest.mark.parametrize("kind", ["float16", "float32", "complex64"])
def test_few_digits_do_not_round_what_they_are_compared_with(
    sessions: list[Session], kind: str
) -> None:
    code = f"import numpy as np\ndef f(x): return [np.{kind}(x), np.{kind}([x])]\n"
    names = begin(sessions, code).bindings()
    for got in names["f"](0.1):
        assert got.dtype.itemsize == 8 * (1 + np.iscomplexobj(got))
        assert not np.any(np.isclose(got, 0.1, rtol=1e-9, atol=0))


def test_nothing_that_a_student_raises_empties_a_loop(sessions: list[Session]) -> None:
    names = begin(sessions, "def f(x): raise StopIteration\n").bindings()
    with pytest.raises(StudentError):
        list(map(names["f"], [1, 2]))


@pytest.mark.parametrize(
    ("types", "caught_by"),
    [
        (["Mine", "ValueError", "Exception"], ValueError),
        (["LinAlgError", "ValueError"], ValueError),
        (["UnicodeDecodeError", "UnicodeError", "ValueError"], ValueError),
        (["SystemExit", "BaseException"], StudentError),
        (["KeyboardInterrupt"], StudentError),
        (["GeneratorExit", "BaseException"], StudentError),
        (["ExceptionGroup", "BaseExceptionGroup", "Exception"], StudentError),
        (["StopIteration", "Exception"], StudentError),
        (["StopAsyncIteration", "Exception"], StudentError),
        (["a\0b", "print", "__name__"], StudentError),
        (["a b\x1b", "Exception"], StudentError),
        ([], StudentError),
    ],
)
def test_an_error_is_an_exception_whatever_it_says_it_is(
    types: list[str], caught_by: type[Exception]
) -> None:
    error = student_error(RaisedThere({"types": types, "message": "m", "line": 3}))
    assert isinstance(error, caught_by) and isinstance(error, StudentError)
    assert isinstance(error, Exception)
    assert not isinstance(error, StopIteration | StopAsyncIteration)
    assert str(error) == "m" and error.line == 3
    assert type(error).__name__.isidentifier()
