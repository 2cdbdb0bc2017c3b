"""A long batch shows in a log that it goes on."""

import io
import itertools
from types import SimpleNamespace

import pytest
from robust_slam_autograder.grading import progress


@pytest.mark.parametrize(
    ("seconds", "lines"),
    [
        (0.01, []),
        (4.0, ["3 of 7 graded", "6 of 7 graded"]),
        (11.0, [f"{n} of 7 graded" for n in range(1, 8)]),
    ],
)
def test_a_line_comes_when_the_last_is_long_ago(seconds, lines, monkeypatch, capsys):
    clock = itertools.count(0.0, seconds)
    monkeypatch.setattr(progress, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    step = progress.lines(7)
    for _ in range(7):
        step()
    assert capsys.readouterr().err.splitlines() == lines


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_has_a_bar_and_a_log_has_none(monkeypatch):
    for stream, shows in ((Terminal(), True), (io.StringIO(), False)):
        monkeypatch.setattr(progress.sys, "stderr", stream)
        with progress.shown(2) as step:
            step()
            step()
        assert ("2/2" in stream.getvalue()) == shows
