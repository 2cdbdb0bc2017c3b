"""Which graphs are solved by the compiled kernels.

The kernels need numba (``pip install robust-slam[fast]``). Loading numba and them takes about
a second, so smaller graphs are solved without. The choice depends on the size of a graph
alone: a result never depends on what was computed before it.
"""

from __future__ import annotations

import os
from functools import cache
from importlib.util import find_spec

COMPILED_FROM = "ROBUST_SLAM_COMPILED_FROM"
"""The environment variable with the number of edges from which kernels are compiled ones."""
LARGE = 4000
"""That number by default."""


def use_compiled(edges: int) -> bool:
    """Tell whether a graph with so many ``edges`` is solved by the compiled kernels."""
    return edges >= int(os.environ.get(COMPILED_FROM, LARGE)) and has_numba()


@cache
def has_numba() -> bool:
    """Tell whether numba is installed; it is not imported."""
    return find_spec("numba") is not None
