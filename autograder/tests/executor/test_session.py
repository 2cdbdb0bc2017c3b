"""A session survives whatever student code does, one fault at a time."""

import contextlib
from collections.abc import Callable

import pytest
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor.session import SessionFault, StudentError, student_error
from robust_slam_autograder.protocol.channel import RaisedThere
from robust_slam_autograder.reading.assignment import Limits
from robust_slam_autograder.sandbox import Unsandboxed

from ..killing import wait_for
from ..sessions import started

QUICK = Limits(call_seconds=0.3, cell_seconds=10, notebook_seconds=20)


@pytest.fixture
def begin():
    """Begins sessions whose cells define f, g, make and value."""
    names = ("f", "g", "make", "value")
    with contextlib.ExitStack() as stack:
        settings = {"limits": QUICK, "names": names}
        yield lambda *cells, **more: stack.enter_context(started(*cells, **settings | more))


def fault_of(call: Callable[[], object]) -> str:
    with pytest.raises(SessionFault) as caught:
        call()
    return caught.value.kind


def test_only_names_that_tests_ask_for_are_bound(begin):
    text = "np = rng = isinstance = len = 0\ndef AssertionError(): pass\nf = 1\n"
    assert begin(text).bindings() == {"f": 1}


def test_a_function_that_a_function_returned_has_the_same_deadline(begin):
    text = "import time\ndef make(k): return lambda x: time.sleep(x) or k * x\ndef g(): return 1\n"
    session = begin(text)
    names = session.bindings()
    slow = names["make"](3)
    for _ in range(5):
        assert slow(0.1) == pytest.approx(0.3)
    assert fault_of(lambda: slow(100)) == "timeout"
    session.begin()
    # It belongs to the process that has ended: the new one does not suffer.
    fault_of(lambda: slow(0))
    assert names["g"]() == 1 and session.fault is None


def test_an_error_of_a_returned_function_is_caught_by_its_class(begin):
    text = "def make():\n    def inner(): raise KeyError('k')\n    return inner\n"
    inner = begin(text).bindings()["make"]()
    with pytest.raises(KeyError, match="k"):
        inner()


def test_an_exception_that_cannot_tell_itself_is_told(begin):
    text = "class Mute(Exception):\n    def __str__(self): raise SystemExit\ndef f(): raise Mute\n"
    with pytest.raises(StudentError) as caught:
        begin(text).bindings()["f"]()
    assert type(caught.value).__name__ == "Mute"


def test_calls_nested_without_end_are_an_error(begin):
    f = begin("def f(h): return h(h)\n").bindings()["f"]
    with pytest.raises(StudentError, match="nested too deeply"):
        f(deeper := lambda h: f(deeper))


def test_threads_of_the_student_s_take_turns(begin):
    text = "from concurrent.futures import ThreadPoolExecutor\n"
    text += "def f(h):\n    with ThreadPoolExecutor(8) as pool: return [*pool.map(h, range(8))]\n"
    assert begin(text).bindings()["f"](lambda n: n * n) == [n * n for n in range(8)]


def test_a_forked_child_stays_out_of_the_conversation(begin):
    text = "import os\ndef f():\n    os.fork()\n    return 1\ndef g(): return 2\n"
    names = begin(text).bindings()
    assert [names["f"]() for _ in range(5)] == [1] * 5
    assert [names["g"]() for _ in range(20)] == [2] * 20


def test_a_process_that_talks_by_itself_is_replaced_for_the_next_cell(begin, tmp_path):
    text = f"""
import gc, os, threading
(channel,) = [o for o in gc.get_objects() if type(o).__name__ == "Channel"]
def talk():
    os.write(channel._write_fd, bytes(9))
    os.mkdir({str(tmp_path / "told")!r})
def f(): threading.Timer(0.1, talk).start()
def g(): return 2
"""
    session = begin(text, wall=Unsandboxed())
    names = session.bindings()
    assert names["f"]() is None
    wait_for((tmp_path / "told").exists)
    session.begin()
    assert names["g"]() == 2


