"""Damages bytes: flips, cuts, repeats, and puts in what parsers trip over."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from tests.autograder.fuzz import running


def variants(data: bytes, tokens: Sequence[bytes], seed: int) -> Iterator[bytes]:
    """Give the bytes, then with a few edits, in many ways; ``tokens`` are what may be put in."""
    yield data
    rng = np.random.default_rng(seed)
    for _ in range(running.VARIANTS):
        damaged = data
        for _ in range(rng.integers(1, 5)):
            damaged = _edited(damaged, tokens, rng)
        yield damaged


def _edited(data: bytes, tokens: Sequence[bytes], rng: np.random.Generator) -> bytes:
    start, end = sorted(rng.integers(0, len(data) + 1, size=2).tolist())
    head, part, rest = data[:start], data[start:end], data[end:]
    match rng.integers(6):
        case 0:
            return head + rest
        case 1:
            return head
        case 2:
            return head + part * int(rng.integers(2, 5)) + rest
        case 3:
            return head + tokens[rng.integers(len(tokens))] + part + rest
        case _:
            byte = bytes([rng.integers(256)])
            return head + (byte + data[start + 1 :] if part else byte)
