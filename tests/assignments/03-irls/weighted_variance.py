"""Answers to exercise weighted_variance of 03-irls: each body is a cell as handed in."""


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


def wrong_standard_deviation() -> None:
    """Wrong: returns the standard deviation, the root of the variance. Caught by
    weighted_variance-equal.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        return 1 / np.sqrt(np.sum(np.asarray(weights) / np.asarray(sigma) ** 2))


def wrong_sigma_over_root_n() -> None:
    """Wrong: σ/√n by heart, a standard deviation that knows no weights. Caught by
    weighted_variance-equal.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        return np.mean(sigma) / np.sqrt(np.size(weights))


def wrong_zeros_counted() -> None:
    """Wrong: divides σ² by the number of all measurements, the rejected ones among them. Caught by
    weighted_variance-zeros.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        return np.mean(np.square(sigma)) / np.size(weights)


def wrong_sandwich() -> None:
    """Wrong question: the variance of the weighted mean when the noise is σ in every measurement,
    w² over the square of the sum. Caught by weighted_variance-weights.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        share = np.asarray(weights) / np.asarray(sigma) ** 2
        return np.sum(share**2 * np.square(sigma)) / np.sum(share) ** 2


def wrong_weights_squared() -> None:
    """Wrong: adds up w²/σ², as if the weight stood on the residual before it is squared. Caught by
    weighted_variance-weights.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        return 1 / np.sum((np.asarray(weights) / np.asarray(sigma)) ** 2)


def wrong_mean_sigma() -> None:
    """Wrong for different sigmas: uses the mean of their squares for all. Caught by
    weighted_variance-sigmas.
    """
    import numpy as np

    def weighted_variance(weights, sigma):
        return np.mean(np.square(sigma)) / np.sum(weights)
