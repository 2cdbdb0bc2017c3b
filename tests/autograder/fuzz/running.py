"""Runs a property on many inputs, and ends one that hangs."""

from __future__ import annotations

import contextlib
import functools
import signal
import sys
import tracemalloc
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

HANG_SECONDS = 20
"""Of processor time for one input; the slowest takes about one."""
SEEDS = st.integers(0, 2**32 - 1)
VARIANTS = 40
"""Inputs made from one seed."""


class Hang(BaseException):
    """An input that keeps its reader busy. Not an Exception: the reader must not swallow it."""


def fuzzed(
    examples: int, *strategies: st.SearchStrategy[Any]
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Test a property on this many inputs, on more in a profile that has more."""

    def decorate(law: Callable[..., None]) -> Callable[..., None]:
        @functools.wraps(law)
        def once(*args: Any, **drawn: Any) -> None:
            with no_hang():
                law(*args, **drawn)

        many = settings(max_examples=examples * settings.default.max_examples // 100)
        return many(given(*strategies)(once))

    return decorate


@contextlib.contextmanager
def no_hang() -> Iterator[None]:
    """Raise Hang where the block takes too much processor time."""

    def expire(number: int, frame: FrameType | None) -> None:
        raise Hang

    before = signal.signal(signal.SIGVTALRM, expire)
    signal.setitimer(signal.ITIMER_VIRTUAL, HANG_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def peak_bytes(work: Callable[[], object]) -> int:
    """The most memory that was in use at once."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def calls(work: Callable[[], object]) -> int:
    """The number of functions called: a measure of time that no busy machine changes."""
    count = 0

    def note(frame: FrameType, event: str, argument: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(before)
    return count
