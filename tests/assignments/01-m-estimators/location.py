"""Answers to exercise location of 01-m-estimators: each body is a cell as handed in."""


def right_loop() -> None:
    """Right: weigh, solve, compare, over whole arrays."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x = float(x0)
        while True:
            share = weight((z - x) / sigma) / sigma**2
            new = np.sum(share * z) / np.sum(share)
            if abs(new - x) <= tol:
                return new
            x = new


def right_average() -> None:
    """Right: np.average, and two hundred steps whatever happens."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z = np.array(z, dtype=float)
        information = np.ones(z.size) / np.square(sigma)
        x = x0
        for _ in range(200):
            x, old = np.average(z, weights=information * weight((z - x) / sigma)), x
            if abs(x - old) < tol / 10 or x == old:
                break
        return float(x)


def right_increment() -> None:
    """Right, an equivalent form: the step is the weighted mean residual, added to x."""
    import numpy as np

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
    """Right: sums in plain Python; the residuals go to the weight in one call, the other way
    round, which an even weight does not mind.
    """
    import numpy as np

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
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = float(x0), np.inf
        while abs(x - old) > tol:
            row = np.sqrt(weight((z - x) / s)) / s
            old, x = x, np.linalg.lstsq(row[:, None], row * z, rcond=None)[0][0]
        return x


def wrong_one_step() -> None:
    """Wrong: weighs and solves once. Stopped by the visible case location-by-hand."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        return np.average(z, weights=weight((z - x0) / s) / s**2)


def wrong_loose_stop() -> None:
    """Wrong: stops at a tolerance of its own, whatever tol says. Stopped by the visible case
    location-by-hand.
    """
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > 1e-3:
            x, old = np.average(z, weights=weight((z - x) / s) / s**2), x
        return x


def wrong_weight_squared() -> None:
    """Wrong: the square of the weight, as if it stood on the residual before that is squared.
    Stopped by the visible case location-by-hand.
    """
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=(weight((z - x) / s) / s) ** 2), x
        return x


def wrong_median() -> None:
    """Wrong for many measurements: the median, a robust estimate but another one. Stopped by the
    visible case location-lesson.
    """
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        if len(z) > 100:
            return float(np.median(z))
        x, old = x0, np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight((z - x) / s) / s**2), x
        return x


def wrong_outlier_dropped() -> None:
    """Wrong: throws out a measurement of little weight, which takes its last pull away. Caught by
    location-lesson.
    """
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > tol:
            w = np.asarray(weight((z - x) / s), dtype=float)
            w = np.where(w < 1e-3, 0.0, w)
            x, old = np.average(z, weights=w / s**2), x
        return x


def wrong_not_whitened() -> None:
    """Wrong: weighs the residual as it is, without dividing it by σ. Caught by location-huber."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight(z - x) / s**2), x
        return x


def wrong_start_at_the_median() -> None:
    """Wrong: ignores x0 and starts in the middle. Stopped by the visible case location-start."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = np.median(z), np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight((z - x) / s) / s**2), x
        return x


def wrong_start_at_the_first() -> None:
    """Wrong: ignores x0 and starts at the first measurement. Caught by location-start."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = z[0], np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight((z - x) / s) / s**2), x
        return x


def wrong_solve_without_sigma() -> None:
    """Wrong: whitens the residuals but solves as if every σ were the same. Stopped by the visible
    case location-sigmas.
    """
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight((z - x) / s)), x
        return x


def wrong_mean_sigma_in_the_weight() -> None:
    """Wrong: whitens with the mean σ and solves with each one's own. Caught by location-sigmas."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z, s = np.asarray(z, dtype=float), np.ones(len(z)) * np.asarray(sigma, dtype=float)
        x, old = x0, np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight((z - x) / np.mean(s)) / s**2), x
        return x


def wrong_integers() -> None:
    """Wrong for integers: squares and divides in whole numbers. Caught by location-shapes."""
    import numpy as np

    def location(z, sigma, weight, x0, tol):
        z = np.asarray(z)
        s = np.broadcast_to(np.asarray(sigma), z.shape)
        information = 1 / s**2 if s.dtype == float else 36 // s**2
        x, old = x0, np.inf
        while abs(x - old) > tol:
            x, old = np.average(z, weights=weight((z - x) / s) * information), x
        return x
