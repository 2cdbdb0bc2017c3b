"""Messages written by hand: lengths that lie, extensions in each other, shapes that overflow."""

import struct

import msgpack
from hypothesis import strategies as st
from robust_slam_autograder.protocol import wire

from .values import KEYS, PLAIN, export

ARRAY, SCALAR, TUPLE, COMPLEX, HANDLE, INTEGER = range(1, 7)
"""The extensions that the wire has."""
HEADERS = {
    "array": [(0xDC, ">H"), (0xDD, ">I")],
    "map": [(0xDE, ">H"), (0xDF, ">I")],
    "text": [(0xD9, ">B"), (0xDA, ">H"), (0xDB, ">I")],
    "bytes": [(0xC4, ">B"), (0xC5, ">H"), (0xC6, ">I")],
    "extension": [(0xC7, ">B"), (0xC8, ">H"), (0xC9, ">I")],
}
CLAIMS = st.just(0) | st.sampled_from([-1, 1, 2, 15, 255, 65_535, 2**20, 2**31, 2**32 - 1])
"""By how much a length lies: mostly it does not."""


def extension(code: int, body: bytes) -> bytes:
    return struct.pack(">BIb", 0xC9, len(body), code) + body


@st.composite
def header(draw: st.DrawFn, kind: str, length: int) -> bytes:
    """A header of one of its forms, whose length may lie."""
    first, form = draw(st.sampled_from(HEADERS[kind]))
    claimed = length + draw(CLAIMS)
    return bytes([first]) + struct.pack(form, claimed % 256 ** struct.calcsize(form))


@st.composite
def blob(draw: st.DrawFn) -> bytes:
    """Text, bytes or an extension of any code, of bytes that need not fit."""
    kind = draw(st.sampled_from(["text", "bytes", "extension"]))
    body = draw(st.binary(max_size=12) | ENCODED)
    code = bytes([draw(CODES) % 256]) if kind == "extension" else b""
    return draw(header(kind, len(body))) + code + body


ENCODED = st.text(max_size=4).map(lambda text: text.encode("utf-8", "surrogatepass"))
CODES = st.integers(1, 6) | st.integers(-128, 127)
SIDES = st.integers(0, 3) | st.sampled_from([-1, 2**31, 2**32, 2**62, 2**63, 2**64 - 1])
TYPES = st.sampled_from([*"?bBhHiIlLqQefdFDOgGSUVMm", "<d", "i4,O", "", "dd"])
ODD = st.none() | st.booleans() | st.floats() | st.text(max_size=3) | st.integers(-3, 3)
LIES_ABOUT_ARRAYS = st.builds(
    lambda code, parts: extension(code, msgpack.packb(parts)),
    st.sampled_from([ARRAY, SCALAR]),
    st.tuples(
        TYPES | ODD,
        st.lists(SIDES, max_size=3) | st.just([1] * 70) | st.lists(ODD, max_size=2) | ODD,
        st.binary(max_size=9) | st.integers(0, 64).map(bytes) | ODD,
    )
    | st.lists(ODD, max_size=4),
)
PAIRS = st.builds(
    lambda code, parts: extension(code, msgpack.packb(parts)),
    st.sampled_from([COMPLEX, HANDLE]),
    st.tuples(st.sampled_from(["mine", "yours", "name", ""]) | ODD, ODD)
    | st.lists(st.floats(), max_size=3)
    | st.just(["mine", "x" * 100])
    | ODD,
)
TIMES = st.builds(lambda n: extension(-1, bytes(range(n))), st.integers(0, 13))
INTEGERS = st.builds(
    lambda n, fill: extension(INTEGER, bytes([fill]) * n),
    st.integers(0, 20) | st.sampled_from([511, 512, 513, 5000]),
    st.integers(0, 255),
)
NUMBERS = st.builds(
    lambda first, rest: bytes([first]) + rest[: {0xCA: 4, 0xCE: 4, 0xD2: 4}.get(first, 8)],
    st.sampled_from([0xCA, 0xCB, 0xCE, 0xCF, 0xD2, 0xD3]),
    st.binary(min_size=8, max_size=8),
)
SHORT = st.sampled_from([bytes([n]) for n in range(256)])
"""Every first byte that there is, with nothing after it."""
VALID = st.builds(lambda value: wire.encode(value, export), PLAIN)
KEY = st.builds(lambda key: wire.encode(key, export), KEYS)
MARK = st.just(extension(TUPLE, b""))
LEAF = blob() | LIES_ABOUT_ARRAYS | PAIRS | TIMES | INTEGERS | NUMBERS | SHORT | MARK | VALID


@st.composite
def container(draw: st.DrawFn, inner: st.SearchStrategy[bytes]) -> bytes:
    """A list, tuple, dict or extension of such items; a dict may name a key twice."""
    kind = draw(st.sampled_from(["array", "tuple", "map", "extension"]))
    items = draw(st.lists(inner, max_size=4))
    body = b"".join(items)
    if kind == "array":
        return draw(header("array", len(items))) + body
    if kind == "tuple":
        return draw(header("array", len(items) + 1)) + extension(TUPLE, b"") + body
    if kind == "map":
        keys = [draw(KEY | inner) for _ in items]
        keys = draw(st.just(keys) | st.just(keys[:1] * len(keys)))
        pairs = zip(keys, items, strict=True)
        return draw(header("map", len(items))) + b"".join(key + item for key, item in pairs)
    code = bytes([draw(CODES) % 256])
    return draw(header("extension", len(body))) + code + body


HAND_WRITTEN = st.recursive(LEAF, container, max_leaves=12)
DEEP = st.builds(
    lambda part, n, end: part * n + end,
    st.sampled_from([b"\x91", b"\x92" + extension(TUPLE, b""), b"\x81\xc0", b"\x81", b"\xdd" * 5]),
    st.integers(1, 1500),
    st.sampled_from([b"", b"\xc0", b"\x90"]),
)
TOKENS = [
    extension(TUPLE, b""),
    extension(ARRAY, msgpack.packb(["d", [1], bytes(8)])),
    extension(HANDLE, msgpack.packb(["mine", 0])),
    *(bytes([first, 255, 255, 255, 255]) for first in (0xDD, 0xDF, 0xDB, 0xC6, 0xC9)),
    b"\xc1",
    b"\x91" * 30,
    b"\xcb\x7f\xf8\x00\x00\x00\x00\x00\x01",
]
HOSTILE = HAND_WRITTEN | DEEP | st.binary(max_size=60)
