"""How speed is measured: in turns, on one thread; and what is printed of it."""

import hashlib
import importlib.util
import threading
from types import ModuleType

import pytest

from autograder.tests.kernel import leave_out

pytestmark = [pytest.mark.long, pytest.mark.rest]


@pytest.fixture(name="speed")
def module_beside_gtsam():
    if importlib.util.find_spec("gtsam") is None:
        leave_out("gtsam is not installed; nothing is measured beside it")
    from benchmarks import speed

    return speed


def sides(speed: ModuleType, seconds: dict[str, list[float]]) -> tuple[list, list[str]]:
    """Sides whose runs return these times, and the names of those that have run."""
    turns: list[str] = []

    def side(name: str):
        left = iter(seconds[name])
        return speed.Side(name, lambda: (turns.append(name), next(left))[1], None)

    return [side(name) for name in seconds], turns


@pytest.mark.parametrize(
    ("seconds", "turns", "middles"),
    [
        ({"a": [1.0, 9.0, 2.0], "b": [4.0, 3.0, 5.0]}, "ababab", [(2.0, 3), (4.0, 3)]),
        ({"a": [1.0, 1.0, 3.0], "long": [20.1]}, ["a", "long", "a", "a"], [(1.0, 3), (20.1, 1)]),
    ],
)
def test_sides_take_turns_and_the_median_counts_but_a_long_run_stands_alone(
    speed, seconds, turns, middles
):
    given, done = sides(speed, seconds)
    spent = speed.in_turns(given, lambda side: speed.Spent(side.run(), side.name), runs=3)
    assert done == list(turns)
    assert [(own.seconds, own.runs) for own in spent.values()] == middles
    assert [own.answer for own in spent.values()] == list(seconds)


def test_two_threads_are_noticed(speed):
    data = bytes(50_000_000)

    def run() -> None:
        other = threading.Thread(target=hashlib.sha256, args=(data,))
        other.start()
        other.join()

    with pytest.raises(RuntimeError, match="one"):
        speed.spend(speed.Side("two threads", run, None))


def test_a_ratio_is_other_by_ours_and_seconds_are_short_and_say_how_often(speed):
    seconds = {speed.OURS: 2.0, "GTSAM COLAMD": 3.0, "GTSAM METIS": 4.0}
    assert speed.ratio({side: speed.Spent(own, None) for side, own in seconds.items()}) == 1.5
    assert str(speed.Spent(0.0412, None, runs=5)) == "41.2 ms"
    assert str(speed.Spent(3.4, None)) == "3.40 s (once)"
