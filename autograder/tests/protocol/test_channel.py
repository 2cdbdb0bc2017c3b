"""Calls go both ways over a pair of pipes, and end in time."""

import os
import struct
import threading
from collections.abc import Callable
from typing import Any

import msgpack
import numpy as np
import pytest
from robust_slam_autograder.executor.budget import WALL_FACTOR, Meter
from robust_slam_autograder.protocol.channel import (
    Channel,
    ChannelClosed,
    DeadlineExceeded,
    RaisedThere,
)
from robust_slam_autograder.protocol.wire import Handle, WireError


class Pair:
    """A channel, and the functions that the other end offers by name."""

    def __init__(self, named: dict[str, Callable[..., Any]] | None = None) -> None:
        their_read, our_write = os.pipe()
        our_read, their_write = os.pipe()
        self.ends = [their_read, our_write, our_read, their_write]
        self.near = Channel(our_read, our_write)
        self.raw = their_write
        if named is not None:
            far = Channel(their_read, their_write, named=named, tells=BaseException)
            threading.Thread(target=self._serve, args=(far,), daemon=True).start()

    def _serve(self, far: Channel) -> None:
        try:
            far.serve()
        except ChannelClosed:
            os.close(self.ends.pop())

    def call(self, name: str, *args: Any, **kwargs: Any) -> Any:
        return self.near.call(Handle("name", name), args, kwargs)

    def close(self) -> None:
        os.close(self.ends.pop(1))


@pytest.fixture
def pair():
    made: list[Pair] = []

    def make(**named: Callable[..., Any]) -> Pair:
        made.append(Pair(named or None))
        return made[-1]

    yield make
    for each in made:
        each.close()


def test_a_call_returns_what_the_function_returns(pair):
    got = pair(add=lambda a, b: a + b).call("add", np.arange(3), b=1.5)
    assert got.tolist() == [1.5, 2.5, 3.5]


def test_functions_are_called_back(pair):
    ends = pair(apply=lambda f, x: f(f(x)), make=lambda k: lambda x: k * x)
    assert ends.call("apply", lambda x: 3 * x, 2) == 18
    triple = ends.call("make", 3)
    assert triple(5) == 15
    assert ends.call("apply", triple, 2) == 18


def test_a_function_comes_home_as_itself(pair):
    def mine(x: int) -> int:
        return x

    assert pair(same=lambda f: f).call("same", mine) is mine


@pytest.mark.parametrize("error", [ValueError("why"), SystemExit(3), KeyboardInterrupt()])
def test_whatever_a_function_raises_is_told(pair, error):
    def fail() -> None:
        raise error

    with pytest.raises(RaisedThere) as caught:
        pair(fail=fail).call("fail")
    assert caught.value.types[0] == type(error).__name__
    assert caught.value.message == str(error)


def test_an_exception_that_cannot_tell_itself_is_told(pair):
    class Mute(Exception):
        def __str__(self) -> str:
            raise SystemExit

    def fail() -> None:
        raise Mute

    with pytest.raises(RaisedThere) as caught:
        pair(fail=fail).call("fail")
    assert caught.value.types == ("Mute", "Exception", "BaseException")


def test_what_cannot_cross_is_an_error_and_the_channel_lives(pair):
    ends = pair(give=lambda: {1, 2}, same=lambda x: x)
    with pytest.raises(RaisedThere, match="cannot cross"):
        ends.call("give")
    with pytest.raises(WireError, match="cannot cross"):
        ends.call("same", {1, 2})
    assert ends.call("same", 1) == 1


def test_calls_nested_without_end_are_an_error(pair):
    ends = pair(again=lambda f: f(f))

    def near(f: Callable[..., Any]) -> Any:
        return ends.call("again", near)

    with pytest.raises(RaisedThere, match="nested too deeply"):
        ends.call("again", near)


def test_threads_of_the_other_side_take_turns(pair):
    def at_once(f: Callable[[int], int]) -> list[int]:
        got: list[int] = []
        threads = [threading.Thread(target=lambda n=n: got.append(f(n))) for n in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return sorted(got)

    assert pair(at_once=at_once).call("at_once", lambda n: n * n) == [n * n for n in range(8)]


def test_a_deadline_ends_the_wait_for_an_answer(pair):
    over = threading.Event()
    ends = pair(wait=lambda: over.wait(60))
    ends.near.patience = Meter().start(0.1 / WALL_FACTOR).left
    with pytest.raises(DeadlineExceeded):
        ends.call("wait")
    over.set()


def test_a_deadline_ends_writing_to_one_who_does_not_read(pair):
    ends = pair()
    ends.near.patience = Meter().start(0.1 / WALL_FACTOR).left
    with pytest.raises(DeadlineExceeded):
        ends.call("any", np.zeros(10**6))


def frame(value: object) -> bytes:
    data = msgpack.packb(value)
    return struct.pack(">I", len(data)) + bytes(data)


@pytest.mark.parametrize(
    "data",
    [
        struct.pack(">I", 2**32 - 1),
        struct.pack(">I", 0),
        struct.pack(">I", 3) + b"abc",
        frame({"return": 1}),
        frame(["return"]),
        frame(["return", 99, 0]),
        frame(["return", True, 0]),
        frame(["return", 1, 0, 0]),
        frame([b"return", 1, 0]),
        frame([["return"], 1, 0]),
        frame(["raise", 1, "ValueError"]),
        frame(["jump", 1, 0]),
        frame(["call", 1, ["name"], [], {}]),
        frame(["call", 1, ["name", "f"], [], {1: 2}]),
        frame(["call", 1, ["name", "f"], {}, {}]),
    ],
    ids=range(15),
)
def test_a_message_of_another_shape_ends_the_conversation(pair, data):
    ends = pair()
    ends.near.patience = Meter().start(5).left
    os.write(ends.raw, data)
    with pytest.raises(ChannelClosed):
        ends.call("any")


def test_a_call_of_an_unknown_function_is_told_and_the_answer_still_comes(pair):
    ends = pair()
    ends.near.patience = Meter().start(5).left
    for target in (["name", "f"], ["yours", 3], ["yours", -1], ["yours", [1]], [[], 1]):
        os.write(ends.raw, frame(["call", 1, target, [], {}]))
    os.write(ends.raw, frame(["return", 1, "answer"]))
    assert ends.call("any") == "answer"


def test_an_error_of_strange_types_is_an_error_still(pair):
    ends = pair()
    told = {"types": [["x"] * 9, 7] * 50, "message": {"a": 1}, "line": "no"}
    os.write(ends.raw, frame(["raise", 1, told]))
    with pytest.raises(RaisedThere) as caught:
        ends.call("any")
    assert caught.value.types == ("(list)", "(int)") * 10
    assert caught.value.message == "(dict)" and caught.value.line is None