def test_a_fault_inside_a_callback_keeps_its_kind(begin):
    names = begin("def f(h): return h()\ndef g():\n    while True: pass\n").bindings()
    assert fault_of(lambda: names["f"](names["g"])) == "timeout"


@pytest.mark.parametrize("end", ["while True: pass", "import os; os._exit(0)"])
def test_a_cell_that_hangs_or_dies_costs_its_own_names(begin, end):
    limits = Limits(call_seconds=5, cell_seconds=1, notebook_seconds=20)
    session = begin("def f(): return 1\n", end, "def g(): return 2\n", limits=limits)
    names = session.bindings()
    assert names["f"]() == 1 and names["g"]() == 2
    assert isinstance(session.errors["cell 1"], SessionFault)
    assert session.skip == {1}


def test_a_cell_with_an_error_keeps_what_it_defined_before(begin):
    session = begin("def f(): return 1\n1 / 0\ndef g(): pass\n", "def make(:\n")
    assert set(session.bindings()) == {"f"}
    first, second = session.errors["cell 0"], session.errors["cell 1"]
    assert isinstance(first, ZeroDivisionError) and first.line == 2
    assert isinstance(second, SyntaxError) and second.line == 1


def test_cells_may_await_as_in_a_notebook(begin):
    """A task of one cell is awaited in another: they share an event loop."""
    first = "import asyncio\ntask = asyncio.ensure_future(asyncio.sleep(0, result=2))\n"
    start = "async def later(x):\n    await asyncio.sleep(0)\n    return task if x else 1\n"
    second = "value = 1 + await (await later(True))\ndef f(): return value\n"
    session = begin(f"await_ = 0\n{first}{start}await later(False)\n", second, "g = 1")
    assert session.errors == {}
    assert session.bindings()["value"] == 3 and session.bindings()["f"]() == 3


def test_set_up_that_uses_what_the_student_is_to_write_is_passed_over(begin):
    assert begin("f = 1", setup=("print(f)", "x = 1")).bindings() == {"f": 1}


def test_set_up_that_fails_by_itself_is_a_failure_of_the_grader(begin):
    with pytest.raises(GraderFailure, match="set-up 0, fails: no such thing"):
        begin("f = 1\n", setup=("raise ValueError('no such thing')",))


def test_set_up_that_student_code_spoils_is_a_death(begin):
    """It stands for one that fails because reading the student's cells took all memory."""
    spoilt = "import linecache\nassert 'eno' + 'ugh' not in str(linecache.cache), 'no memory'\n"
    assert fault_of(lambda: begin("enough = 1\n", setup=(spoilt,))) == "died"


def test_a_cell_that_cannot_be_sent_is_a_cell_that_cannot_be_read(begin):
    error = begin("f = '\ud800'\n", "f = 2\n").errors["cell 0"]
    assert isinstance(error, StudentError) and "cannot be read" in str(error)


def test_time_that_is_used_up_is_the_students_fault(begin):
    limits = Limits(call_seconds=5, cell_seconds=5, notebook_seconds=0.2)
    sleeps = "import time\ntime.sleep(5)"
    assert fault_of(lambda: begin(sleeps, setup=("x = 1",), limits=limits)) == "timeout"


def test_nothing_that_a_student_raises_empties_a_loop(begin):
    names = begin("def f(x): raise StopIteration\n").bindings()
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
def test_an_error_is_an_exception_whatever_it_says_it_is(types, caught_by):
    error = student_error(RaisedThere({"types": types, "message": "m", "line": 3}))
    assert isinstance(error, caught_by) and isinstance(error, StudentError)
    assert not isinstance(error, StopIteration | StopAsyncIteration)
    assert str(error) == "m" and error.line == 3
    assert type(error).__name__.isidentifier()
