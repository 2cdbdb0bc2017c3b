"""Answers to exercise gnc_tls_weight of 05-gnc: each body is a cell as handed in."""


def right_pieces() -> None:
    """Right: the three pieces as they stand in the statement."""
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        size = np.abs(np.asarray(u, dtype=float))
        low, high = c**2 * mu / (mu + 1), c**2 * (mu + 1) / mu
        safe = np.where(size > 0, size, 1.0)
        between = c / safe * np.sqrt(mu * (mu + 1)) - mu
        return np.where(size**2 <= low, 1.0, np.where(size**2 >= high, 0.0, between))


def right_clip() -> None:
    """Right: the middle piece alone, clipped to what a weight can be; 1/0 is infinite."""
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        with np.errstate(divide="ignore"):
            between = c * np.sqrt(mu**2 + mu) / np.abs(np.asarray(u, dtype=float)) - mu
        return np.clip(between, 0.0, 1.0)


def right_loop() -> None:
    """Right: plain Python, one number at a time, nested lists in and out."""
    from math import sqrt

    import numpy as np

    def gnc_tls_weight(u, c, mu):
        if np.ndim(u) > 0:
            return [gnc_tls_weight(one, c, mu) for one in u]
        square = float(u) ** 2
        if square * (mu + 1) <= c**2 * mu:
            return 1.0
        if square * mu >= c**2 * (mu + 1):
            return 0.0
        return c * sqrt(mu * (mu + 1)) / sqrt(square) - mu


def right_outlier_process() -> None:
    """Right, an equivalent form: SciPy minimises w u²/2 plus the price of w over 0 ≤ w ≤ 1."""
    import numpy as np
    from scipy.optimize import brentq

    def gnc_tls_weight(u, c, mu):
        def best(size):
            def slope(w):
                return size**2 - c**2 * mu * (mu + 1) / (mu + w) ** 2

            if slope(1.0) <= 0:
                return 1.0
            return 0.0 if slope(0.0) >= 0 else brentq(slope, 0.0, 1.0, xtol=1e-15)

        u = np.asarray(u, dtype=float)
        return np.array([best(abs(one)) for one in u.ravel()]).reshape(u.shape)


def wrong_misprint_surrogate() -> None:
    """Wrong: the weight of the lesson's printed surrogate, which never becomes TLS. Stopped by the
    visible case gnc_tls_weight-by-hand.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        u = np.asarray(u, dtype=float)
        return c**4 * mu * (mu + 1) / ((mu + 1) * c**2 + u**2) ** 2


def wrong_no_middle_piece() -> None:
    """Wrong: 1 inside c and 0 past it, as if μ were infinite. Stopped by the visible case
    gnc_tls_weight-by-hand.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        return np.where(np.abs(u) <= c, 1.0, 0.0)


def wrong_c_for_c_squared() -> None:
    """Wrong for c other than 1: the knees stand at c μ/(μ+1) and c (μ+1)/μ. Stopped by the
    visible case gnc_tls_weight-middle.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        size = np.maximum(np.abs(np.asarray(u, dtype=float)), 1e-300)
        low, high = c * mu / (mu + 1), c * (mu + 1) / mu
        between = c * np.sqrt(mu * (mu + 1)) / size - mu
        return np.where(size**2 <= low, 1.0, np.where(size**2 >= high, 0.0, between))


def wrong_c_squared_in_the_middle() -> None:
    """Wrong for c other than 1: c² stands over |u| in the middle piece. Stopped by the visible
    case gnc_tls_weight-middle.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        size = np.maximum(np.abs(np.asarray(u, dtype=float)), 1e-300)
        low, high = c**2 * mu / (mu + 1), c**2 * (mu + 1) / mu
        between = c**2 * np.sqrt(mu * (mu + 1)) / size - mu
        return np.where(size**2 <= low, 1.0, np.where(size**2 >= high, 0.0, between))


def wrong_knees_of_u() -> None:
    """Wrong: compares |u| with c μ/(μ+1), where the condition is on u². Stopped by the visible
    case gnc_tls_weight-knees.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        size = np.maximum(np.abs(np.asarray(u, dtype=float)), 1e-300)
        low, high = c * mu / (mu + 1), c * (mu + 1) / mu
        between = c * np.sqrt(mu * (mu + 1)) / size - mu
        return np.where(size <= low, 1.0, np.where(size >= high, 0.0, between))


def wrong_straight_middle() -> None:
    """Wrong: the weight falls in a straight line between the knees, with the right value in the
    middle of the example. Caught by gnc_tls_weight-middle.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        size = np.abs(np.asarray(u, dtype=float))
        low, high = c * np.sqrt(mu / (mu + 1)), c * np.sqrt((mu + 1) / mu)
        exact = np.sqrt(mu * (mu + 1)) * c / np.maximum(size, low) - mu
        line = np.interp(size, [low, high], [1.0, 0.0])
        return np.where(mu == 1.0, np.clip(exact, 0.0, 1.0), line)


def wrong_one_sided() -> None:
    """Wrong left of zero: every negative residual is an inlier. Caught by
    gnc_tls_weight-negative.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        u = np.asarray(u, dtype=float)
        between = c * np.sqrt(mu * (mu + 1)) / np.maximum(u, 1e-300) - mu
        return np.clip(between, 0.0, 1.0)


def wrong_zero_over_zero() -> None:
    """Wrong at 0: divides ρ' = u by u there, and NaN comes out. Caught by gnc_tls_weight-zero."""
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        u = np.asarray(u, dtype=float)
        size = np.abs(u)
        slope = c * np.sqrt(mu * (mu + 1)) - mu * size
        slope = np.where(size**2 <= c**2 * mu / (mu + 1), size, slope)
        with np.errstate(all="ignore"):
            return np.where(size**2 >= c**2 * (mu + 1) / mu, 0.0, slope) / size


def wrong_way_of_mu() -> None:
    """Wrong: takes 1/μ for μ, so that a large μ is soft; at μ = 1 the two agree. Stopped by the
    visible case gnc_tls_weight-hard.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        mu = 1 / mu
        size = np.maximum(np.abs(np.asarray(u, dtype=float)), 1e-300)
        return np.clip(c * np.sqrt(mu * (mu + 1)) / size - mu, 0.0, 1.0)


def wrong_flat_shape() -> None:
    """Wrong for arrays of two dimensions: returns one flat row. Caught by
    gnc_tls_weight-shapes.
    """
    import numpy as np

    def gnc_tls_weight(u, c, mu):
        size = np.maximum(np.abs(np.asarray(u, dtype=float)), 1e-300)
        weights = np.clip(c * np.sqrt(mu * (mu + 1)) / size - mu, 0.0, 1.0)
        return weights.ravel() if weights.ndim else weights
