"""Our two ways to solve a pose graph: by numpy alone, and by the compiled factorisation.

The library chooses by the number of edges; here each way is measured on every graph. What it
takes to load the compiled one, once per process, stands in the figure ``kernels``.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from robust_slam.descent import gauss_newton, start
from robust_slam.descent.sparse.choice import COMPILED_FROM, LARGE, has_numba
from robust_slam.graphs.generate import manhattan, sphere

from benchmarks.speed.clock import Side

EDGES = {"numpy": sys.maxsize, "compiled": 0}
"""From how many edges on the factorisation is the compiled one, for each way."""
_FIRST_USE = """
import time
from benchmarks.speed import ways
before = time.process_time()
ways.load()
print(time.process_time() - before)
"""


def our_sides(run: Callable[[], Any], read: Callable[[Any], Any]) -> list[Side]:
    """Return a side for each way that there is: ``numpy``, and ``compiled`` with numba."""
    if not has_numba():
        return [Side("numpy", _by("numpy", run), read)]
    load()
    return [Side(way, _by(way, run), read) for way in EDGES]


def _by(way: str, run: Callable[[], Any]) -> Callable[[], Any]:
    def chosen() -> Any:  # noqa: ANN401
        os.environ[COMPILED_FROM] = str(EDGES[way])
        try:
            return run()
        finally:
            del os.environ[COMPILED_FROM]

    return chosen


@cache
def load() -> None:
    """Use every kernel once, on small graphs in the plane and in space."""
    for make in (manhattan, sphere):
        graph, _ = make(50, np.random.default_rng(0), closures=20)
        _by("compiled", lambda graph=graph: gauss_newton(graph, start.chordal(graph)))()


def measure() -> str:
    """Return the CPU seconds of the first use of the kernels, compiled anew and from disk."""
    if not has_numba():
        return "none: numba is not installed"
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-c", _FIRST_USE]
        first, later = (
            float(subprocess.run(command, env=environment, capture_output=True, check=True).stdout)
            for _ in range(2)
        )
    return (
        f"are loaded in {later:.2f} s once per process, and compiled in {first:.1f} s once per "
        f"machine; used from {LARGE:,} edges"
    )
