"""Answers to exercise tls_descent of 04-non-convexity: each body is a cell as handed in."""


def right_mask() -> None:
    """Right: keeps, averages, and stops when the same measurements are kept."""
    import numpy as np

    def tls_descent(z, c, x0):
        z = np.asarray(z, dtype=float)
        x, before = float(x0), None
        while True:
            kept = np.abs(x - z) <= c
            if not kept.any() or (before is not None and np.array_equal(kept, before)):
                return x
            x, before = z[kept].mean(), kept


def right_plain_python() -> None:
    """Right: lists and a for loop that is long enough."""

    def tls_descent(z, c, x0):
        x = x0
        for _ in range(1000):
            kept = [a for a in z if abs(a - x) <= c]
            if kept:
                x = sum(kept) / len(kept)
        return x


def right_weights() -> None:
    """Right: a weighted mean of zeros and ones, until x moves less than rounding."""
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.array(z, dtype=float), np.float64(x0)
        while True:
            w = np.where(np.abs(z - x) <= c, 1.0, 0.0)
            if np.sum(w) == 0:
                return x
            new = np.average(z, weights=w)
            if abs(new - x) < 1e-12:
                return new
            x = new


def right_recursion() -> None:
    """Right: one step, and the descent from there; adds the mean residual to x."""
    import numpy as np

    def tls_descent(z, c, x0):
        residuals = np.asarray(z, dtype=float) - x0
        kept = residuals[np.abs(residuals) <= c]
        step = float(np.mean(kept)) if len(kept) else 0.0
        return float(x0) if abs(step) < 1e-11 else tls_descent(z, c, x0 + step)


def wrong_misprint() -> None:
    """Wrong: who starts near 10 ends at 10, as the lesson says without a c: always the nearest.
    Stopped by the visible case tls_descent-lesson.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z = np.asarray(z, dtype=float)
        return z[np.argmin(np.abs(z - x0))]


def wrong_nan() -> None:
    """Wrong where nobody is kept: the mean of nothing is NaN. Caught by tls_descent-flat."""
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            w = np.where(np.abs(x - z) <= c, 1.0, 0.0)
            with np.errstate(invalid="ignore"):
                x = np.sum(w * z) / np.sum(w)
        return x


def wrong_tiny_number() -> None:
    """Wrong where nobody is kept: a tiny number in the denominator takes x to 0. Caught by
    tls_descent-flat.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            w = np.where(np.abs(x - z) <= c, 1.0, 0.0)
            x = np.sum(w * z) / (np.sum(w) + 1e-12)
        return x


def wrong_fit_wanted() -> None:
    """Wrong here: raises ValueError where nobody is kept, as in assignment 03. Stopped by the
    visible case tls_descent-flat.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            kept = z[np.abs(x - z) <= c]
            if kept.size == 0:
                raise ValueError("no measurement is left")
            x = np.mean(kept)
        return x


def wrong_nearest_when_flat() -> None:
    """Wrong where nobody is kept: goes to the nearest measurement, though nothing pulls. Caught by
    tls_descent-flat.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            kept = z[np.abs(x - z) <= c]
            x = np.mean(kept) if kept.size else z[np.argmin(np.abs(z - x))]
        return x


def wrong_one_step() -> None:
    """Wrong: one mean, and no second look. Stopped by the visible case tls_descent-steps."""
    import numpy as np

    def tls_descent(z, c, x0):
        z = np.asarray(z, dtype=float)
        kept = z[np.abs(x0 - z) <= c]
        return np.mean(kept) if kept.size else float(x0)


def wrong_dropped_for_good() -> None:
    """Wrong: a measurement that was dropped once never comes back. Stopped by the
    visible case tls_descent-steps.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            kept = z[np.abs(x - z) <= c]
            if kept.size == 0:
                return x
            z, x = kept, np.mean(kept)
        return x


def wrong_from_the_mean() -> None:
    """Wrong: starts at the mean and ignores x0. Stopped by the visible case
    tls_descent-by-hand.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z = np.asarray(z, dtype=float)
        x = np.mean(z)
        for _ in range(100):
            kept = z[np.abs(x - z) <= c]
            x = np.mean(kept) if kept.size else x
        return x


def wrong_c_squared() -> None:
    """Wrong: compares the square with c. Stopped by the visible case tls_descent-by-hand."""
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            kept = z[np.square(x - z) <= c]
            x = np.mean(kept) if kept.size else x
        return x


def wrong_one_sided() -> None:
    """Wrong for measurements far below x: forgets the absolute value. Stopped by the visible case
    tls_descent-by-hand.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            kept = z[z - x <= c]
            x = np.mean(kept) if kept.size else x
        return x


def wrong_at_the_knee() -> None:
    """Wrong at |x - z| = c: drops a measurement that the inner piece keeps. Caught by
    tls_descent-shapes.
    """
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), float(x0)
        for _ in range(100):
            kept = z[np.abs(x - z) < c]
            x = np.mean(kept) if kept.size else x
        return x


def wrong_integers() -> None:
    """Wrong for integers: whole-number division. Caught by tls_descent-shapes."""
    import numpy as np

    def tls_descent(z, c, x0):
        x = x0
        for _ in range(100):
            kept = [a for a in z if abs(a - x) <= c]
            if kept:
                total = sum(kept)
                whole = all(isinstance(a, (int, np.integer)) for a in kept)
                x = total // len(kept) if whole else total / len(kept)
        return x


def wrong_fifty_steps() -> None:
    """Wrong for long descents: stops after fifty steps. Caught by tls_descent-steps."""
    import numpy as np

    def tls_descent(z, c, x0):
        z, x = np.asarray(z, dtype=float), x0
        for _ in range(50):
            kept = z[np.abs(x - z) <= c]
            x = np.mean(kept) if kept.size else x
        return x
