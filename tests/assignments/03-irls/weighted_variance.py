"""Answers to exercise weighted_variance of 03-irls: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_sum() -> None:
    """Right: one over the sum of the information."""
    import numpy as np

    def weighted_variance(weights, sigma):
        return 1 / np.sum(np.asarray(weights) / np.asarray(sigma) ** 2)


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
    import numpy as np

    def weighted_variance(weights, sigma):
        weights = np.asarray(weights, dtype=float)
        column = (np.ones(weights.size) / np.asarray(sigma, dtype=float))[:, None]
        return np.linalg.inv(column.T @ np.diag(weights) @ column)[0, 0]


def right_harmonic_mean() -> None:
    """Right, an equivalent formula: the harmonic mean of σ²/w over those with weight, by count."""
    import numpy as np
    from scipy.stats import hmean

    def weighted_variance(weights, sigma):
        w = np.asarray(weights, dtype=float)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), w.shape)
        kept = w > 0
        return float(hmean(s[kept] ** 2 / w[kept]) / np.count_nonzero(kept))


wrong_standard_deviation = change(
    right_sum,
    "np.sum(np.asarray(weights) / np.asarray(sigma) ** 2)",
    "np.sqrt(np.sum(np.asarray(weights) / np.asarray(sigma) ** 2))",
    caught_by="weighted_variance-equal",
)
"""Wrong: returns the standard deviation, the root of the variance."""

wrong_sigma_over_root_n = change(
    right_sum,
    "1 / np.sum(np.asarray(weights) / np.asarray(sigma) ** 2)",
    "np.mean(sigma) / np.sqrt(np.size(weights))",
    caught_by="weighted_variance-equal",
)
"""Wrong: σ/√n by heart, a standard deviation that knows no weights."""

wrong_zeros_counted = change(
    right_sum,
    "1 / np.sum(np.asarray(weights) / np.asarray(sigma) ** 2)",
    "np.mean(np.square(sigma)) / np.size(weights)",
    caught_by="weighted_variance-zeros",
)
"""Wrong: divides σ² by the number of all measurements, the rejected ones among them."""


def wrong_sandwich() -> None:
    """Wrong question: the variance of the weighted mean when the noise is σ in every measurement,
    w² over the square of the sum. Caught by weighted_variance-weights.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        share = np.asarray(weights) / np.asarray(sigma) ** 2
        return np.sum(share**2 * np.square(sigma)) / np.sum(share) ** 2


wrong_weights_squared = change(
    right_sum,
    "np.asarray(weights) / np.asarray(sigma) ** 2",
    "(np.asarray(weights) / np.asarray(sigma)) ** 2",
    caught_by="weighted_variance-weights",
)
"""Wrong: adds up w²/σ², as if the weight stood on the residual before it is squared."""

wrong_mean_sigma = change(
    right_sum,
    "1 / np.sum(np.asarray(weights) / np.asarray(sigma) ** 2)",
    "np.mean(np.square(sigma)) / np.sum(weights)",
    caught_by="weighted_variance-sigmas",
)
"""Wrong for different sigmas: uses the mean of their squares for all."""
