"""Answers to exercise max_mixture_mode of 06-switches-and-consistency: each body is a cell."""


def right_costs() -> None:
    """Right: the two negative logarithms over whole arrays."""
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        cost_in = r**2 / (2 * sigma_in**2) - np.log(pi_in) + np.log(sigma_in)
        cost_out = r**2 / (2 * sigma_out**2) - np.log(1 - pi_in) + np.log(sigma_out)
        return (cost_out < cost_in).astype(int)


def right_densities() -> None:
    """Right, a library routine: SciPy's normal densities, and the larger of the two."""
    import numpy as np
    from scipy.stats import norm

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        modes = [
            norm.logpdf(r, scale=sigma_in) + np.log(pi_in),
            norm.logpdf(r, scale=sigma_out) + np.log1p(-pi_in),
        ]
        return np.argmax(modes, axis=0)


def right_knee() -> None:
    """Right, an equivalent form: the residual where the mode switches, if there is one."""
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        log_ratio = np.log(pi_in * sigma_out / ((1 - pi_in) * sigma_in))
        square = 2 * log_ratio / (1 / sigma_in**2 - 1 / sigma_out**2)
        return np.where(np.square(np.asarray(r, dtype=float)) > square, 1, 0)


def right_nested_lists() -> None:
    """Right: plain Python, true or false, lists in and lists out."""
    import math

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        if hasattr(r, "__len__"):
            return [max_mixture_mode(one, sigma_in, sigma_out, pi_in) for one in r]
        inlier = math.log(pi_in) - math.log(sigma_in) - 0.5 * (r / sigma_in) ** 2
        outlier = math.log(1 - pi_in) - math.log(sigma_out) - 0.5 * (r / sigma_out) ** 2
        return outlier > inlier


def wrong_only_exponents() -> None:
    """Wrong: compares the exponents alone, so that the broad mode always wins, 0 aside. Stopped by
    the visible case max_mixture_mode-by-hand.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        return np.where((r / sigma_out) ** 2 < (r / sigma_in) ** 2, 1, 0)


def wrong_no_normalisers() -> None:
    """Wrong: the probabilities count, and the factors 1/σ before the exponentials do not: it
    switches at 2.1069. Caught by max_mixture_mode-switch.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        inlier = np.log(pi_in) - (r / sigma_in) ** 2 / 2
        outlier = np.log(1 - pi_in) - (r / sigma_out) ** 2 / 2
        return np.where(outlier > inlier, 1, 0)


def wrong_flat_outliers() -> None:
    """Wrong: neither 1/σ nor the outlier's exponential: it switches at 2.0963. Caught by
    max_mixture_mode-switch.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        return np.where((r / sigma_in) ** 2 / 2 > np.log(pi_in / (1 - pi_in)), 1, 0)


def wrong_variances() -> None:
    """Wrong: divides by the variance σ² before the exponential, and not by σ. Caught by
    max_mixture_mode-switch.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        inlier = np.log(pi_in / sigma_in**2) - (r / sigma_in) ** 2 / 2
        outlier = np.log((1 - pi_in) / sigma_out**2) - (r / sigma_out) ** 2 / 2
        return np.where(outlier > inlier, 1, 0)


def wrong_equal_chances() -> None:
    """Wrong: leaves the probabilities out, as if both modes were as likely. Caught by
    max_mixture_mode-random.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        r = np.asarray(r, dtype=float)
        inlier = -np.log(sigma_in) - (r / sigma_in) ** 2 / 2
        outlier = -np.log(sigma_out) - (r / sigma_out) ** 2 / 2
        return np.where(outlier > inlier, 1, 0)


def wrong_fixed_knee() -> None:
    """Wrong: knows the example's switch at 3.015 sigmas by heart. Caught by
    max_mixture_mode-random.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        return np.where(np.abs(np.asarray(r, dtype=float)) > 3.01505 * sigma_in, 1, 0)


def wrong_root_of_negative() -> None:
    """Wrong when inliers are rare: the switch is the root of a negative number, NaN, and nothing
    lies past it. Caught by max_mixture_mode-everywhere.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        log_ratio = np.log(pi_in * sigma_out / ((1 - pi_in) * sigma_in))
        square = 2 * log_ratio / (1 / sigma_in**2 - 1 / sigma_out**2)
        knee = np.sqrt(square) if square > 0 else 8.5 * sigma_in
        return np.where(np.abs(np.asarray(r, dtype=float)) > knee, 1, 0)


def wrong_sign() -> None:
    """Wrong for negative residuals: compares r, and not its size, with the switch. Caught by
    max_mixture_mode-signs.
    """
    import numpy as np

    def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
        log_ratio = np.log(pi_in * sigma_out / ((1 - pi_in) * sigma_in))
        square = max(0.0, 2 * log_ratio / (1 / sigma_in**2 - 1 / sigma_out**2))
        return np.where(np.asarray(r, dtype=float) > np.sqrt(square), 1, 0)
