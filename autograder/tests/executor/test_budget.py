"""Limits count work and not waiting; what only waits is ended late, by the clock."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from robust_slam_autograder.executor import budget
from robust_slam_autograder.executor.budget import WALL_FACTOR, Meter
from robust_slam_autograder.executor.session import SessionFault
from robust_slam_autograder.reading import assignment
from robust_slam_autograder.reading.assignment import Limits
from robust_slam_autograder.sandbox import Unsandboxed

from .. import kernel
from ..as_user import ROOT
from ..kernel import working
from ..sessions import started

FOR_EVER = 1e6


@pytest.fixture
def clocks(monkeypatch):
    """The clocks of a machine, which stand still."""
    found = SimpleNamespace(own=100.0, student=100.0, wall=100.0)
    found.process_time, found.monotonic = lambda: found.own, lambda: found.wall
    monkeypatch.setattr(budget, "time", found)
    return found


def test_waiting_for_the_machine_uses_up_no_limit(clocks):
    deadline = Meter().start(2.0)
    clocks.wall += 2.0 * WALL_FACTOR - 1
    assert deadline.left() == 1.0
    clocks.wall += 1
    assert deadline.left() <= 0


def test_work_on_either_side_uses_up_a_limit(clocks):
    meter = Meter()
    meter.follow(lambda: clocks.student)  # what it used before is not counted
    deadline = meter.start(2.0)
    clocks.own += 0.5
    clocks.student += 1.0
    assert deadline.left() == 0.5
    clocks.student += 0.5
    assert deadline.left() == 0.0


def test_what_an_ended_process_used_stays_used(clocks):
    meter = Meter()
    deadline = meter.start(2.0)
    meter.follow(lambda: clocks.student)
    clocks.student += 1.5
    meter.leave()
    clocks.student += 100
    assert deadline.left() == 0.5
    meter.follow(lambda: clocks.student)
    assert deadline.left() == 0.5


CODE = """
import time, threading
def sleep(seconds): return time.sleep(seconds)
def work():
    while True: pass
def work_in_a_thread():
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join()
"""
NAMES = ("sleep", "work", "work_in_a_thread")
SHORT = Limits(call_seconds=0.1, cell_seconds=20, notebook_seconds=20)


@pytest.mark.sandbox
@pytest.mark.parametrize("back_end", ["none", *kernel.usable()])
def test_each_back_end_counts_work_and_no_sleep(back_end, monkeypatch):
    monkeypatch.setattr(budget, "WALL_FACTOR", FOR_EVER)
    wall = Unsandboxed() if back_end == "none" else working(back_end)
    with started(CODE, names=NAMES, limits=SHORT, wall=wall) as session:
        names = session.bindings()
        assert names["sleep"](0.3) is None
        for name in NAMES[1:]:
            with pytest.raises(SessionFault, match="timeout"):
                names[name]()
            session.begin()
        assert session.total.left() > 0


PART = 5
CALLS = 100_000 // PART
"""A part of what the statements of two assignments call slow, and their limits allow."""
MANY = f"""
def f(rho):
    for n in range({CALLS}): last = rho(n / 7)
    return last
"""


def test_the_calls_that_statements_name_are_within_their_limits(monkeypatch):
    monkeypatch.setattr(budget, "WALL_FACTOR", FOR_EVER)  # the tests beside it may take long
    first, other = (
        assignment.load_config(ROOT / "solutions" / name / assignment.CONFIG_NAME).limits
        for name in ("02-four-costs", "04-non-convexity")
    )
    assert first == other
    limits = replace(first, call_seconds=first.call_seconds / PART)
    with started(MANY, limits=limits) as session:
        last = session.bindings()["f"](lambda u: float(np.minimum(u, 3.0)) / 2)
    assert last == 1.5
