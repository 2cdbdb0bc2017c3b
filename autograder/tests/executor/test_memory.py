"""What student code has the trusted side hold is bounded, and costs the student alone."""

import functools

import pytest
from robust_slam_autograder.executor import memory, trusted
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.sandbox import Sandbox

from .. import kernel, toy

SHARE = 64 * 1024**2
"""So that little has to cross."""
GATHERS = """\
held = [double(n) for n in range(4, 30)]
assert len(held) == 26
"""
RECORDS = """\
held = []
double(lambda u: held.append(u))
assert len(held) == 26
"""
ANSWERS = """\
def double(x):
    if callable(x): return [x(np.zeros(1_000_000)) for _ in range(26)] and None
    return 6 if x == 3 else np.zeros(1_000_000)
"""


def grade(wall: Sandbox, test: str) -> Result:
    memory.HELD_BYTES = SHARE  # of this process, which does nothing else
    memory.bound()
    return toy.graded(toy.answer(ANSWERS), toy.assignment(double_random=test), wall=wall)


@pytest.mark.parametrize("test", [GATHERS, RECORDS], ids=["answers", "arguments"])
def test_what_a_test_gathers_costs_its_case_and_no_other(test: str) -> None:
    # A worker may be a fork of a process that owns another wall, so this one's is handed over.
    work = functools.partial(grade, kernel.quickest())
    ((_, result),) = trusted.run_each([test], work, at_once=1, seconds=lambda task: 120)
    assert isinstance(result, Result) and result.status == "graded"
    double, apply = result.exercises
    assert double.status in ("partial", "died")
    assert [case.earned for case in double.cases] == [4, 0]
    assert (apply.status, apply.score) == ("passed", 10)


def hold(count: int) -> bool:
    """Whether a test may hold so many bytes; what it may not, the grader still has."""
    try:
        with memory.for_tests():
            return len(bytearray(count)) == count
    except MemoryError:
        return len(bytearray(memory.KEPT_BACK_BYTES // 2)) == 0


def test_a_students_own_check_gives_tests_the_same_share(monkeypatch):
    monkeypatch.setattr(memory, "HELD_BYTES", SHARE)
    with pytest.raises(MemoryError), memory.for_tests():
        bytearray(4 * SHARE)
    assert len(bytearray(4 * SHARE)) == 4 * SHARE


def test_tests_have_their_share_and_the_grader_keeps_its_own():
    sizes = [memory.HELD_BYTES // 2, memory.HELD_BYTES + memory.KEPT_BACK_BYTES // 2]
    answers = trusted.run_each(sizes, hold, at_once=1, seconds=lambda task: 60)
    assert [answer for _, answer in answers] == [True, False]
