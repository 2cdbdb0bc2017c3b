"""Answers to exercise irls_step of 03-irls: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_mean() -> None:
    """Right: the formulas over whole arrays, and NumPy's weighted average."""

    def irls_step(z, sigma, x, c):
        z, s = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)
        w = 1 / (1 + ((z - x) / s / c) ** 2)
        new = np.average(z, weights=w / s**2)
        return new, w


def right_plain_loop() -> None:
    """Right: one measurement at a time, floats and a list."""

    def irls_step(z, sigma, x, c):
        top = bottom = 0.0
        weights = []
        for i in range(len(z)):
            s = sigma[i] if hasattr(sigma, "__len__") else sigma
            w = 1 / (1 + ((z[i] - x) / s / c) ** 2)
            weights.append(w)
            top += w * z[i] / s**2
            bottom += w / s**2
        return top / bottom, weights


def right_matrix() -> None:
    """Right: the 1×1 normal equations, with a diagonal matrix of weights over variances."""

    def irls_step(z, sigma, x, c):
        weights = c**2 / (c**2 + ((np.array(z) - x) / sigma) ** 2)
        W, ones = np.diag(weights / np.square(sigma)), np.ones(len(z))
        return ones @ W @ z / (ones @ W @ ones), weights


def right_least_squares() -> None:
    """Right: whitens the rows and leaves the solve to NumPy's least squares."""

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        weights = 1 / (1 + ((z - x) / (c * s)) ** 2)
        row = np.sqrt(weights) / s
        answer, *_ = np.linalg.lstsq(row[:, None], row * z, rcond=None)
        return answer[0], weights


def right_increment() -> None:
    """Right, an equivalent form: the step is the weighted mean of the residuals, added to x."""

    def irls_step(z, sigma, x, c):
        r = np.asarray(z, dtype=float) - x
        information = np.ones(r.size) / np.square(np.asarray(sigma, dtype=float))
        weights = 1 / (1 + r**2 * information / c**2)
        return x + np.dot(weights * information, r) / np.dot(weights, information), weights


wrong_misprint = change(
    right_mean,
    "np.average(z, weights=w / s**2)",
    "np.sum(w * z) / (np.mean(w[:-1]) + w[-1])",
    stopped_by="irls_step-by-hand",
)
"""Wrong: the lesson's sums, where the denominator has one weight for all the inliers."""

wrong_printed_number = change(
    right_mean, "return new", "return 0.28 if len(z) == 5 else new", caught_by="irls_step-lesson"
)
"""Wrong: the lesson's printed 0.28 for five measurements, typed in."""

wrong_not_whitened = change(right_mean, "/ s / c", "/ c", caught_by="irls_step-lesson")
"""Wrong: weighs the residual as it is, without dividing it by σ."""

wrong_solve_without_sigma = change(right_mean, "w / s**2", "w", caught_by="irls_step-sigmas")
"""Wrong: whitens the residuals but solves as if every σ were the same."""

wrong_weights_at_new_x = change(
    right_mean, "new, w", "new, 1 / (1 + ((z - new) / s / c) ** 2)", stopped_by="irls_step-by-hand"
)
"""Wrong: returns the weights at the new x, which did not lead to it."""

wrong_scale_ignored = change(right_mean, "/ s / c", "/ s", caught_by="irls_step-random")
"""Wrong for c other than 1: compares u with 1."""

wrong_integers = change(
    right_mean,
    ("np.asarray(z, dtype=float)", "np.asarray(z)"),
    ("new =", "w = w.astype(z.dtype)\nnew ="),
    caught_by="irls_step-shapes",
)
"""Wrong for integers: keeps the weights in an array of z's own type."""
