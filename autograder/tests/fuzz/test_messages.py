"""Whatever bytes arrive, the decoder gives plain data or a WireError, at a bounded cost."""

import struct
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import strategies as st
from robust_slam_autograder.protocol import wire
from robust_slam_autograder.protocol.wire import WireError

from . import messages
from .messages import TUPLE, extension
from .running import SEEDS, calls, fuzzed, no_hang, peak_bytes, variants
from .values import PLAIN, STRANGE, Foreign, export, nested, plain_cost, same

pytestmark = pytest.mark.rest


def decoded(data: bytes) -> Any:
    return wire.decode(data, Foreign)


def read(data: bytes) -> Any:
    """What was read, or the refusal."""
    try:
        return decoded(data)
    except WireError as error:
        return error


@fuzzed(300, PLAIN)
def test_plain_data_cross_bit_by_bit(value):
    assert same(value, decoded(wire.encode(value, export)))


@fuzzed(100, nested(PLAIN | STRANGE))
def test_what_is_not_plain_is_refused_in_a_sentence(value):
    try:
        data = wire.encode(value, export)
    except WireError as error:
        assert str(error)
    else:
        plain_cost(decoded(data))


def check(data: bytes) -> None:
    got = read(data)
    if isinstance(got, WireError):
        assert str(got)
        return
    assert plain_cost(got) <= wire.MAX_ITEMS
    assert same(got, decoded(wire.encode(got, export)))


@fuzzed(500, messages.HOSTILE)
def test_any_bytes_are_plain_data_or_refused(data):
    """500 messages, of which the nested ones take long to draw."""
    check(data)


@fuzzed(250, messages.VALID | messages.HAND_WRITTEN, SEEDS)
def test_damaged_messages_are_plain_data_or_refused(valid, seed):
    for data in variants(valid, messages.TOKENS, seed):
        check(data)


@fuzzed(100, messages.HOSTILE)
def test_memory_and_work_are_bounded_by_the_messages_length(data):
    assert calls(lambda: read(data)) <= 100 + 8 * len(data)
    assert peak_bytes(lambda: read(data)) <= 64_000 + 160 * len(data)


@fuzzed(40, st.lists(messages.HAND_WRITTEN, max_size=5))
def test_a_message_with_more_behind_it_is_refused(parts):
    data = wire.encode(1, export) + b"".join(parts)
    assert isinstance(read(data), WireError) == any(parts)


BIG = wire.MAX_MESSAGE - 100
MANY = 90_000
CLAIMED = struct.pack(">I", MANY)


def array_of(size: int) -> bytes:
    return extension(1, msgpack.packb(["B", [size], bytes(size)]))


def in_extensions(data: bytes, levels: int) -> bytes:
    """A tuple that holds its items within its extension, in another such tuple, and so on."""
    for _ in range(levels):
        data = extension(TUPLE, b"\x91" + data)
    return data


HEAVY = {
    "an array in nested tuples": lambda: (b"\x92" + extension(TUPLE, b"")) * 20 + array_of(BIG),
    "an array in nested extensions": lambda: in_extensions(array_of(BIG // 2), 20),
    "claims in each other": lambda: (b"\xdd" + CLAIMED) * 1000 + bytes(MANY - 6000),
    "claimed dicts in each other": lambda: b"\xdf%b\xc0" % CLAIMED * 1000 + bytes(MANY - 6000),
    "empty dicts": lambda: b"\xdd" + CLAIMED + b"\x80" * MANY,
    "short texts": lambda: b"\xdd" + CLAIMED + b"\xa2ab" * MANY,
    "empty arrays": lambda: b"\xdd" + CLAIMED + extension(1, b"\x93\xa1d\x91\x00\xc4\x00") * MANY,
    "wide letters": lambda: struct.pack(">BI", 0xDB, BIG) + "😀".encode() + b"a" * (BIG - 4),
    "a dict of lists": lambda: b"\xdf" + CLAIMED + b"\xcd\x01\x01\x90" * MANY,
}


@pytest.mark.parametrize("name", HEAVY)
def test_the_heaviest_messages_take_few_times_their_length(name, monkeypatch):
    monkeypatch.setattr(wire, "MAX_ITEMS", 100_000)
    data = HEAVY[name]()
    with no_hang():
        assert peak_bytes(lambda: read(data)) <= 5.1 * len(data) + 100_000_000


@pytest.mark.parametrize("size", [1, 2, 30, 1000])
def test_keys_that_collide_are_compared_a_bounded_number_of_times(size):
    parts = [msgpack.packb(float(n)) for n in range(size - 1)]
    head = b"\xdc" + struct.pack(">H", size + 1) + extension(TUPLE, b"") + b"".join(parts)

    def accepted(number: int) -> bool:
        multiples = (n * (2**61 - 1) for n in range(1, number + 1))
        keys = (head + wire.encode(multiple, export) for multiple in multiples)
        data = b"\xdf" + struct.pack(">I", number) + b"".join(key + b"\xc0" for key in keys)
        return isinstance(read(data), dict)

    numbers = [2**power for power in range(14)]
    most = max(number for number in numbers if accepted(number))
    assert most >= 1 and most**2 * size / 2 <= 50_000_000


@pytest.mark.parametrize("shape", [(0, 2**40), (2**40, 0), (2**62, 0, 2**62), (0, 2**63)])
def test_an_empty_array_is_not_wide(shape):
    data = extension(1, msgpack.packb(["d", shape, b""]))
    assert isinstance(read(data), WireError)
    assert decoded(wire.encode(np.zeros((0, 3, 1000)), export)).shape == (0, 3, 1000)
