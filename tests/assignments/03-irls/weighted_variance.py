"""Answers to exercise weighted_variance of 03-irls: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_sum() -> None:
    """Right: one over the sum of the information."""

    def weighted_variance(weights, sigma):
        w, s = np.asarray(weights), np.asarray(sigma)
        total = np.sum(w / s**2)
        return 1 / total


def right_plain_loop() -> None:
    """Right: adds up one measurement at a time."""

    def weighted_variance(weights, sigma):
        information = 0
        for i, w in enumerate(weights):
            s = sigma[i] if hasattr(sigma, "__len__") else sigma
            information += w / s**2
        return 1.0 / information


def right_normal_equations() -> None:
    """Right: the inverse of the 1×1 matrix JᵀWJ, with a column of whitened ones for J."""

    def weighted_variance(weights, sigma):
        weights = np.asarray(weights, dtype=float)
        column = (np.ones(weights.size) / np.asarray(sigma, dtype=float))[:, None]
        return np.linalg.inv(column.T @ np.diag(weights) @ column)[0, 0]


def right_harmonic_mean() -> None:
    """Right, an equivalent formula: the harmonic mean of σ²/w over those with weight, by count."""
    from scipy.stats import hmean

    def weighted_variance(weights, sigma):
        w = np.asarray(weights, dtype=float)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), w.shape)
        kept = w > 0
        return float(hmean(s[kept] ** 2 / w[kept]) / np.count_nonzero(kept))


wrong_standard_deviation = change(
    right_sum, "1 / total", "total**-0.5", caught_by="weighted_variance-equal"
)
"""Wrong: returns the standard deviation, the root of the variance."""

wrong_sigma_over_root_n = change(
    right_sum, "1 / total", "np.mean(s) / w.size**0.5", caught_by="weighted_variance-equal"
)
"""Wrong: σ/√n by heart, a standard deviation without any weights."""

wrong_zeros_counted = change(
    right_sum, "1 / total", "np.mean(s**2) / w.size", caught_by="weighted_variance-zeros"
)
"""Wrong: divides σ² by the number of all measurements, the rejected ones among them."""

wrong_sandwich = change(
    right_sum, "1 / total", "np.sum(w**2 / s**2) / total**2", caught_by="weighted_variance-weights"
)
"""Wrong question: the variance of the weighted mean when the noise is σ in every measurement."""

wrong_weights_squared = change(
    right_sum, "w / s**2", "(w / s) ** 2", caught_by="weighted_variance-weights"
)
"""Wrong: adds up w²/σ², as if the weight multiplied the residual before it is squared."""

wrong_mean_sigma = change(
    right_sum, "1 / total", "np.mean(s**2) / np.sum(w)", caught_by="weighted_variance-sigmas"
)
"""Wrong for different sigmas: uses the mean of their squares for all."""
