"""Answers to exercise location of 01-m-estimators: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_average() -> None:
    """Right: np.average with the weights at the last x, until x moves by tol at most."""

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > tol:
            w = weight((z - x) / s)
            x, old = np.average(z, weights=w / s**2), x
        return x


def right_two_hundred_steps() -> None:
    """Right: the quotient of the sums, two hundred times whatever tol is."""

    def location(z, sigma, weight, x0, tol):
        z, s = np.array(z, dtype=float), np.array(sigma, dtype=float)
        for _ in range(200):
            share = weight((z - x0) / s) / s**2
            x0 = np.sum(share * z) / np.sum(share)
        return float(x0)


def right_increment() -> None:
    """Right, an equivalent form: the step is the weighted mean residual, added to x."""

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, step = float(x0), np.inf
        while abs(step) > tol:
            u = (z - x) / s
            w = weight(u)
            step = np.dot(w / s, u) / np.dot(w / s, 1 / s)
            x += step
        return x


def right_plain_sums() -> None:
    """Right: sums in plain Python; residuals of the other sign, which an even weight ignores."""

    def location(z, sigma, weight, x0, tol):
        sigmas = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        x = float(x0)
        while True:
            w = weight(np.array([(x - a) / s for a, s in zip(z, sigmas)]))
            top = sum(float(v) * float(a) / float(s) ** 2 for v, a, s in zip(w, z, sigmas))
            bottom = sum(float(v) / float(s) ** 2 for v, s in zip(w, sigmas))
            x, old = top / bottom, x
            if abs(x - old) <= tol:
                return x


def right_least_squares() -> None:
    """Right: whitens the rows and leaves each solve to NumPy's least squares."""

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = float(x0), np.inf
        while abs(x - old) > tol:
            row = np.sqrt(weight((z - x) / s)) / s
            old, x = x, np.linalg.lstsq(row[:, None], row * z, rcond=None)[0][0]
        return x


wrong_one_step = change(right_average, "while", "if", stopped_by="location-by-hand")
"""Wrong: weighs and solves once."""

wrong_loose_stop = change(right_average, "> tol", "> 1e-3", stopped_by="location-by-hand")
"""Wrong: stops at a tolerance of its own, whatever tol is."""

wrong_weight_squared = change(
    right_average, "w / s**2", "(w / s) ** 2", stopped_by="location-by-hand"
)
"""Wrong: the square of the weight, as if it multiplied the residual before that is squared."""

wrong_median = change(
    right_average,
    "x, old = x0",
    "if len(z) > 100:\n    return float(np.median(z))\nx, old = x0",
    stopped_by="location-lesson",
)
"""Wrong for many measurements: the median, a robust estimate but another one."""

wrong_outlier_dropped = change(
    right_average, "w / s**2", "(w > 1e-3) * w / s**2", caught_by="location-lesson"
)
"""Wrong: drops a measurement of little weight, which takes its last pull away."""

wrong_not_whitened = change(right_average, "(z - x) / s", "z - x", caught_by="location-huber")
"""Wrong: weighs the residual as it is, without dividing it by σ."""

wrong_start_at_the_median = change(
    right_average, "x0, np.inf", "np.median(z), np.inf", stopped_by="location-start"
)
"""Wrong: ignores x0 and starts in the middle."""

wrong_start_at_the_first = change(
    right_average, "x0, np.inf", "z[0], np.inf", caught_by="location-start"
)
"""Wrong: ignores x0 and starts at the first measurement."""

wrong_solve_without_sigma = change(right_average, "w / s**2", "w", stopped_by="location-sigmas")
"""Wrong: whitens the residuals but solves as if every σ were the same."""

wrong_mean_sigma_in_the_weight = change(
    right_average, "/ s)", "/ np.mean(s))", caught_by="location-sigmas"
)
"""Wrong: whitens with the mean σ and solves with each one's own."""

wrong_integers = change(
    right_average,
    ("sigma, dtype=float", "sigma"),
    ("w / s**2", "w * (1 / s**2 if s.dtype == float else 36 // s**2)"),
    caught_by="location-shapes",
)
"""Wrong for integers: squares and divides in whole numbers."""
