"""Answers to exercise irls of 03-irls: each body is a cell as handed in."""


def right_loop() -> None:
    """Right: weigh, solve, append, until the last two agree."""
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x, history = x0, [x0]
        while True:
            w = weight((z - x) / sigma) / sigma**2
            new = np.sum(w * z) / np.sum(w)
            history.append(new)
            if abs(new - x) <= tol:
                return new, history
            x = new


def right_average_and_array() -> None:
    """Right: np.average, a hundred steps at most, and the history as an array."""
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.array(z, dtype=float)
        information = 1 / (np.array(sigma, dtype=float) ** 2 * np.ones(len(z)))
        history = np.array([x0], dtype=float)
        for _ in range(100):
            w = weight((z - history[-1]) * np.sqrt(information))
            history = np.append(history, np.average(z, weights=w * information))
            if np.isclose(history[-1], history[-2], rtol=0, atol=tol):
                break
        return float(history[-1]), history


def right_one_by_one() -> None:
    """Right: plain Python that asks for the weight of one residual at a time; the last step, which
    does not move x any more, is not kept.
    """

    def irls(z, sigma, weight, x0, tol):
        sigmas = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        x, history = float(x0), [float(x0)]
        while True:
            shares = [float(weight((a - x) / s)) / s**2 for a, s in zip(z, sigmas)]
            new = sum(w * a for w, a in zip(shares, z)) / sum(shares)
            if abs(new - x) <= tol:
                return x, history
            x = new
            history.append(x)


def right_gauss_newton() -> None:
    """Right, an equivalent form: adds the weighted mean residual to x, with one step too many."""
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        s = np.ones_like(z) * np.asarray(sigma, dtype=float)
        x, quiet, history = float(x0), 0, (float(x0),)
        while quiet < 2:
            u = (z - x) / s
            w = np.asarray(weight(u))
            delta = np.dot(w / s, u) / np.dot(w / s, 1 / s)
            x = x + delta
            history = (*history, x)
            quiet = quiet + 1 if abs(delta) < tol else 0
        return x, history


def wrong_misprint() -> None:
    """Wrong: stops after three steps, at the lesson's 0.01, which IRLS only passes. Caught by
    irls-fixed-point.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [float(x0)]
        for _ in range(3):
            share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], history


def wrong_loose_stop() -> None:
    """Wrong: stops at a tolerance of its own, a thousandth, whatever tol says. Caught by
    irls-fixed-point.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [float(x0)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > 1e-3:
            share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], history


def wrong_always_the_best() -> None:
    """Wrong: descends from the median too and returns the better end, though x0 was given. Caught
    by irls-start.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        runs = []
        for start in (float(x0), float(np.median(z))):
            history = [start]
            while len(history) < 2 or abs(history[-1] - history[-2]) > tol:
                share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
                history.append(np.dot(share, z) / np.sum(share))
            runs.append(history)
        costs = [np.sum(np.log1p(((z - run[-1]) / sigma) ** 2)) for run in runs]
        best = runs[1] if costs[1] < costs[0] - 1e-6 else runs[0]
        return best[-1], best


def wrong_start_at_the_mean() -> None:
    """Wrong: ignores x0 and starts at the mean. Stopped by the visible case irls-by-hand."""
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [np.mean(z)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > tol:
            share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], history


def wrong_stale_weights() -> None:
    """Wrong: weighs once, at x0, and never again, so the first step is the last. Stopped by the
    visible case irls-fixed-point.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        share = np.asarray(weight((z - x0) / sigma)) / sigma**2
        x = np.dot(share, z) / np.sum(share)
        return x, [x0, x, x]


def wrong_history_with_gaps() -> None:
    """Wrong history: keeps the first two entries and the last one, and drops those between. Caught
    by irls-history.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [float(x0)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > tol:
            share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], [history[0], history[1], history[-1]]


def wrong_half_steps() -> None:
    """Wrong steps: after the first it averages the old x with the new, which ends at the same
    place by other entries. Caught by irls-history.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [float(x0)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > tol / 10:
            share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
            new = np.dot(share, z) / np.sum(share)
            history.append(new if len(history) == 1 else (history[-1] + new) / 2)
        return history[-1], history


def wrong_always_cauchy() -> None:
    """Wrong: Cauchy's weight is written into the loop and the one handed in is ignored. Caught by
    irls-weight.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [float(x0)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > tol:
            share = 1 / (1 + ((z - history[-1]) / sigma) ** 2) / sigma**2
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], history


def wrong_solve_without_sigma() -> None:
    """Wrong: whitens the residuals but solves as if every σ were the same. Caught by
    irls-sigmas.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        history = [float(x0)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > tol:
            share = np.asarray(weight((z - history[-1]) / np.asarray(sigma, dtype=float)))
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], history


def wrong_tolerance_of_its_own() -> None:
    """Wrong: goes on until x stands still to the last digit, whatever tol was handed in. Stopped
    by the visible case irls-tolerance.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        history = [float(x0)]
        while len(history) < 2 or abs(history[-1] - history[-2]) > 1e-12:
            share = np.asarray(weight((z - history[-1]) / sigma)) / sigma**2
            history.append(np.dot(share, z) / np.sum(share))
        return history[-1], history


def wrong_one_hundred_steps() -> None:
    """Wrong: does a hundred steps, and leaves tol out of account. Stopped by the visible case
    irls-tolerance.
    """
    import numpy as np

    def irls(z, sigma, weight, x0, tol):
        history = [x0]
        for _ in range(100):
            u = (np.asarray(z) - history[-1]) / np.asarray(sigma)
            share = np.asarray(weight(u)) / np.square(sigma)
            history.append(np.average(z, weights=share))
        return history[-1], history
