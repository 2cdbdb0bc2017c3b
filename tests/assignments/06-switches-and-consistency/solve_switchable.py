"""Answers to exercise solve_switchable of 06-switches-and-consistency: each body is a cell."""


def right_in_turns() -> None:
    """Right: switches and x in turns, until x stands still."""
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        loops = np.asarray(is_loop, dtype=bool)
        s = np.ones(len(z))
        x = np.sum(z / sigma**2) / np.sum(1 / sigma**2)
        while True:
            s[loops] = lam / (lam + ((z - x) / sigma)[loops] ** 2)
            new = np.sum(s**2 * z / sigma**2) / np.sum(s**2 / sigma**2)
            if abs(new - x) <= 1e-12:
                return new, s
            x = new


def right_plain_lists() -> None:
    """Right: plain Python, a list of switches."""

    def solve_switchable(z, sigma, is_loop, lam):
        sigmas = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        s = [1.0] * len(z)
        for _ in range(400):
            top = sum(k * k * a / d**2 for k, a, d in zip(s, z, sigmas))
            x = top / sum(k * k / d**2 for k, d in zip(s, sigmas))
            for i, doubted in enumerate(is_loop):
                if doubted:
                    s[i] = lam / (lam + ((z[i] - x) / sigmas[i]) ** 2)
        return x, s


def right_root_of_the_slope() -> None:
    """Right, an equivalent form: eliminates the switches and finds where the slope is zero."""
    import numpy as np
    from scipy.optimize import brentq

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.asarray(sigma, dtype=float) * np.ones(z.shape)

        def switches(x):
            return np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0)

        def slope(x):
            return np.sum(switches(x) ** 2 * (x - z) / sigma**2)

        x = brentq(slope, z.min() - 1, z.max() + 1, xtol=1e-13)
        return x, switches(x)


def right_joint_least_squares() -> None:
    """Right, a library routine: x and the switches of the loops together, as in the paper."""
    import numpy as np
    from scipy.optimize import least_squares

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        loops = np.flatnonzero(is_loop)

        def spread(v):
            s = np.ones(z.size)
            s[loops] = v[1:]
            return s

        def rows(v):
            return np.append(spread(v) * (z - v[0]) / sigma, np.sqrt(lam) * (1 - v[1:]))

        def jacobian(v):
            turned = np.zeros((z.size, loops.size))
            turned[loops, np.arange(loops.size)] = ((z - v[0]) / sigma)[loops]
            top = np.column_stack([-spread(v) / sigma, turned])
            bottom = np.column_stack([np.zeros(loops.size), -np.sqrt(lam) * np.eye(loops.size)])
            return np.vstack([top, bottom])

        start = np.append(np.average(z, weights=sigma**-2.0), np.ones(loops.size))
        best = least_squares(rows, start, jacobian, xtol=1e-15, ftol=1e-15, gtol=1e-12)
        return best.x[0], spread(best.x)


def wrong_no_price() -> None:
    """Wrong: without the price nothing holds a switch, and all loops are turned off. Stopped by
    the visible case solve_switchable-by-hand.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        s = np.where(is_loop, 0.0, 1.0)
        return np.average(z, weights=s / sigma**2), s


def wrong_loops_and_odometry_confused() -> None:
    """Wrong: the mask is read the other way round, and the trusted ones are doubted. Stopped by
    the visible case solve_switchable-by-hand.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        s = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=(s / sigma) ** 2)
            s = np.where(is_loop, 1.0, lam / (lam + ((z - x) / sigma) ** 2))
        return x, s


def wrong_everybody_doubted() -> None:
    """Wrong: the solve doubts every measurement, and the switches that are returned are mended
    afterwards. Stopped by the visible case solve_switchable-by-hand.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        s = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=(s / sigma) ** 2)
            s = lam / (lam + ((z - x) / sigma) ** 2)
        return x, np.where(is_loop, s, 1.0)


def wrong_one_round() -> None:
    """Wrong: sets the switches at plain least squares, solves once, and stops. Stopped by the
    visible case solve_switchable-by-hand.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        x = np.average(z, weights=sigma**-2.0)
        s = np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0)
        return np.average(z, weights=(s / sigma) ** 2), s


def wrong_weight_not_squared() -> None:
    """Wrong: the switch itself is the weight, as if it scaled χ² and not the residual. Stopped
    by the visible case solve_switchable-by-hand.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        s = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=s / sigma**2)
            s = np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0)
        return x, s


def wrong_returns_weights() -> None:
    """Wrong: returns the weights s², and not the switches. Stopped by the visible case
    solve_switchable-by-hand.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        w = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=w / sigma**2)
            w = np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0) ** 2
        return x, w


def wrong_one_switch_for_all() -> None:
    """Wrong: all loops share one switch, from the mean of their χ². Caught by
    solve_switchable-outliers.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        loops = np.asarray(is_loop, dtype=bool)
        s = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=(s / sigma) ** 2)
            if loops.any():
                s[loops] = lam / (lam + np.mean((((z - x) / sigma) ** 2)[loops]))
        return x, s


def wrong_not_whitened() -> None:
    """Wrong: sets the switches from z - x, without dividing it by σ. Caught by
    solve_switchable-sigmas.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        s = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=(s / sigma) ** 2)
            s = np.where(is_loop, lam / (lam + (z - x) ** 2), 1.0)
        return x, s


def wrong_loose_stop() -> None:
    """Wrong: stops as soon as x moves by less than a hundredth. Caught by
    solve_switchable-balance.
    """
    import numpy as np

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.broadcast_to(np.asarray(sigma, dtype=float), z.shape)
        s, x, new = np.ones(len(z)), np.inf, np.average(z, weights=sigma**-2.0)
        while abs(new - x) > 0.01:
            x = new
            s = np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0)
            new = np.average(z, weights=(s / sigma) ** 2)
        return new, s
