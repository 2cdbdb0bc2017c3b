"""Whatever the other side writes into the pipe or leaves there, a call ends in time."""

import os
import struct

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
from robust_slam_autograder.protocol.wire import Handle

ANY = Handle("name", "any")


@pytest.fixture
def ends():
    """A channel, and where its other side, which reads nothing, may write."""
    their_read, our_write = os.pipe()
    our_read, their_write = os.pipe()
    near = Channel(our_read, our_write)
    near.patience = Meter().start(5).left
    yield near, their_write
    for end in (their_read, our_write, our_read, their_write):
        os.close(end)


def test_a_deadline_ends_writing_to_one_who_does_not_read(ends):
    near, _ = ends
    near.patience = Meter().start(0.1 / WALL_FACTOR).left
    with pytest.raises(DeadlineExceeded):
        near.call(ANY, (np.zeros(10**6),), {})


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
def test_a_message_of_another_shape_ends_the_conversation(ends, data):
    near, raw = ends
    os.write(raw, data)
    with pytest.raises(ChannelClosed):
        near.call(ANY, (), {})


def test_a_call_of_an_unknown_function_is_told_and_the_answer_still_comes(ends):
    near, raw = ends
    for target in (["name", "f"], ["yours", 3], ["yours", -1], ["yours", [1]], [[], 1]):
        os.write(raw, frame(["call", 1, target, [], {}]))
    os.write(raw, frame(["return", 1, "answer"]))
    assert near.call(ANY, (), {}) == "answer"


def test_an_error_of_strange_types_is_an_error_still(ends):
    near, raw = ends
    told = {"types": [["x"] * 9, 7] * 50, "message": {"a": 1}, "line": "no"}
    os.write(raw, frame(["raise", 1, told]))
    with pytest.raises(RaisedThere) as caught:
        near.call(ANY, (), {})
    assert caught.value.types == ("(list)", "(int)") * 10
    assert caught.value.message == "(dict)" and caught.value.line is None
