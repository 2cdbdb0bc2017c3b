"""Answers to exercise tls_descent of 04-non-convexity: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_fit() -> None:
    """Right: the mean of those that are kept, a thousand times."""

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(1000):
            kept = z[np.abs(x - z) <= c]
            x = np.mean(kept) if kept.size else x
        return x


def right_plain_python() -> None:
    """Right: lists and a for loop that is long enough."""

    def tls_descent(z, c, x0):
        x = x0
        for _ in range(1000):
            kept = [a for a in z if abs(a - x) <= c]
            if kept:
                x = sum(kept) / len(kept)
        return x


def right_weights() -> None:
    """Right: a weighted mean of zeros and ones, until x moves less than rounding."""

    def tls_descent(z, c, x0):
        z, x = np.array(z, dtype=float), np.float64(x0)
        while True:
            w = np.where(np.abs(z - x) <= c, 1.0, 0.0)
            if np.sum(w) == 0:
                return x
            new = np.average(z, weights=w)
            if abs(new - x) < 1e-12:
                return new
            x = new


def right_recursion() -> None:
    """Right: one step, and the descent from there; adds the mean residual to x."""

    def tls_descent(z, c, x0):
        residuals = np.asarray(z, dtype=float) - x0
        kept = residuals[np.abs(residuals) <= c]
        step = float(np.mean(kept)) if len(kept) else 0.0
        return float(x0) if abs(step) < 1e-11 else tls_descent(z, c, x0 + step)


wrong_misprint = change(
    right_fit, "return x", "return z[np.argmin(np.abs(z - x0))]", stopped_by="tls_descent-lesson"
)
"""Wrong: who starts near 10 ends at 10, as the lesson says without a c: always the nearest."""

wrong_nan = change(right_fit, " if kept.size else x", "", caught_by="tls_descent-flat")
"""Wrong where none is kept: the mean of nothing is NaN."""

wrong_tiny_number = change(
    right_fit,
    "np.mean(kept) if kept.size else x",
    "np.sum(kept) / (kept.size + 1e-12)",
    caught_by="tls_descent-flat",
)
"""Wrong where none is kept: a tiny number in the denominator takes x to 0."""

wrong_fit_wanted = change(
    right_fit,
    "x = np.mean",
    'if kept.size == 0:\n    raise ValueError("none is left")\nx = np.mean',
    stopped_by="tls_descent-flat",
)
"""Wrong here: raises ValueError where none is kept, as in assignment 03."""

wrong_nearest_when_flat = change(
    right_fit, "else x", "else z[np.argmin(np.abs(z - x))]", caught_by="tls_descent-flat"
)
"""Wrong where none is kept: goes to the nearest measurement, though nothing pulls."""

wrong_one_step = change(right_fit, "1000", "1", stopped_by="tls_descent-steps")
"""Wrong: one mean, and no second look."""

wrong_dropped_for_good = change(
    right_fit, "x = np.m", "z = kept if kept.size else z\nx = np.m", stopped_by="tls_descent-steps"
)
"""Wrong: a measurement that was dropped once never comes back."""

wrong_from_the_mean = change(
    right_fit, "float(x0)", "np.mean(z)", stopped_by="tls_descent-by-hand"
)
"""Wrong: starts at the mean and ignores x0."""

wrong_c_squared = change(right_fit, "np.abs", "np.square", stopped_by="tls_descent-by-hand")
"""Wrong: compares the square with c."""

wrong_one_sided = change(right_fit, "np.abs(x - z)", "z - x", stopped_by="tls_descent-by-hand")
"""Wrong for measurements far below x: forgets the absolute value."""

wrong_at_the_knee = change(right_fit, "<=", "<", caught_by="tls_descent-shapes")
"""Wrong at |x - z| = c: drops a measurement that the inner piece keeps."""

wrong_integers = change(
    right_plain_python,
    "x = sum(kept) / len(kept)",
    """
    whole = all(isinstance(a, (int, np.integer)) for a in kept)
    x = sum(kept) // len(kept) if whole else sum(kept) / len(kept)
    """,
    caught_by="tls_descent-shapes",
)
"""Wrong for integers: whole-number division."""

wrong_fifty_steps = change(right_fit, "1000", "50", caught_by="tls_descent-steps")
"""Wrong for long descents: stops after fifty steps."""
