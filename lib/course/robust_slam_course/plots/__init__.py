"""Drawing functions of the course: axes in, axes out, no figure and no state of their own.

u is a whitened residual, without unit, and χ² its square; readings and estimates share one unit.
Colour is never the only sign: what must be told apart differs in line or marker too. Where a
function's arrays do not fit each other, or a number that it needs is not finite, it raises
``ValueError``.
"""

import numpy as np
from robust_slam._arrays import Array


def with_gaps(lines: Array) -> Array:
    """Return x and y (2, m (k + 1)) of m lines of k points (m, k, 2) as one line with gaps."""
    gaps = np.full((len(lines), 1, 2), np.nan)
    return np.concatenate([lines, gaps], axis=1).reshape(-1, 2).T


def ring(m: int) -> Array:
    """Return m places (m, 2) on the unit circle, clockwise from the top."""
    turn = np.pi / 2.0 - 2.0 * np.pi * np.arange(m) / max(m, 1)
    return np.stack([np.cos(turn), np.sin(turn)], axis=1)
