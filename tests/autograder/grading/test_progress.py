"""A long batch shows in a log that it goes on."""

from __future__ import annotations

import io
from collections.abc import Iterator

import pytest
from robust_slam_autograder.grading import progress


def ticks(seconds: float) -> Iterator[float]:
    now = 0.0
    while True:
        yield now
        now += seconds


@pytest.mark.parametrize(
    ("seconds", "lines"),
    [
        (0.01, []),
        (4.0, ["3 of 7 graded", "6 of 7 graded"]),
        (11.0, [f"{n} of 7 graded" for n in range(1, 8)]),
    ],
)
def test_a_line_comes_when_the_last_is_long_ago(seconds: float, lines: list[str]) -> None:
    log, clock = io.StringIO(), ticks(seconds)
    step = progress.lines(7, log, lambda: next(clock))
    for _ in range(7):
        step()
    assert log.getvalue().splitlines() == lines


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_has_a_bar_and_a_log_has_none(monkeypatch: pytest.MonkeyPatch) -> None:
    for stream, shows in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(progress.sys, "stderr", stream)
        with progress.shown(2) as step:
            step()
            step()
        assert ("2/2" in stream.getvalue()) == shows
