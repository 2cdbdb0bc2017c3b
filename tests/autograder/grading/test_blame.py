"""What student code breaks costs the student marks; what the grader breaks is its own failure."""

from __future__ import annotations

from dataclasses import dataclass, field

import pytest
from robust_slam_autograder.errors import GraderFailure
from robust_slam_autograder.executor.budget import Meter
from robust_slam_autograder.executor.session import Program, Session, SessionFault, StudentError
from robust_slam_autograder.grading import marking, results
from robust_slam_autograder.reading.assignment import Limits, Piece
from robust_slam_autograder.sandbox import Launch, Running, Unsandboxed

from tests.autograder import toy

CANARY = "STUDENTS_WORDS"
FIND = 'import gc\n(channel,) = [o for o in gc.get_objects() if type(o).__name__ == "Channel"]\n'
RAISES = f"class {CANARY}(Exception): pass\ndef raises(*args): raise {CANARY}('{CANARY}')\n"
EXITS = "import os\ndef raises(*args): os._exit(3)\n"
JUNK = f"def raises(*args): return ['{CANARY}']\n"
MUTE = f"{RAISES}channel._describe = raises\n"
ROUTES = ("kinds", "value", "call", "run", "read")


@dataclass
class FailsLater:
    """A back end that works so many times."""

    starts: int
    name: str = "none"
    inner: Unsandboxed = field(default_factory=Unsandboxed)

    def problem(self) -> str | None:
        return None

    def start(self, launch: Launch) -> Running:
        self.starts -= 1
        if self.starts < 0:
            raise GraderFailure("The machine is full.")
        return self.inner.start(launch)


@pytest.mark.parametrize(
    "code", [RAISES, EXITS, JUNK, MUTE], ids=["raises", "exits", "junk", "mute"]
)
def test_replaced_entry_points_leave_a_mark_and_no_words(code: str) -> None:
    """Whatever student code makes of the functions that the grader calls by name."""
    replace = "".join(f"channel._named['{name}'] = raises\n" for name in ROUTES)
    tests = toy.assignment()
    cells = toy.answer(f"{FIND}{code}{replace}")
    submission = toy.submission(cells, tests)
    result = marking.grade(tests, submission, student="a", seed=1, sandbox=Unsandboxed())
    assert result.status == "graded" and result.score == 0
    assert result.reason == "" and CANARY not in results.as_text(result)


def begin(setup: str, *pieces: str) -> Session:
    limits = Limits(call_seconds=5, cell_seconds=10, notebook_seconds=30)
    program = Program(
        setup=[Piece("set-up 1", setup, own=False)],
        pieces=[Piece(f"cell {n}", text, own=False) for n, text in enumerate(pieces)],
        names=("f",),
        withheld=(),
    )
    session = Session(Unsandboxed(), program, limits, Meter().start(30))
    try:
        session.begin()
    finally:
        session.close()
    return session


SPOILT = (
    "import linecache\nassert 'eno' + 'ugh' not in str(linecache.cache), 'no memory is left'\n"
)
"""Stands for a set-up that fails because reading the student's cells took all memory."""


def test_a_set_up_that_student_code_spoils_is_no_failure_of_the_grader() -> None:
    with pytest.raises(SessionFault) as caught:
        begin(SPOILT, "enough = 1\n")
    assert caught.value.kind == "died"


def test_a_set_up_that_fails_by_itself_is_a_failure_of_the_grader() -> None:
    with pytest.raises(GraderFailure, match="set-up 1, fails: no such thing"):
        begin("raise ValueError('no such thing')", "f = 1\n")


def test_a_cell_that_cannot_be_sent_is_a_cell_that_cannot_be_read() -> None:
    error = begin("x = 1\n", "f = '\ud800'\n", "f = 2\n").errors["cell 0"]
    assert isinstance(error, StudentError) and "cannot be read" in str(error)


def test_a_back_end_that_fails_between_two_cases_is_no_lost_case() -> None:
    """The student's code dies, but that no new process starts is the machine's fault."""
    tests = toy.assignment()
    dies = toy.answer("import os\ndef double(x): os._exit(0)\n")
    submission = toy.submission(dies, tests)
    with pytest.raises(GraderFailure, match="machine is full"):
        marking.grade(tests, submission, student="a", seed=1, sandbox=FailsLater(1))


def test_a_test_cell_that_does_not_compile_is_the_instructors() -> None:
    for cell in ("return 3\n", "await nothing\n"):
        tests = toy.assignment(double_random=cell)
        with pytest.raises(GraderFailure, match="double-random is no Python"):
            submission = toy.submission(toy.answer(), tests)
            marking.grade(tests, submission, student="a", seed=1, sandbox=Unsandboxed())
