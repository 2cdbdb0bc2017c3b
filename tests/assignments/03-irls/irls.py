"""Answers to exercise irls of 03-irls: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_average() -> None:
    """Right: weigh, solve, append, until the last two agree."""

    def irls(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)
        x, moved, history = x0, np.inf, [x0]
        while moved > tol:
            share = weight((z - x) / s) / s**2
            new = np.average(z, weights=share)
            moved, x = abs(new - x), new
            history.append(x)
        return x, history


def right_average_and_array() -> None:
    """Right: np.average, a hundred steps at most, and the history as an array."""

    def irls(z, sigma, weight, x0, tol):
        z = np.array(z, dtype=float)
        information = 1 / (np.array(sigma, dtype=float) ** 2 * np.ones(len(z)))
        history = np.array([x0], dtype=float)
        for _ in range(100):
            w = weight((z - history[-1]) * np.sqrt(information))
            history = np.append(history, np.average(z, weights=w * information))
            if np.isclose(history[-1], history[-2], rtol=0, atol=tol):
                break
        return float(history[-1]), history


def right_one_by_one() -> None:
    """Right: plain Python, one residual at a time; the last step, which keeps x, is left out."""

    def irls(z, sigma, weight, x0, tol):
        sigmas = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        x, history = float(x0), [float(x0)]
        while True:
            shares = [float(weight((a - x) / s)) / s**2 for a, s in zip(z, sigmas)]
            new = sum(w * a for w, a in zip(shares, z)) / sum(shares)
            if abs(new - x) <= tol:
                return x, history
            x = new
            history.append(x)


def right_gauss_newton() -> None:
    """Right, an equivalent form: adds the weighted mean residual to x, with one step too many."""

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        s = np.ones_like(z) * np.asarray(sigma, dtype=float)
        x, quiet, history = float(x0), 0, (float(x0),)
        while quiet < 2:
            u = (z - x) / s
            w = np.asarray(weight(u))
            delta = np.dot(w / s, u) / np.dot(w / s, 1 / s)
            x = x + delta
            history = (*history, x)
            quiet = quiet + 1 if abs(delta) < tol else 0
        return x, history


wrong_misprint = change(
    right_average, "moved > tol", "len(history) < 4", caught_by="irls-fixed-point"
)
"""Wrong: stops after three steps, at the lesson's 0.01, which IRLS only passes."""

wrong_loose_stop = change(right_average, "> tol", "> 1e-3", caught_by="irls-fixed-point")
"""Wrong: stops at a tolerance of its own, a thousandth, whatever tol is."""

wrong_always_the_best = change(
    right_average,
    "return",
    """
    if x0 != np.median(z):
        other = irls(z, sigma, weight, np.median(z), tol)
        cost = [np.sum(np.log1p(((z - end) / s) ** 2)) for end in (x, other[0])]
        x, history = other if cost[1] < cost[0] - 1e-6 else (x, history)
    return""",
    caught_by="irls-start",
)
"""Wrong: descends from the median too and returns the better end, though x0 was given."""

wrong_start_at_the_mean = change(
    right_average, "x, moved,", "x0 = np.mean(z)\nx, moved,", stopped_by="irls-by-hand"
)
"""Wrong: ignores x0 and starts at the mean."""

wrong_stale_weights = change(right_average, "z - x", "z - x0", stopped_by="irls-fixed-point")
"""Wrong: weighs once, at x0, and never again, so the first step is the last."""

wrong_history_with_gaps = change(
    right_average, "return x, history", "return x, [*history[:2], x]", caught_by="irls-history"
)
"""Wrong history: keeps the first two entries and the last one, and drops those between."""

wrong_half_steps = change(
    right_average,
    ("> tol", "> tol / 10"),
    ("moved, x =", "new = new if len(history) == 1 else (x + new) / 2\nmoved, x ="),
    caught_by="irls-history",
)
"""Wrong steps: after the first it averages the old x with the new."""

wrong_always_cauchy = change(
    right_average, "weight((z - x) / s)", "1 / (1 + ((z - x) / s) ** 2)", caught_by="irls-weight"
)
"""Wrong: Cauchy's weight is written into the loop and the one handed in is ignored."""

wrong_solve_without_sigma = change(right_average, " / s**2", "", caught_by="irls-sigmas")
"""Wrong: whitens the residuals but solves as if every σ were the same."""

wrong_tolerance_of_its_own = change(right_average, "> tol", "> 1e-12", stopped_by="irls-tolerance")
"""Wrong: goes on until x no longer changes, whatever tol is."""

wrong_one_hundred_steps = change(
    right_average, "moved > tol", "len(history) <= 100", stopped_by="irls-tolerance"
)
"""Wrong: does a hundred steps, and leaves tol out of account."""
