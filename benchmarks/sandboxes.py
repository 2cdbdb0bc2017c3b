"""How fast can code in two sandboxes talk by the numbers that the kernel gives to pipes?

One takes numbers or rests, the other looks how many were taken, in slots of time that both know
by the clock. What the README of the grader says of this channel is what this prints.

    python -m benchmarks.sandboxes --sandbox fork
"""

import argparse
import math
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
from robust_slam_autograder.executor.budget import Meter
from robust_slam_autograder.executor.session import Session
from robust_slam_autograder.reading.assignment import Assignment, Config, Limits, Piece, Solution
from robust_slam_autograder.sandbox import BACK_ENDS, Sandbox

SLOTS = (0.1, 0.05, 0.025, 0.0125)
"""Seconds for a bit."""
BITS = 400
CODE = """
import os, time

def taken():
    reader, writer = os.pipe()
    number = os.fstat(reader).st_ino
    os.close(reader), os.close(writer)
    return number

def send(bits, start, slot):
    for n, bit in enumerate(bits):
        while time.monotonic() < start + n * slot: pass
        while bit and time.monotonic() < start + (n + 1) * slot: taken()

def receive(count, start, slot):
    found = []
    for n in range(count):
        while time.monotonic() < start + (n + 0.1) * slot: pass
        first = last = taken()
        own = 1
        while time.monotonic() < start + (n + 0.9) * slot:
            last, own = taken(), own + 1
        found.append((last - first) % 2**32 / own)
    return found
"""


def rate(wall: Sandbox, slot: float) -> tuple[float, float]:
    """Measure one length of slots.

    Returns:
        bits a second, and the share of bits that arrive wrong.
    """
    bits = np.random.default_rng(3).integers(0, 2, BITS)
    with ThreadPoolExecutor(2) as both:
        ends = [_started(wall) for _ in range(2)]
        start = time.monotonic() + 1.0
        sent = both.submit(ends[0].bindings()["send"], bits.tolist(), start, slot)
        got = np.array(both.submit(ends[1].bindings()["receive"], BITS, start, slot).result())
        sent.result()
    for end in ends:
        end.close()
    wrong = min(
        np.mean((got > limit) != bits) for limit in np.quantile(got, np.arange(0.1, 1, 0.05))
    )
    wrong = min(max(float(wrong), 1e-9), 0.5)
    lost = -wrong * math.log2(wrong) - (1 - wrong) * math.log2(1 - wrong)
    return (1 - lost) / slot, wrong


def _started(wall: Sandbox) -> Session:
    assignment = Assignment(
        name="",
        path=Path(),
        setup=(),
        imports=(),
        libraries=(),
        solutions=(Solution("", ("send", "receive")),),
        cases=(),
        config=Config(limits=Limits(300, 300, 900)),
        given=frozenset(),
        marked=(),
    )
    session = Session(wall, assignment, [Piece("cell", CODE, own=False)], Meter().start(900))
    session.begin()
    return session


def main() -> None:
    """Read the arguments and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--sandbox", choices=list(BACK_ENDS), default="fork")
    options: Any = parser.parse_args()
    print(f"{'ms a bit':>9} {'bit/s':>7} {'wrong':>6}")
    for slot in SLOTS:
        found, wrong = rate(BACK_ENDS[options.sandbox], slot)
        print(f"{1000 * slot:9.1f} {found:7.1f} {wrong:6.3f}", flush=True)


if __name__ == "__main__":
    main()
