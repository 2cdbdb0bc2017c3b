"""Plain data crosses unchanged; nothing else crosses, in either direction."""

import struct
from typing import Any

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robust_slam_autograder.protocol import wire
from robust_slam_autograder.protocol.wire import Handle, WireError

from ..fuzz import values
from ..fuzz.running import calls


def export(function: object) -> Handle:
    return Handle("mine", 7)


def resolve(handle: Handle) -> Any:
    return handle


def crossed(value: object) -> Any:
    return wire.decode(wire.encode(value, export), resolve)


def widened(value: object) -> Any:
    return wire.decode(wire.encode(value, export), resolve, widen=True)


@settings(max_examples=25)
@given(st.integers(1, 60), st.sampled_from([list, tuple]))
def test_a_sender_refuses_what_its_reader_would(depth, kind):
    value: object = 1
    for _ in range(depth):
        value = kind([value])
    if depth <= wire.MAX_DEPTH:
        assert crossed(value) == value
    else:
        with pytest.raises(WireError, match="nested deeper"):
            wire.encode(value, export)


LARGE = [np.zeros(wire.MAX_MESSAGE // 8 + 1), [0] * (wire.MAX_ITEMS + 1)]


@pytest.mark.parametrize(
    "value", [*values.REFUSED, *LARGE], ids=lambda value: type(value).__name__
)
def test_nothing_else_crosses(value):
    with pytest.raises(WireError):
        wire.encode(value, export)


def test_subclasses_cross_as_what_they_extend():
    class Quiet(np.ndarray[Any, Any]):
        def __array_ufunc__(self, *args: object, **kwargs: object) -> bool:
            return True

    assert type(crossed(np.arange(3).view(Quiet))) is np.ndarray
    assert crossed(np.array([["a"], ["b"]])) == [["a"], ["b"]]
    assert type(crossed(np.longdouble(1))) is np.float64


def other(*args: object) -> Any:
    """What a method of a subclass answers: nothing of what the value holds."""
    return iter([9])


METHODS = ("__int__", "__float__", "__index__", "__iter__", "__getitem__", "__len__", "real")
METHODS += ("keys", "items", "copy", "__complex__", "__pos__", "__array__", "__str__")


@pytest.mark.parametrize(
    "value", ["a", 3, 2**70, 0.5, 1 + 2j, (1, 2), [1, 2], {"a": 1}, np.float64(0.5), np.int64(3)]
)
def test_a_subclass_crosses_as_its_base_sees_it(value):
    base = type(value)
    told = type("Told", (base,), dict.fromkeys(METHODS, other))(value)
    got = crossed([told])[0]
    assert type(got) is base and got == value
    if base is str:
        assert [type(key) for key in crossed({told: (told,)})] == [str]


def test_arrays_are_copies_that_can_be_written_to():
    got = crossed(np.arange(6).reshape(2, 3).T)
    got[0, 0] = 5
    assert got.tolist() == [[5, 3], [1, 4], [2, 5]]


@pytest.mark.parametrize("char", ["b", "B", "h", "H", "i", "I", "l", "L", "q", "Q"])
def test_differences_of_a_students_integers_do_not_wrap(char):
    """What falls does not seem to rise."""
    least, most = np.iinfo(char).min, min(np.iinfo(char).max, 2**62)
    for before, after in ((3, 2), (most, most - 1)):
        array, scalar = widened([np.array([before, after], char), np.dtype(char).type(after)])
        assert array.dtype == np.int64 and type(scalar) is np.int64
        assert np.diff(array).tolist() == [-1] and scalar - before == -1
    assert widened(np.array([least, 0], char)).tolist() == [least, 0]
    assert widened(np.zeros((0, 2), char)).dtype == np.int64


def test_integers_that_no_signed_type_holds_are_read_as_double():
    array, scalar = widened([np.array([2**63, 2**64 - 1, 0], np.uint64), np.uint64(2**63)])
    assert array.dtype == np.float64 and array.tolist() == [2.0**63, 2.0**64, 0.0]
    assert type(scalar) is np.float64 and np.diff(array)[1] < 0


def test_other_numbers_keep_their_kind():
    half, single, truth = widened([np.float16(0.1), np.complex64(1j), np.array([True])])
    assert (half.dtype, single.dtype, truth.dtype) == (np.float64, np.complex128, np.bool)
    assert half == float(np.float16(0.1))


def extension(code: int, body: bytes) -> bytes:
    return bytes(msgpack.packb(msgpack.ExtType(code, body)))


@pytest.mark.parametrize(
    "data",
    [
        b"\xdd\x00\x0f\x00\x00" * 1000,
        b"\x91" * 900 + b"\xc0",
        b"\xdc\xff\xff" + b"\xdc\x00\x20" * 5 + b"\xc0" * 10,
        extension(1, msgpack.packb(["O", [1], b"12345678"])),
        extension(1, msgpack.packb(["d", [2**40, 2**40], b""])),
        extension(1, msgpack.packb(["d", [-1], b""])),
        extension(1, msgpack.packb(["d", [True], bytes(8)])),
        extension(1, msgpack.packb(["d", [1] * 40, bytes(8)])),
        extension(1, msgpack.packb([["d"], [1], bytes(8)])),
        extension(2, msgpack.packb(["d", [1], bytes(8)])),
        extension(3, msgpack.packb([1, 2])),
        extension(3, b""),
        b"\x92\xc0" + extension(3, b""),
        b"\x92" + extension(3, b"") * 2,
        b"\x81" + extension(3, b"") + b"\xc0",
        extension(4, msgpack.packb(["1", "2"])),
        extension(4, msgpack.packb([1.0])),
        extension(5, msgpack.packb(["theirs", 1])),
        extension(5, msgpack.packb(["mine", True])),
        extension(5, msgpack.packb(["name", "x" * 100])),
        extension(6, bytes(10_000)),
        extension(99, b""),
        struct.pack(">BBI", 0xD6, 0xFF, 0),
    ],
    ids=range(23),
)
def test_hand_written_bytes_are_refused(data):
    with pytest.raises(WireError):
        wire.decode(data, resolve)


@pytest.mark.parametrize("many", [b"\x90", b"\x80", b"\xc7\x00\x03", b"\xc0"], ids=repr)
def test_a_message_of_many_items_is_refused_at_a_bounded_cost(many, monkeypatch):
    monkeypatch.setattr(wire, "MAX_ITEMS", 10_000)
    number = 9_000
    data = b"\x93" + (b"\xdd" + struct.pack(">I", number) + many * number) * 3

    def refuse() -> None:
        with pytest.raises(WireError):
            wire.decode(data, resolve)

    assert calls(refuse) <= 4 * wire.MAX_ITEMS


def test_colliding_keys_are_few():
    keys = [complex(-1000003 * n, n) for n in range(2000)]
    body = b"".join(extension(4, msgpack.packb([k.real, k.imag])) + b"\xc0" for k in keys)
    with pytest.raises(WireError, match="key"):
        wire.decode(b"\xde" + struct.pack(">H", len(keys)) + body, resolve)
    with pytest.raises(WireError, match="too many"):
        wire.encode(dict.fromkeys(range(wire.MAX_ITEMS // wire.KEY_COST + 1)), export)
