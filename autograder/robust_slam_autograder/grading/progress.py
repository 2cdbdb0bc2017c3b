"""How far a batch is: a bar on a terminal, now and then a plain line in a log."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator
from typing import TextIO

SECONDS_BETWEEN_LINES = 10.0


@contextlib.contextmanager
def shown(total: int) -> Iterator[Callable[[], None]]:
    """Show progress on standard error; yields the function to call after each submission."""
    if not sys.stderr.isatty():
        yield Lines(total, sys.stderr).step
        return
    from tqdm import tqdm  # of the extra `grading`

    with tqdm(total=total, unit="submission") as bar:

        def step() -> None:
            bar.update()

        yield step


class Lines:
    """A line such as ``120 of 500 graded`` every ten seconds at most.

    A batch that is quicker writes none: its table says it all.
    """

    def __init__(
        self, total: int, file: TextIO, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._total = total
        self._file = file
        self._clock = clock
        self._done = 0
        self._last = clock()

    def step(self) -> None:
        """Count one more submission, and tell if the last line is long ago."""
        self._done += 1
        now = self._clock()
        if now - self._last >= SECONDS_BETWEEN_LINES:
            self._last = now
            print(f"{self._done} of {self._total} graded", file=self._file, flush=True)
