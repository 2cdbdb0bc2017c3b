"""Answers to exercise strained_edges of 00-one-lie: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_array() -> None:
    """Right: one comparison over the whole array."""

    def strained_edges(residuals, tol):
        size = np.abs(residuals)
        return size > tol


def right_plain_list() -> None:
    """Right: a list of Python's own booleans."""

    def strained_edges(residuals, tol):
        return [abs(float(u)) > tol for u in residuals]


def right_two_sides() -> None:
    """Right, an equivalent form: outside on the one side or on the other."""

    def strained_edges(residuals, tol):
        u = np.array(residuals)
        return (u > tol) | (u < -tol)


def right_clipped() -> None:
    """Right, an equivalent form: strained is what clipping changes."""

    def strained_edges(residuals, tol):
        u = np.asarray(residuals, dtype=float)
        return np.clip(u, -tol, tol) != u


wrong_sign_dropped = change(
    right_array, "np.abs(residuals)", "np.asarray(residuals)", caught_by="strained_edges-signs"
)
"""Wrong: r > tol finds the stretched edges and misses the squeezed ones."""

wrong_largest_only = change(
    right_array, "size > tol", "size >= max([tol, *size])", caught_by="strained_edges-cycle"
)
"""Wrong: reports the worst edge alone, as if it were the outlier."""

wrong_exact_zero = change(right_array, "> tol", "!= 0", stopped_by="strained_edges-cycle")
"""Wrong: asks whether a residual is exactly 0, which none is after a solve."""

wrong_the_lie_is_known = change(
    right_array, "return", "size[-1] = 0\nreturn", stopped_by="strained_edges-by-hand"
)
"""Wrong: does not count the last edge, because the outlier is the cause and not the harm."""

wrong_neighbours_too = change(
    right_array,
    "size > tol",
    'np.convolve(size > tol, np.ones(3 if len(size) > 2 else 1), "same") > 0',
    caught_by="strained_edges-cycle",
)
"""Wrong: counts the edge on either side of a strained one too."""

wrong_squared = change(right_array, "np.abs", "np.square", stopped_by="strained_edges-tolerance")
"""Wrong: compares the square of u with tol."""

wrong_relative = change(
    right_array,
    "> tol",
    "> (tol * np.max(size) / 0.7 if 1e-3 < tol < 0.5 else tol)",
    caught_by="strained_edges-tolerance",
)
"""Wrong: takes a share of the largest residual for the threshold where tol is below 1."""

wrong_at_the_threshold = change(right_array, ">", ">=", caught_by="strained_edges-tolerance")
"""Wrong: counts an edge whose residual is exactly tol."""

wrong_three_sigma = change(right_array, "> tol", "> 3", stopped_by="strained_edges-tolerance")
"""Wrong: the usual threshold 3, whatever tol is."""
