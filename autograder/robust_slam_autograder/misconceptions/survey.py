"""Finds out once which ways to be wrong can be told apart, and under which keys.

Candidates run in a child process: one may loop for ever, and then it is no candidate.
"""

from __future__ import annotations

import contextlib
import functools
import signal
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence

from robust_slam_autograder.executor import guarded
from robust_slam_autograder.executor.guarded import Overrun
from robust_slam_autograder.misconceptions import bench as benches
from robust_slam_autograder.misconceptions.bench import Bench, Right, Setting
from robust_slam_autograder.misconceptions.candidates import Candidate, candidates, chosen
from robust_slam_autograder.misconceptions.shapes import Seen, Shape
from robust_slam_autograder.misconceptions.tables import Table, sealed
from robust_slam_autograder.reading.labelled import Answer

SHORTEST = 0.05
"""Seconds of processor time that a candidate may always take."""
TIMES_LONGER = 5.0
"""How much longer than the solution it may take."""
WRITTEN_LONGER = 20.0
"""How much longer again an answer may take that was written down: an end is in sight."""
MOST = 120.0
"""Of all candidates of one exercise: the likelier ones come first, and the others are left out."""
BACKSTOP = 10.0
"""Then the kernel ends the process: it computes in C, where nothing interrupts it."""

Choice = Callable[[Bench], Iterable[Candidate]]


def shapes_of(
    setting: Setting, exercise: str, choice: Choice
) -> Iterator[tuple[Candidate, Shape]]:
    """Run candidates on an exercise's cases, and yield those that a label may fit.

    Words and whole numbers are alike by chance: they fit none.

    Args:
        setting: the test cells.
        exercise: its name.
        choice: which candidates, always in the same order.

    Raises:
        ValueError: the solution itself loses a case.
    """
    start, is_over = 0, False
    while not is_over:
        work = functools.partial(_measured, setting, exercise, choice, start)
        try:
            for number, candidate, shape in guarded.guarded(work):
                start = number + 1
                if shape.real and shape.keys():
                    yield candidate, shape
            is_over = True
        except Overrun:
            start += 1


def _measured(
    setting: Setting, exercise: str, choice: Choice, start: int
) -> Iterator[tuple[int, Candidate, Shape]]:
    bench = benches.bench(setting)
    right = bench.right(exercise)
    began = time.process_time()
    bench.shape(exercise, bench.names, right)
    started = time.process_time()
    seconds = max(SHORTEST, TIMES_LONGER * (started - began))
    for number, candidate in enumerate(choice(bench)):
        if time.process_time() - started > MOST:
            return
        if number >= start:
            mine = seconds * (WRITTEN_LONGER if candidate.source else 1.0)
            yield number, candidate, _shape(bench, exercise, candidate, right, mine)


def _shape(
    bench: Bench, exercise: str, candidate: Candidate, right: Right, seconds: float
) -> Shape:
    """Run a candidate as ``Bench.shape`` does; what raises by itself, or takes long, is lost."""
    with (
        guarded.at_most(BACKSTOP * seconds),
        contextlib.suppress(Exception, _Late, SystemExit),
        benches.quiet(),
        _soon(seconds),
    ):
        return bench.shape(exercise, candidate.names(bench, exercise), right)
    return Shape({candidate.sentence: Seen()})


class _Late(BaseException):
    """Time is up. Not an Exception: neither a test nor an answer may swallow it."""


@contextlib.contextmanager
def _soon(seconds: float) -> Iterator[None]:
    def late(signum: int, frame: object) -> None:
        raise _Late

    before = signal.signal(signal.SIGVTALRM, late)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def survey(setting: Setting, exercise: str, answers: Sequence[Answer]) -> Table:
    """Return the labels of an exercise's wrong answers, by what they come to.

    Raises:
        ValueError: the solution itself loses a case.
    """
    choice = functools.partial(candidates, exercise=exercise, answers=answers)
    found = shapes_of(setting, exercise, choice)
    return labelled((one, shape.keys()) for one, shape in found)


def labelled(found: Iterable[tuple[Candidate, tuple[str, ...]]]) -> Table:
    """Return the table of candidates, of which the keys are known."""
    alike: dict[str, list[Candidate]] = defaultdict(list)
    for candidate, keys in found:
        alike[next((key for key in keys if key in alike), keys[0])].append(candidate)
    return sealed({key: chosen(group) for key, group in alike.items()})
