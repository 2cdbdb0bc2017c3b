"""Answers to exercise strained_edges of 00-one-lie: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_vectorised() -> None:
    """Right: one comparison over the whole array."""
    import numpy as np

    def strained_edges(residuals, tol):
        return np.abs(np.asarray(residuals, dtype=float)) > tol


def right_plain_list() -> None:
    """Right: a list of Python's own booleans."""

    def strained_edges(residuals, tol):
        return [abs(float(u)) > tol for u in residuals]


def right_two_sides() -> None:
    """Right, an equivalent form: outside on the one side or on the other."""
    import numpy as np

    def strained_edges(residuals, tol):
        u = np.array(residuals)
        return (u > tol) | (u < -tol)


def right_clipped() -> None:
    """Right, an equivalent form: strained is what clipping changes."""
    import numpy as np

    def strained_edges(residuals, tol):
        u = np.asarray(residuals, dtype=float)
        return np.clip(u, -tol, tol) != u


wrong_sign_dropped = change(
    right_vectorised,
    "np.abs(np.asarray(residuals, dtype=float))",
    "np.asarray(residuals)",
    caught_by="strained_edges-signs",
)
"""Wrong: r > tol finds the stretched edges and misses the squeezed ones."""


def wrong_largest_only() -> None:
    """Wrong: points at the worst edge alone, as if it were the lie. Caught by
    strained_edges-cycle.
    """
    import numpy as np

    def strained_edges(residuals, tol):
        size = np.abs(np.asarray(residuals, dtype=float))
        return (size > tol) & (size == np.max(size))


wrong_exact_zero = change(
    right_vectorised,
    "np.abs(np.asarray(residuals, dtype=float)) > tol",
    "np.asarray(residuals) != 0",
    stopped_by="strained_edges-cycle",
)
"""Wrong: asks whether a residual is exactly 0, which after a solve none is."""


def wrong_the_lie_is_known() -> None:
    """Wrong: does not count the last edge, because the lie is the cause and not the harm. Stopped
    by the visible case strained_edges-by-hand.
    """
    import numpy as np

    def strained_edges(residuals, tol):
        strained = np.abs(np.asarray(residuals)) > tol
        strained[-1] = False
        return strained


def wrong_neighbours_too() -> None:
    """Wrong: counts the edge on either side of a strained one, as if strain were handed on. Caught
    by strained_edges-cycle.
    """
    import numpy as np

    def strained_edges(residuals, tol):
        strained = np.abs(np.asarray(residuals)) > tol
        if len(strained) > 2:
            strained = strained | np.append(strained[1:], False) | np.append(False, strained[:-1])
        return strained


wrong_squared = change(
    right_vectorised, "np.abs", "np.square", stopped_by="strained_edges-tolerance"
)
"""Wrong: compares the square of u with tol."""


def wrong_relative() -> None:
    """Wrong: takes a share of the largest residual for the threshold where tol is below 1. Caught
    by strained_edges-tolerance.
    """
    import numpy as np

    def strained_edges(residuals, tol):
        size = np.abs(np.asarray(residuals, dtype=float))
        return size > (tol * np.max(size) / 0.7 if 1e-3 < tol < 0.5 else tol)


def wrong_at_the_threshold() -> None:
    """Wrong: counts an edge that stands exactly at tol. Caught by strained_edges-tolerance."""
    import numpy as np

    def strained_edges(residuals, tol):
        return np.abs(np.asarray(residuals)) >= tol


wrong_three_sigma = change(
    right_vectorised,
    "np.abs(np.asarray(residuals, dtype=float)) > tol",
    "np.abs(np.asarray(residuals)) > 3",
    stopped_by="strained_edges-tolerance",
)
"""Wrong: the threshold 3 that everybody uses, whatever tol says."""
