"""Answers to exercise irls_tls of 03-irls: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_loop() -> None:
    """Right: weigh, look whether a measurement is left, solve."""

    def irls_tls(z, sigma, c, x0, tol):
        z, s = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)
        x, moved = x0, np.inf
        while moved > tol:
            w = np.where(np.abs((z - x) / s) <= c, 1.0, 0.0)
            if not w.any():
                raise ValueError("none is left")
            new = np.average(z, weights=w / s**2)
            moved, x = abs(new - x), new
        return x, w


def right_plain_lists() -> None:
    """Right: plain Python; stops when the set of those that are left no longer changes."""

    def irls_tls(z, sigma, c, x0, tol):
        s = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        x, left = float(x0), None
        while True:
            now = [i for i in range(len(z)) if abs(z[i] - x) <= c * s[i]]
            if not now:
                raise ValueError("none is left")
            if now == left:
                return x, [1 if i in now else 0 for i in range(len(z))]
            left = now
            x = sum(z[i] / s[i] ** 2 for i in now) / sum(1 / s[i] ** 2 for i in now)


def right_masked_average() -> None:
    """Right: a boolean mask, NumPy's average of what it keeps, weights as truth values."""

    def irls_tls(z, sigma, c, x0, tol):
        z = np.array(z, dtype=float)
        s = np.zeros(z.shape) + np.asarray(sigma, dtype=float)
        x = previous = float(x0)
        for _ in range(1000):
            keep = ((z - x) / s) ** 2 <= c**2
            if not keep.any():
                raise ValueError(f"no residual is within {c} of {x}")
            x = np.average(z[keep], weights=1 / s[keep] ** 2)
            if abs(x - previous) < tol:
                break
            previous = x
        return x, keep


def right_library() -> None:
    """Right: lets the division fail and turns its error into the ValueError that is asked for."""

    def irls_tls(z, sigma, c, x0, tol):
        z, s = np.broadcast_arrays(np.asarray(z, dtype=float), np.asarray(sigma, dtype=float))
        x, moved = x0, np.inf
        while moved > tol:
            w = (np.abs((z - x) / s) <= c).astype(float)
            try:
                new = float(np.average(z, weights=w / s**2))
            except ZeroDivisionError as error:
                raise ValueError("no fit") from error
            moved, x = abs(new - x), new
        return x, w


wrong_nan = change(
    right_loop,
    'raise ValueError("none is left")',
    "return np.sum(w * z) / np.sum(w), w",
    caught_by="irls_tls-empty",
)
"""Wrong when none is left: divides 0 by 0 and returns NaN."""

wrong_padded_denominator = change(
    right_loop,
    'raise ValueError("none is left")',
    "return np.sum(w * z) / (np.sum(w) + 1e-9), w",
    caught_by="irls_tls-empty",
)
"""Wrong when none is left: a small number added to the denominator turns 0/0 into 0."""

wrong_keeps_the_last_x = change(
    right_loop, 'raise ValueError("none is left")', "return x, w", caught_by="irls_tls-empty"
)
"""Wrong when none is left: returns the current x as if it were a fit."""

wrong_other_error = change(
    right_library, 'raise ValueError("no fit") from error', "raise", caught_by="irls_tls-empty"
)
"""Wrong when none is left: the error that comes is np.average's ZeroDivisionError."""

wrong_first_zero = change(right_loop, "w.any()", "w.all()", stopped_by="irls_tls-by-hand")
"""Wrong: gives up at the first weight of 0, though others are left."""

wrong_guard_on_the_sum = change(
    right_loop, "not w.any()", "np.sum(w / s**2) < 1e-9", caught_by="irls_tls-tiny"
)
"""Wrong for large σ: takes a small sum of w/σ² for none."""

wrong_one_step = change(right_loop, "while", "if", caught_by="irls_tls-random")
"""Wrong: weighs and solves once, where the weights change from step to step."""

wrong_never_back = change(
    right_loop,
    ("x, moved = x0,", "w, x, moved = 1.0, x0,"),
    ("w = np.where", "w = w * np.where"),
    caught_by="irls_tls-random",
)
"""Wrong: a measurement that was dropped once stays out for ever."""

wrong_solve_without_sigma = change(right_loop, "w / s**2", "w", caught_by="irls_tls-sigmas")
"""Wrong: takes the plain mean of those that are left, whatever their σ."""

wrong_open_threshold = change(right_loop, "<=", "<", caught_by="irls_tls-knee")
"""Wrong at the threshold itself: drops the measurements at |u| = c."""

wrong_weights_of_the_kept_only = change(
    right_loop, "return x, w", "return x, w[w > 0]", stopped_by="irls_tls-by-hand"
)
"""Wrong weights: returns only those of the measurements that are left."""
