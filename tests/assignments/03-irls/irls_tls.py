"""Answers to exercise irls_tls of 03-irls: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_loop() -> None:
    """Right: weigh, look whether anyone is left, solve."""
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x = x0
        while True:
            w = np.where(np.abs(z - x) / sigma <= c, 1.0, 0.0)
            if w.sum() == 0:
                raise ValueError("every measurement was rejected")
            new = np.sum(w * z / sigma**2) / np.sum(w / sigma**2)
            if abs(new - x) <= tol:
                return new, w
            x = new


def right_plain_lists() -> None:
    """Right: plain Python; stops when the set of those that are left no longer changes."""

    def irls_tls(z, sigma, c, x0, tol):
        s = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        x, left = float(x0), None
        while True:
            now = [i for i in range(len(z)) if abs(z[i] - x) <= c * s[i]]
            if not now:
                raise ValueError("nobody is left")
            if now == left:
                return x, [1 if i in now else 0 for i in range(len(z))]
            left = now
            x = sum(z[i] / s[i] ** 2 for i in now) / sum(1 / s[i] ** 2 for i in now)


def right_masked_average() -> None:
    """Right: a boolean mask, NumPy's average of what it keeps, weights as truth values."""
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.array(z, dtype=float)
        s = np.zeros(z.shape) + np.asarray(sigma, dtype=float)
        x = previous = float(x0)
        for _ in range(1000):
            keep = ((z - x) / s) ** 2 <= c**2
            if not keep.any():
                raise ValueError(f"no residual is within {c} of {x}")
            x = np.average(z[keep], weights=1 / s[keep] ** 2)
            if abs(x - previous) < tol:
                break
            previous = x
        return x, keep


def right_library_error() -> None:
    """Right: lets the division fail and turns its error into the ValueError that is asked for."""
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z, s = np.broadcast_arrays(np.asarray(z, dtype=float), np.asarray(sigma, dtype=float))
        x, moved = x0, np.inf
        while moved > tol:
            w = (np.abs((z - x) / s) <= c).astype(float)
            try:
                new = float(np.average(z, weights=w / s**2))
            except ZeroDivisionError as error:
                raise ValueError("no fit exists") from error
            moved, x = abs(new - x), new
        return x, w


def wrong_nan() -> None:
    """Wrong when nobody is left: divides 0 by 0 and returns NaN. Caught by irls_tls-empty."""
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x = x0
        for _ in range(100):
            w = np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
            x = np.sum(w * z / sigma**2) / np.sum(w / sigma**2)
        return x, np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)


def wrong_padded_denominator() -> None:
    """Wrong when nobody is left: a small number added below turns 0/0 into 0. Caught by
    irls_tls-empty.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x = x0
        for _ in range(100):
            w = np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
            x = np.sum(w * z / sigma**2) / (np.sum(w / sigma**2) + 1e-9)
        return x, w


wrong_keeps_the_last_x = change(
    right_loop,
    """
    w = np.where(np.abs(z - x) / sigma <= c, 1.0, 0.0)
    if w.sum() == 0:
        raise ValueError("every measurement was rejected")
    """,
    """
    w = np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
    if not w.any():
        return x, w
    """,
    caught_by="irls_tls-empty",
)
"""Wrong when nobody is left: returns the point where it stands as if it were a fit."""


def wrong_other_error() -> None:
    """Wrong when nobody is left: the error that comes is np.average's ZeroDivisionError. Caught by
    irls_tls-empty.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x, moved = x0, np.inf
        while moved > tol:
            w = np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
            new = np.average(z, weights=w / sigma**2)
            moved, x = abs(new - x), new
        return x, w


def wrong_first_zero() -> None:
    """Wrong: gives up at the first weight of 0, though others are left. Stopped by the visible
    case irls_tls-by-hand.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x, moved = x0, np.inf
        while moved > tol:
            w = np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
            if not w.all():
                raise ValueError("a measurement has no weight")
            new = np.average(z, weights=w / sigma**2)
            moved, x = abs(new - x), new
        return x, w


def wrong_guard_on_the_sum() -> None:
    """Wrong for large σ: takes a small sum of w/σ² for none. Caught by irls_tls-tiny."""
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x, moved = x0, np.inf
        while moved > tol:
            w = np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
            if np.sum(w / sigma**2) < 1e-9:
                raise ValueError("no measurement is left")
            new = np.average(z, weights=w / sigma**2)
            moved, x = abs(new - x), new
        return x, w


def wrong_one_step() -> None:
    """Wrong: weighs and solves once, where the weights change from step to step. Caught by
    irls_tls-random.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        w = np.where(np.abs((z - x0) / sigma) <= c, 1.0, 0.0)
        if not w.any():
            raise ValueError("no measurement is left")
        return np.average(z, weights=w / sigma**2), w


def wrong_never_back() -> None:
    """Wrong: a measurement that was dropped once stays out for ever. Caught by irls_tls-random."""
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        w, x, moved = np.ones(z.shape), x0, np.inf
        while moved > tol:
            w = w * np.where(np.abs((z - x) / sigma) <= c, 1.0, 0.0)
            if not w.any():
                raise ValueError("no measurement is left")
            new = np.average(z, weights=w / sigma**2)
            moved, x = abs(new - x), new
        return x, w


def wrong_solve_without_sigma() -> None:
    """Wrong: takes the plain mean of those that are left, whatever their σ. Caught by
    irls_tls-sigmas.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        x, moved = x0, np.inf
        while moved > tol:
            keep = np.abs((z - x) / np.asarray(sigma, dtype=float)) <= c
            if not keep.any():
                raise ValueError("no measurement is left")
            moved, x = abs(np.mean(z[keep]) - x), np.mean(z[keep])
        return x, keep


def wrong_open_threshold() -> None:
    """Wrong at the threshold itself: drops the measurements at |u| = c. Caught by
    irls_tls-knee.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x, moved = x0, np.inf
        while moved > tol:
            w = np.where(np.abs((z - x) / sigma) < c, 1.0, 0.0)
            if not w.any():
                raise ValueError("no measurement is left")
            new = np.average(z, weights=w / sigma**2)
            moved, x = abs(new - x), new
        return x, w


def wrong_weights_of_the_kept_only() -> None:
    """Wrong weights: returns only those of the measurements that are left. Stopped by the visible
    case irls_tls-by-hand.
    """
    import numpy as np

    def irls_tls(z, sigma, c, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x, moved = x0, np.inf
        while moved > tol:
            keep = np.abs((z - x) / sigma) <= c
            if not keep.any():
                raise ValueError("no measurement is left")
            new = np.average(z[keep], weights=1 / sigma[keep] ** 2)
            moved, x = abs(new - x), new
        return x, np.ones(np.count_nonzero(keep))
