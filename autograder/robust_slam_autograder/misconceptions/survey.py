"""Finds out once which ways to be wrong can be told apart, and under which keys.

Candidates run in a child process: a mutant may loop for ever, and then it is no candidate.
"""

from __future__ import annotations

import contextlib
import functools
import signal
import time
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from robust_slam_autograder.executor import guarded
from robust_slam_autograder.executor.guarded import Overrun
from robust_slam_autograder.executor.seeds import PUBLIC_SEED
from robust_slam_autograder.misconceptions import bench as benches
from robust_slam_autograder.misconceptions.bench import Bench, Setting
from robust_slam_autograder.misconceptions.candidates import WRITTEN, Candidate, candidates, chosen
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.misconceptions.tables import Right, Table, arguments_of, sealed
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
    setting: Setting, exercise: str, choice: Choice, *, with_aspects: bool = False
) -> Iterator[tuple[Candidate, Shape]]:
    """Run candidates on an exercise's cases, and yield those that a label may fit.

    The arguments are those of ``measured``.
    """
    for candidate, shape in measured(setting, exercise, choice, with_aspects):
        if shape.is_known or (with_aspects and shape.has_ends):
            yield candidate, shape


def measured(
    setting: Setting,
    exercise: str,
    choice: Choice,
    with_aspects: bool = False,
    longer: float = 1.0,
) -> Iterator[tuple[Candidate, Shape]]:
    """Run candidates on an exercise's cases, and yield each with what these saw.

    Args:
        setting: the test cells and their seed.
        exercise: its name.
        choice: which candidates, always in the same order.
        with_aspects: whether these are wanted too.
        longer: by what factor a candidate may take longer than others do.

    Raises:
        ValueError: the solution itself loses a case.
    """
    start, is_over = 0, False
    while not is_over:
        work = functools.partial(_measured, setting, exercise, choice, start, with_aspects, longer)
        try:
            for number, candidate, shape in guarded.guarded(work):
                start = number + 1
                yield candidate, shape
            is_over = True
        except Overrun:
            start += 1


def _measured(
    setting: Setting, exercise: str, choice: Choice, start: int, with_aspects: bool, longer: float
) -> Iterator[tuple[int, Candidate, Shape]]:
    bench = benches.bench(setting)
    right = bench.right(exercise, with_aspects=False)
    seconds = longer * seconds_of(bench, exercise, right)
    started = time.process_time()
    for number, candidate in enumerate(choice(bench)):
        if time.process_time() - started > MOST:
            return
        if number >= start:
            mine = seconds * (WRITTEN_LONGER if candidate.origin == WRITTEN else 1.0)
            shape = shape_of(bench, exercise, candidate, right, mine, with_aspects=with_aspects)
            yield number, candidate, shape


def seconds_of(bench: Bench, exercise: str, right: Right) -> float:
    """Return how much processor time a candidate may take, by what the solution takes."""
    began = time.process_time()
    bench.shape(exercise, bench.names, right)
    return max(SHORTEST, TIMES_LONGER * (time.process_time() - began))


def shape_of(
    bench: Bench,
    exercise: str,
    candidate: Candidate,
    right: Right,
    seconds: float,
    *,
    with_aspects: bool = False,
    like: Shape | None = None,
) -> Shape:
    """Run a candidate as ``Bench.shape`` does; what raises by itself, or takes long, is lost."""
    with (
        guarded.at_most(BACKSTOP * seconds),
        contextlib.suppress(Exception, _Late, SystemExit),
        benches.quiet(),
        _soon(seconds),
    ):
        names = candidate.names(bench, exercise)
        return bench.shape(exercise, names, right, with_aspects=with_aspects, like=like)
    return Shape(lost=True)


class _Late(BaseException):
    """Time is up. Not an Exception: neither a test nor a mutant may swallow it."""


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


def survey(setting: Setting, exercise: str, answers: Sequence[Answer]) -> list[Candidate]:
    """Return one candidate for each way to be wrong that has a name."""
    choice = functools.partial(candidates, exercise=exercise, answers=answers)
    groups = alike(
        (replace(candidate, fails=tuple(shape.failed)), shape.keys())
        for candidate, shape in shapes_of(setting, exercise, choice)
        if counts(candidate, shape)
    )
    found = [one for group in groups.values() if (one := chosen(group)) is not None]
    public = replace(setting, seed=PUBLIC_SEED, whole=False)
    seen = measured(
        public, exercise, lambda bench: found, with_aspects=True, longer=WRITTEN_LONGER
    )
    return [replace(one, seen=next(iter(shape.all_keys()), "")) for one, shape in seen]


def counts(candidate: Candidate, shape: Shape) -> bool:
    """Tell whether enough came back to name it: words or whole numbers are alike by chance.

    An author's sentence says most, and a slip without its place least: both take two cases.
    """
    is_vague = candidate.slip is not None and candidate.slip.is_vague
    return shape.real and (len(shape.failed) > 1 or not (is_vague or candidate.origin == WRITTEN))


def alike(
    measured: Iterable[tuple[Candidate, tuple[str, ...]]],
) -> Mapping[str, list[Candidate]]:
    """Put candidates that cannot be told apart together, by the first of their keys."""
    found: dict[str, list[Candidate]] = defaultdict(list)
    for candidate, keys in measured:
        if keys:
            found[next((key for key in keys if key in found), keys[0])].append(candidate)
    return found


def table(setting: Setting, exercise: str, known: Sequence[Candidate]) -> Table:
    """Return what an exercise's wrong answers come to in a setting.

    Raises:
        ValueError: the solution itself loses a case.
    """
    (rest,) = guarded.guarded(lambda: iter([right_of(benches.bench(setting), exercise)]))
    found = shapes_of(setting, exercise, lambda bench: known)
    return replace(rest, labels=one_each((one, shape.keys()) for one, shape in found))


def one_each(found: Iterable[tuple[Candidate, Sequence[str]]]) -> dict[str, str]:
    """Return sealed labels by the first of their keys; empty where two candidates have it."""
    labels: dict[str, str] = {}
    for candidate, keys in found:
        for key in keys[:1]:
            if labels.setdefault(key, candidate.sentence) != candidate.sentence:
                labels[key] = ""
    return sealed(labels)


def right_of(bench: Bench, exercise: str) -> Table:
    """Return a table without labels.

    Raises:
        ValueError: the solution itself loses a case.
    """
    first = next(iter(bench.functions(exercise).values()), None)
    right = bench.right(exercise)
    return Table({}, right, arguments_of(first), tuple(sorted(bench.words.get(exercise, ()))))
