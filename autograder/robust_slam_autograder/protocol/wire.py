"""Plain data as bytes, and nothing but plain data back.

Numbers, strings, booleans, None, arrays, lists, tuples, dicts and callables
(as handles) cross between the trusted and the untrusted process. The bytes are
MessagePack; arrays, complex numbers and handles are its extension types, and a
tuple is a list whose first item is an extension that marks it. Everything that
arrives is checked before anyone sees it: the other side may have written the
bytes by hand. What a message may cost to read (items, keys, depth, bytes) is
bounded, and a sender refuses what its reader would. The bytes of arrays count as
they will be when every number is widened, before any is.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NoReturn, cast

import msgpack
import numpy as np

MAX_MESSAGE = 32 * 1024 * 1024
MAX_DEPTH = 24
MAX_ITEMS = 1_000_000
"""What one message may cost: 1 an item, and the following."""
EXTENSION_COST = 10
KEY_COST = 100
"""A key, and each part of one: somebody may have chosen them so that all of them collide."""
MAX_DIMENSIONS = 8
MAX_INTEGER_BYTES = 512
MAX_PAIR_BYTES = 64
"""A complex number or a handle."""

_ARRAY, _SCALAR, _TUPLE, _COMPLEX, _HANDLE, _INTEGER = range(1, 7)
_DTYPES = frozenset("?bBhHiIlLqQefdFD")
_DOUBLE = {"e": "d", "f": "d", "F": "D"}
_WIDE_SIZE = {"?": 1, "D": 16, "F": 16}
"""Bytes of a widened number; of all other kinds 8."""
_PLAIN = frozenset({bool, int, float, str, type(None), np.float64})
_FEW, _SMALL = 20, 10_000
_LITTLE = {char: np.dtype(char).newbyteorder("<") for char in _DTYPES}
_MARK = object()
"""Stands at the head of a list that is a tuple. An extension that held the items would be
copied once for each level that it is nested."""


class WireError(Exception):
    """A value cannot cross, or bytes that arrived are not plain data; says why in one sentence."""


@dataclass(frozen=True)
class Handle:
    """A callable on the wire: whose it is ("mine" or "yours" of the sender, or "name"), which."""

    owner: str
    key: int | str


Export = Callable[[Callable[..., Any]], Handle]
Import = Callable[[Handle], Callable[..., Any]]


def encode(value: object, export: Export) -> bytes:
    """Turn plain data into bytes; ``export`` makes a handle for each callable in it.

    Raises:
        WireError: the value holds something that cannot cross, or is too large or too deep.
    """
    try:
        data = _pack(value, export)
    except WireError:
        raise
    except (ValueError, TypeError, OverflowError, RecursionError, UnicodeError) as error:
        raise WireError(f"a value cannot cross: {error}") from error
    if not _is_small(value):
        decode(data, lambda handle: _never)  # looked over, and no handle is of use
    return data


def _is_small(message: object) -> bool:
    """Tell whether a message is like most: a few numbers and small arrays.

    A solver may call a function that it was handed a hundred thousand times.
    """
    if type(message) is not list or len(message) > _FEW:
        return False
    for item in message:
        if type(item) is list:
            if len(item) > _FEW or not all(map(_is_plain, item)):
                return False
        elif item != {} if type(item) is dict else not _is_plain(item):
            return False
    return True


def _is_plain(value: object) -> bool:
    if type(value) is np.ndarray:
        return value.ndim <= MAX_DIMENSIONS and 0 < value.size <= _SMALL
    return type(value) in _PLAIN


def _never() -> NoReturn:
    raise NotImplementedError


def _pack(value: object, export: Export) -> bytes:
    packed: bytes = msgpack.packb(
        value, strict_types=True, default=lambda item: _as_known(item, export)
    )
    return packed


def _as_known(item: object, export: Export) -> object:
    """Say how MessagePack shall write what it does not know itself."""
    if isinstance(item, np.ndarray | np.generic) and not isinstance(item, str):
        return _pack_array(item)
    for base, plain in _BASES:
        if isinstance(item, base):
            return plain(item)
    if callable(item):
        handle = export(item)
        return msgpack.ExtType(_HANDLE, msgpack.packb([handle.owner, handle.key]))
    raise WireError(
        f"a value of type {type(item).__name__} cannot cross; "
        "numbers, strings, lists, tuples, dicts, arrays and functions can"
    )


def _pack_integer(value: int) -> object:
    value = int.__int__(value)
    if -(2**63) <= value < 2**64:
        return value
    size = value.bit_length() // 8 + 1
    if size > MAX_INTEGER_BYTES:
        raise WireError(f"an integer of more than {MAX_INTEGER_BYTES} bytes cannot cross")
    return msgpack.ExtType(_INTEGER, value.to_bytes(size, "little", signed=True))


def _pack_complex(value: complex) -> object:
    value = complex.__pos__(value)
    return msgpack.ExtType(_COMPLEX, msgpack.packb([value.real, value.imag]))


# strict_types sends subclasses here, which cross as what they extend. The methods are those of the
# base: an enumeration of words tells another text than its own, a list may iterate over others.
_BASES: tuple[tuple[type, Callable[[Any], object]], ...] = (
    (str, str.__str__),
    (tuple, lambda item: [msgpack.ExtType(_TUPLE, b""), *tuple.__getitem__(item, slice(None))]),
    (complex, _pack_complex),
    (int, _pack_integer),
    (float, float.__float__),
    (list, lambda item: list.__getitem__(item, slice(None))),
    (dict, lambda item: dict(dict.items(item))),
)


def _pack_array(item: np.ndarray[Any, Any] | np.generic) -> object:
    array = np.asarray(np.generic.__array__(item) if isinstance(item, np.generic) else item)
    if array.nbytes > MAX_MESSAGE:
        raise WireError(f"an array of {array.nbytes} bytes is larger than {MAX_MESSAGE}")
    if array.dtype.kind == "U":
        return array.tolist()
    if array.dtype.char in "gG":
        with np.errstate(all="ignore"):
            array = array.astype(np.complex128 if array.dtype.char == "G" else np.float64)
    if array.dtype.char not in _DTYPES:
        raise WireError(f"an array of dtype {array.dtype} cannot cross; numbers and booleans can")
    code = _SCALAR if isinstance(item, np.generic) else _ARRAY
    char = array.dtype.char
    if array.dtype != _LITTLE[char]:
        array = array.astype(_LITTLE[char])
    body = msgpack.packb([char, array.shape, array.tobytes()])
    return msgpack.ExtType(code, body)


def decode(data: bytes, resolve: Import, *, widen: bool = False) -> Any:  # noqa: ANN401
    """Turn bytes into plain data.

    Args:
        data: the message.
        resolve: turns each handle into a callable.
        widen: read single and half precision as double, and integers as int64. Beside a
            number of few digits numpy rounds Python's own, and so
            ``np.isclose(np.float16(0.30001), 0.3)`` holds at every tolerance; a difference
            of two short or unsigned integers wraps, and ``np.diff(np.uint8([3, 2]))`` is 255.
            What int64 cannot hold is read as double: 16 digits, and no sign that turns.

    Raises:
        WireError: the bytes are not a message of plain data within the limits.
    """
    if len(data) > MAX_MESSAGE:
        raise WireError(f"a value of {len(data)} bytes is larger than {MAX_MESSAGE}")
    try:
        value = _Reader(resolve, widen=widen).unpack(data)
        _refuse_foreign(value, 0)
    except WireError:
        raise
    except Exception as error:  # MessagePack raises many types on bytes written by hand
        raise WireError(f"bytes that are no message ({type(error).__name__})") from error
    return value


class _Reader:
    """Reads one message and counts what it costs."""

    def __init__(self, resolve: Import, *, widen: bool) -> None:
        self._resolve = resolve
        self._widen = widen
        self._left = MAX_ITEMS
        self._bytes = MAX_MESSAGE

    def unpack(self, data: bytes) -> Any:  # noqa: ANN401
        # A length that the bytes cannot fill would reserve memory for nothing.
        most = min(MAX_ITEMS, len(data))
        return msgpack.unpackb(
            data,
            strict_map_key=False,
            max_array_len=most,
            max_map_len=most,
            list_hook=self._list,
            object_pairs_hook=self._dict,
            ext_hook=self._extension,
        )

    def _pay(self, cost: int) -> None:
        self._left -= cost
        if self._left < 0:
            raise WireError("a message of too many items")

    def _list(self, items: list[Any]) -> list[Any] | tuple[Any, ...]:
        self._pay(1 + len(items))
        return tuple(items[1:]) if items and items[0] is _MARK else items

    def _dict(self, pairs: list[tuple[Any, Any]]) -> dict[Any, Any]:
        self._pay(1 + len(pairs))
        for key, _ in pairs:
            self._pay(KEY_COST * _parts_of_key(key, 0))
        return dict(pairs)

    def _extension(self, code: int, body: bytes) -> object:
        self._pay(EXTENSION_COST)
        if code == _TUPLE and not body:
            return _MARK
        if code == _ARRAY:
            return self._array(body)
        if code == _SCALAR:
            return _number(self._array(body))
        if code == _INTEGER and len(body) <= MAX_INTEGER_BYTES:
            return int.from_bytes(body, "little", signed=True)
        if code == _COMPLEX:
            return _complex(*_unpack_pair(body))
        if code == _HANDLE:
            return self._resolve(_handle(*_unpack_pair(body)))
        raise WireError(f"an unknown extension {code}")

    def _array(self, body: bytes) -> np.ndarray[Any, Any]:
        array = _unpack_array(body)
        self._bytes -= array.size * _WIDE_SIZE.get(array.dtype.char, 8)
        if self._bytes < 0:
            raise WireError(f"arrays of more than {MAX_MESSAGE} bytes in double precision")
        kind = _wide(array) if self._widen else array.dtype.newbyteorder("=")
        return array.astype(kind)


def _unpack_pair(body: bytes) -> tuple[object, object]:
    if len(body) > MAX_PAIR_BYTES:
        raise WireError("a complex number or a handle that is too long")
    first, second = msgpack.unpackb(body, max_array_len=2, max_map_len=0)
    return first, second


def _complex(real: object, imag: object) -> complex:
    if not isinstance(real, float) or not isinstance(imag, float):
        raise WireError("a complex number that is not made of two numbers")
    return complex(real, imag)


def _handle(owner: object, key: object) -> Handle:
    if owner not in ("mine", "yours", "name") or type(key) not in (int, str):
        raise WireError("a handle of an unknown kind")
    return Handle(str(owner), cast("int | str", key))


def _parts_of_key(key: object, depth: int) -> int:
    """Say how much work it is to compare a key with one of the same hash.

    Refused are keys whose hashes collide at will (complex numbers), and those without a hash.
    """
    if isinstance(key, tuple) and depth < MAX_DEPTH:
        return 1 + sum(_parts_of_key(part, depth + 1) for part in key)
    if isinstance(key, str):
        return 1 + len(key) // 64
    if isinstance(key, int):
        return 1 + key.bit_length() // 128
    if isinstance(key, np.complexfloating) or not (
        key is None or isinstance(key, float | np.generic)
    ):
        raise WireError("a dict with a key that is no number, string or tuple of them")
    return 1


def _unpack_array(body: bytes) -> np.ndarray[Any, Any]:
    """Return a view of the array that the bytes hold; nothing is copied."""
    char, shape, raw = msgpack.unpackb(body, max_array_len=MAX_DIMENSIONS)
    if char not in _DTYPES or not isinstance(shape, list) or not isinstance(raw, bytes):
        raise WireError("an array of an unknown type")
    if any(type(n) is not int or n < 0 for n in shape):
        raise WireError("an array of an impossible shape")
    dtype = _LITTLE[char]
    if math.prod(shape) * dtype.itemsize != len(raw):
        raise WireError("an array whose bytes do not fill its shape")
    # A sum over the empty side of (0, 2**40) would fill the memory.
    if math.prod(max(n, 1) for n in shape) * dtype.itemsize > MAX_MESSAGE:
        raise WireError("an empty array that is too wide")
    return np.frombuffer(raw, dtype=dtype).reshape(shape)


def _wide(array: np.ndarray[Any, Any]) -> np.dtype[Any]:
    """Choose the type to compute with for an array's own: it rounds and wraps no sooner."""
    if array.dtype.kind in "iu":
        fits = not array.size or int(array.max()) < 2**63
        return np.dtype(np.int64) if fits else np.dtype(np.float64)
    char: str = array.dtype.char
    return np.dtype(_DOUBLE.get(char, char))


def _number(array: np.ndarray[Any, Any]) -> object:
    if array.shape:
        raise WireError("a number that is an array")
    return array[()]


def _refuse_foreign(value: object, depth: int) -> None:
    """Refuse what MessagePack can carry and we do not: bytes, timestamps, deep nesting."""
    if depth > MAX_DEPTH:
        raise WireError(f"a message is nested deeper than {MAX_DEPTH} levels")
    if isinstance(value, list | tuple):
        for item in value:
            _refuse_foreign(item, depth + 1)
    elif isinstance(value, dict):
        for key, item in value.items():
            _refuse_foreign(key, depth + 1)
            _refuse_foreign(item, depth + 1)
    elif value is _MARK or isinstance(value, bytes | msgpack.Timestamp):
        raise WireError(f"a value of type {type(value).__name__} cannot cross")
