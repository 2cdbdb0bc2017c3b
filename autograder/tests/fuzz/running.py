"""Runs a property on many inputs, and ends one that hangs; damages bytes."""

import contextlib
import functools
import signal
import sys
import tracemalloc
from collections.abc import Callable, Iterator, Sequence
from types import FrameType
from typing import Any

import numpy as np
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


def variants(data: bytes, tokens: Sequence[bytes], seed: int) -> Iterator[bytes]:
    """Give the bytes, then with a few edits, in many ways; ``tokens`` are what may be put in."""
    yield data
    rng = np.random.default_rng(seed)
    for _ in range(VARIANTS):
        damaged = data
        for _ in range(rng.integers(1, 5)):
            damaged = _edited(damaged, tokens, rng)
        yield damaged


def _edited(data: bytes, tokens: Sequence[bytes], rng: np.random.Generator) -> bytes:
    start, end = sorted(rng.integers(0, len(data) + 1, size=2).tolist())
    head, part, rest = data[:start], data[start:end], data[end:]
    match rng.integers(6):
        case 0:
            return head + rest
        case 1:
            return head
        case 2:
            return head + part * int(rng.integers(2, 5)) + rest
        case 3:
            return head + tokens[rng.integers(len(tokens))] + part + rest
        case _:
            byte = bytes([rng.integers(256)])
            return head + (byte + data[start + 1 :] if part else byte)
