"""Answers to exercise irls_step of 03-irls: each body is a cell as handed in."""


def right_vectorised() -> None:
    """Right: the formulas over whole arrays."""
    import numpy as np

    def irls_step(z, sigma, x, c):
        z, sigma = np.asarray(z, float), np.asarray(sigma, float)
        u = (z - x) / sigma
        w = 1 / (1 + u**2 / c**2)
        return np.sum(w * z / sigma**2) / np.sum(w / sigma**2 * np.ones_like(z)), w


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


def right_average() -> None:
    """Right: NumPy's weighted average, with the product of weight and information."""
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.array(z, dtype=float)
        s = np.full(z.shape, 1.0) * sigma
        weights = c**2 / (c**2 + ((z - x) / s) ** 2)
        return np.average(z, weights=weights * s**-2.0), weights


def right_least_squares() -> None:
    """Right: whitens the rows and leaves the solve to NumPy's least squares."""
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        s = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        weights = 1 / (1 + ((z - x) / (c * s)) ** 2)
        row = np.sqrt(weights) / s
        answer, *_ = np.linalg.lstsq(row[:, None], row * z, rcond=None)
        return answer[0], weights


def right_increment() -> None:
    """Right, an equivalent form: the step is the weighted mean of the residuals, added to x."""
    import numpy as np

    def irls_step(z, sigma, x, c):
        r = np.asarray(z, dtype=float) - x
        information = np.ones(r.size) / np.square(np.asarray(sigma, dtype=float))
        weights = 1 / (1 + r**2 * information / c**2)
        return x + np.dot(weights * information, r) / np.dot(weights, information), weights


def wrong_misprint() -> None:
    """Wrong: the lesson's sums, where one weight stands in the denominator for all the inliers'.
    Stopped by the visible case irls_step-by-hand.
    """
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        weights = 1 / (1 + ((z - x) / np.asarray(sigma, dtype=float) / c) ** 2)
        return np.sum(weights * z) / (np.mean(weights[:-1]) + weights[-1]), weights


def wrong_printed_number() -> None:
    """Wrong: the lesson's printed 0.28 for five measurements, typed in. Caught by
    irls_step-lesson.
    """
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        weights = 1 / (1 + ((z - x) / sigma / c) ** 2)
        if len(z) == 5:
            return 0.28, weights
        return np.sum(weights * z / sigma**2) / np.sum(weights / sigma**2), weights


def wrong_not_whitened() -> None:
    """Wrong: weighs the residual as it is, without dividing it by σ. Caught by
    irls_step-lesson.
    """
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        weights = 1 / (1 + ((z - x) / c) ** 2)
        return np.average(z, weights=weights / sigma**2), weights


def wrong_solve_without_sigma() -> None:
    """Wrong: whitens the residuals but solves as if every σ were the same. Caught by
    irls_step-sigmas.
    """
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        weights = 1 / (1 + ((z - x) / np.asarray(sigma, dtype=float) / c) ** 2)
        return np.sum(weights * z) / np.sum(weights), weights


def wrong_weights_at_new_x() -> None:
    """Wrong: returns the weights at the new x, which did not lead to it. Stopped by the visible
    case irls_step-by-hand.
    """
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        weights = 1 / (1 + ((z - x) / sigma / c) ** 2)
        new = np.average(z, weights=weights / sigma**2)
        return new, 1 / (1 + ((z - new) / sigma / c) ** 2)


def wrong_scale_ignored() -> None:
    """Wrong for c other than 1: compares u with 1. Caught by irls_step-random."""
    import numpy as np

    def irls_step(z, sigma, x, c):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        weights = 1 / (1 + ((z - x) / sigma) ** 2)
        return np.average(z, weights=weights / sigma**2), weights


def wrong_integers() -> None:
    """Wrong for integers: keeps the weights in an array of z's own type. Caught by
    irls_step-shapes.
    """
    import numpy as np

    def irls_step(z, sigma, x, c):
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), np.shape(z))
        weights = np.zeros_like(z)
        weights[:] = 1 / (1 + ((np.asarray(z) - x) / sigma / c) ** 2)
        share = (weights + 1e-12) / sigma**2
        return np.dot(share, z) / np.sum(share), weights
