"""What a hostile peer may write into the pipe: frames, and what only begins like one."""

from __future__ import annotations

import struct

import msgpack
from hypothesis import strategies as st
from robust_slam_autograder.protocol import wire
from robust_slam_autograder.protocol.wire import Handle

from tests.autograder.fuzz import messages
from tests.autograder.fuzz.values import ARRAYS, HANDLES, INTEGERS, TEXT, Foreign, export, nested

MOST = 60_000
"""What fits into a pipe at once."""
SMALL = nested(st.none() | st.booleans() | INTEGERS | TEXT | ARRAYS | HANDLES)
NUMBERS = st.integers(1, 3) | st.sampled_from([0, -1, 2**64, True, "1", 1.0, None])
TARGETS = (
    st.tuples(st.sampled_from(["yours", "mine", "name"]), st.integers(-1, 6) | TEXT).map(list)
    | st.lists(SMALL, max_size=3)
    | SMALL
)
TOLD = st.fixed_dictionaries(
    {}, optional={"types": st.lists(TEXT) | SMALL, "message": SMALL, "line": SMALL, "x": SMALL}
)
ARGUMENTS = st.lists(HANDLES | SMALL, max_size=3) | SMALL
CALLS = st.tuples(
    st.just("call"), NUMBERS, TARGETS, ARGUMENTS, st.dictionaries(TEXT, SMALL, max_size=1) | SMALL
)
ANSWERS = st.tuples(st.sampled_from(["return", "raise"]), NUMBERS, TOLD | SMALL)
ODD = st.lists(SMALL | st.sampled_from(["call", "return", "raise", 1]), max_size=6)
OURS = st.integers(0, 6)
"""Functions that were handed to the peer are numbered from 0."""
HANDED = st.builds(lambda key: Foreign(Handle("yours", key)), OURS) | HANDLES
WELL_FORMED = st.builds(
    lambda key, arguments: ["call", 1, ["yours", key], arguments, {}],
    OURS,
    st.lists(HANDED | SMALL, max_size=2),
)
MESSAGES = (WELL_FORMED | CALLS | ANSWERS | ODD).map(lambda parts: _packed(list(parts)))


def _packed(parts: list[object]) -> bytes:
    try:
        return wire.encode(parts, export)
    except wire.WireError:  # an unhashable key, say: then the names of the parts alone
        return bytes(msgpack.packb([str(part) for part in parts]))


@st.composite
def frame(draw: st.DrawFn) -> bytes:
    """A message behind its length, which mostly is right."""
    payload = draw(MESSAGES | MESSAGES | MESSAGES | messages.HOSTILE)
    lie = draw(st.sampled_from([0, 0, 0, 0, 0, 0, -1, 1, 1000, 2**31]))
    return struct.pack(">I", max(len(payload) + lie, 0)) + payload


STREAMS = st.lists(frame(), max_size=6).map(lambda frames: b"".join(frames)[:MOST])
VALID = st.lists(MESSAGES, min_size=1, max_size=6).map(
    lambda found: b"".join(struct.pack(">I", len(data)) + data for data in found)[:MOST]
)
TOKENS = [struct.pack(">I", n) for n in (0, 1, 255, 2**25, 2**25 + 1, 2**32 - 1)] + messages.TOKENS
