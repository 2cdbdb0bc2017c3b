"""Whatever the other side writes into the pipe, a call ends with a value or a known error."""

import contextlib
import os
import struct
from collections.abc import Callable, Iterator
from typing import Any

import msgpack
import pytest
from hypothesis import strategies as st
from robust_slam_autograder.executor.budget import WALL_FACTOR, Meter
from robust_slam_autograder.protocol import wire
from robust_slam_autograder.protocol.channel import (
    Channel,
    ChannelClosed,
    DeadlineExceeded,
    RaisedThere,
)
from robust_slam_autograder.protocol.wire import Handle

from . import messages
from .running import SEEDS, fuzzed, variants
from .values import ARRAYS, HANDLES, INTEGERS, TEXT, Foreign, export, nested

pytestmark = pytest.mark.rest

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
KNOWN = (ChannelClosed, DeadlineExceeded, RaisedThere)


def echo(*args: object, **kwargs: object) -> object:
    return [*args, kwargs]


def fail(*args: object) -> None:
    raise ValueError(*args)


def call_back(function: Callable[..., Any], *args: object) -> object:
    return function(*args)


FUNCTIONS = (
    *(echo, fail, lambda *args: {1, 2}, call_back),
    lambda *functions: [function(echo) for function in functions],
    lambda *args: lambda: args,
)


@contextlib.contextmanager
def channel_that_reads(data: bytes, ends: bool) -> Iterator[Channel]:
    """A channel whose peer wrote this and is gone, or says no more."""
    read_end, write_end = os.pipe()
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.write(write_end, data)
        channel = Channel(read_end, nowhere, named={"echo": echo, "call_back": call_back})
        if ends:
            os.close(write_end)
        else:
            channel.patience = Meter().start(0.002 / WALL_FACTOR).left
        yield channel
    finally:
        os.close(read_end)
        os.close(nowhere)
        if not ends:
            os.close(write_end)


def converse(data: bytes, ends: bool) -> None:
    with channel_that_reads(data, ends) as channel, contextlib.suppress(*KNOWN):
        channel.call(Handle("name", "any"), (list(FUNCTIONS),), {})
    with channel_that_reads(data, ends) as channel:
        try:
            channel.serve()
        except (ChannelClosed, DeadlineExceeded):
            return
        raise AssertionError("it serves one who has gone")


@fuzzed(200, STREAMS, st.booleans())
def test_a_hostile_peer_ends_the_conversation_and_nothing_else(data, ends):
    """Two conversations on each of 200 streams, which take long to draw."""
    converse(data, ends)


@fuzzed(60, VALID, SEEDS)
def test_a_damaged_conversation_ends(valid, seed):
    for data in variants(valid, TOKENS, seed):
        converse(data[:MOST], ends=True)
