"""How speed is measured: in turns, on one thread, with an end; and what is printed of it."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import threading
from types import ModuleType

import numpy as np
import pytest
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.graphs.generate import manhattan

from benchmarks.speed import clock
from benchmarks.speed.clock import Figure, Side, Spent, in_turns, spend, spend_apart
from tests.conftest import leave_out


def need(*names: str) -> None:
    """Leave the test out where one of the packages is missing."""
    for name in names:
        if importlib.util.find_spec(name) is None:
            leave_out(f"{name} is not installed; nothing is measured beside it")


@pytest.fixture(name="figures")
def all_figures() -> ModuleType:
    need("gtsam")
    from benchmarks.speed import __main__

    return __main__


class TestTheClock:
    def sides(self, seconds: dict[str, list[float]]) -> tuple[list[Side], list[str]]:
        """Sides whose runs return these times, and the names of those that have run."""
        turns: list[str] = []

        def side(name: str) -> Side:
            left = iter(seconds[name])
            return Side(name, lambda: (turns.append(name), next(left))[1])

        return [side(name) for name in seconds], turns

    def told(self, side: Side) -> Spent:
        return Spent(side.run(), side.name)

    def test_sides_take_turns_and_the_median_counts(self) -> None:
        sides, turns = self.sides({"a": [1.0, 9.0, 2.0], "b": [4.0, 3.0, 5.0]})
        spent = in_turns(sides, self.told, runs=3)
        assert turns == ["a", "b"] * 3
        assert spent == {"a": Spent(2.0, "a", 3), "b": Spent(4.0, "b", 3)}

    def test_a_long_run_stands_alone(self) -> None:
        sides, turns = self.sides({"a": [1.0, 1.0], "b": [clock.LONG + 0.1]})
        assert [spent.runs for spent in in_turns(sides, self.told, runs=2).values()] == [2, 1]
        assert turns == ["a", "b", "a"]

    def test_two_threads_are_noticed(self) -> None:
        data = bytes(50_000_000)

        def run() -> None:
            other = threading.Thread(target=hashlib.sha256, args=(data,))
            other.start()
            other.join()

        with pytest.raises(RuntimeError, match="one"):
            spend(Side("two threads", run))

    def test_a_run_apart_gives_its_answer_and_time(self) -> None:
        spent = spend_apart(Side("sum", lambda: sum(range(1_000_000))))
        assert spent.answer == 499999500000
        assert 0.0 < spent.seconds < 5.0 and not spent.stopped

    def test_a_run_apart_is_stopped(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(clock, "LIMIT", 1)

        def forever() -> None:
            while True:
                pass

        spent = spend_apart(Side("forever", forever))
        assert spent.stopped and spent.seconds == 1.0 and spent.answer is None

    def test_a_failure_apart_is_told(self, capfd: pytest.CaptureFixture[str]) -> None:
        with pytest.raises(RuntimeError, match="halves fails: see the error above"):
            spend_apart(Side("halves", lambda: 1 / 0))
        assert "ZeroDivisionError: division by zero" in capfd.readouterr().err


class TestWhatIsPrinted:
    def test_a_ratio_is_other_by_ours_and_has_a_line_of_its_own(self, figures: ModuleType) -> None:
        ours = {"numpy": Spent(2.0, None), "compiled": Spent(1.0, None)}
        figure = Figure(Spent(3.0, None), ours, "seconds")
        assert figures.line("gn/intel", figure).splitlines() == [
            "  seconds",
            "ratio gn/intel 1.50 numpy 3.00 compiled",
        ]

    def test_a_run_that_was_stopped_gives_a_bound(self) -> None:
        stopped = Spent(120.0, None, stopped=True)
        assert Figure(stopped, {"numpy": Spent(2.0, None)}, "").ratios == "> 60.00 numpy"
        assert str(stopped) == "stopped after 120 s"

    def test_seconds_are_short_and_say_how_often(self) -> None:
        assert str(Spent(0.0412, None, runs=5)) == "41.2 ms"
        assert str(Spent(3.4, None)) == "3.40 s (once)"


class TestTheFigures:
    def test_a_name_chooses_itself_and_what_is_below(self, figures: ModuleType) -> None:
        names = ["gn/intel", "gnc/intel/10", "gnc/intel/30", "gnc/CSAIL/10"]
        assert figures.chosen(names, []) == names
        assert figures.chosen(names, ["gn"]) == ["gn/intel"]
        assert figures.chosen(names, ["gnc/intel"]) == ["gnc/intel/10", "gnc/intel/30"]

    def test_an_unknown_name_is_refused(self, figures: ModuleType) -> None:
        with pytest.raises(ValueError, match="no figure gn/inte;"):
            figures.chosen(["gn/intel"], ["gn/inte"])


def test_each_way_is_measured_on_its_own_and_the_choice_is_left_as_it_was(monkeypatch) -> None:
    need("numba")
    from benchmarks.speed import ways

    monkeypatch.delenv(ways.COMPILED_FROM, raising=False)
    graph, _ = manhattan(20, np.random.default_rng(0), closures=5)
    sides = ways.our_sides(lambda: NormalEquations(graph).compiled, lambda found: found)
    assert {side.name: side.run() for side in sides} == {"numpy": False, "compiled": True}
    assert ways.COMPILED_FROM not in os.environ


def test_without_numba_one_way_is_measured(monkeypatch) -> None:
    from benchmarks.speed import ways

    monkeypatch.setattr(ways, "has_numba", lambda: False)
    assert [side.name for side in ways.our_sides(int, int)] == ["numpy"]
    assert "not installed" in ways.measure()
