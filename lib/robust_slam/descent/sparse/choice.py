"""Which graphs are solved by compiled code.

It needs numba (``pip install robust-slam[fast]``). Loading numba and it takes about
a second, so smaller graphs are solved without. The choice depends on the size of a graph
alone: a result never depends on what was computed before it.

Source: derived here, from measured times.
"""

from __future__ import annotations

import os
from functools import cache
from importlib.util import find_spec

COMPILED_FROM = "ROBUST_SLAM_COMPILED_FROM"
"""The environment variable with the number of edges from which compiled code is taken."""
LARGE = 9000
"""That number by default. From there on one `solve` is quicker, with the loading included."""


def use_compiled(edges: int) -> bool:
    """Tell whether a graph with so many ``edges`` is solved by compiled code.

    Raises:
        ValueError: the environment variable is not a whole number.
    """
    return edges >= _compiled_from() and has_numba()


def _compiled_from() -> int:
    given = os.environ.get(COMPILED_FROM, str(LARGE))
    try:
        return int(given)
    except ValueError:
        raise ValueError(f"{COMPILED_FROM} is {given!r}; give a number of edges") from None


@cache
def has_numba() -> bool:
    """Tell whether numba is installed; it is not imported."""
    return find_spec("numba") is not None
