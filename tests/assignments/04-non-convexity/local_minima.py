"""Answers to exercise local_minima of 04-non-convexity: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_bounded_search() -> None:
    """Right: a grid for the number of minima, SciPy's bounded search for each."""
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        grid = np.linspace(lo, hi, 2000)
        f = height(grid)
        found = []
        for k in range(1, len(grid) - 1):
            if f[k] < f[k - 1] and f[k] <= f[k + 1]:
                ends = (grid[k - 1], grid[k + 1])
                best = minimize_scalar(height, bounds=ends, method="bounded")
                found.append(best.x)
        return np.array(found)


def right_finer_and_finer() -> None:
    """Right: a grid inside the grid, three times."""
    import numpy as np

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def lows(a, b, n):
            x = np.linspace(a, b, n)
            f = rho(x[:, None] - z).sum(axis=1)
            k = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
            return x[k], x[1] - x[0]

        places, step = lows(lo, hi, 1501)
        for _ in range(2):
            finer = [lows(x - 2 * step, x + 2 * step, 101) for x in places]
            places, step = [x[0] for x, _ in finer], 4 * step / 100
        return places


def right_roots_of_the_slope() -> None:
    """Right: the slope by central differences, and SciPy's root where it turns from - to +."""
    import numpy as np
    from scipy.optimize import brentq

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def slope(x, h=1e-4):
            x = np.asarray(x)[..., None] - z
            return np.sum(rho(x + h) - rho(x - h), axis=-1) / (2 * h)

        grid = np.linspace(lo, hi, 2401)
        s = slope(grid)
        turns = np.flatnonzero((s[:-1] < 0) & (s[1:] >= 0))
        return np.array([brentq(slope, grid[k], grid[k + 1], xtol=1e-9) for k in turns])


def right_parabola() -> None:
    """Right: the vertex of the parabola through three points of a fine grid, sixty thousand."""
    import numpy as np

    def local_minima(z, rho, lo, hi):
        x = np.linspace(lo, hi, 60_001)
        f = np.zeros(x.size)
        for one in z:
            f += rho(x - one)
        a, b, c = f[:-2], f[1:-1], f[2:]
        low = (b < a) & (b <= c)
        shift = (a - c)[low] / (2 * (a - 2 * b + c)[low])
        return x[1:-1][low] + shift * (x[1] - x[0])


def wrong_grid_only() -> None:
    """Wrong: the lowest points of a grid, no closer than its spacing. Caught by
    local_minima-pair.
    """
    import numpy as np
    from scipy.signal import argrelmin

    def local_minima(z, rho, lo, hi):
        x = np.linspace(lo, hi, 1001)
        f = np.sum(rho(x[:, None] - np.asarray(z, dtype=float)), axis=1)
        return x[argrelmin(f)[0]]


wrong_maxima_too = change(
    right_roots_of_the_slope,
    (
        "return np.sum(rho(x + h) - rho(x - h), axis=-1) / (2 * h)",
        "return np.sum(rho(x + h) - rho(x - h), axis=-1)",
    ),
    ("grid = np.linspace(lo, hi, 2401)", "grid = np.linspace(lo, hi, 2400)"),
    ("(s[:-1] < 0) & (s[1:] >= 0)", "s[:-1] * s[1:] < 0"),
    stopped_by="local_minima-by-hand",
)
"""Wrong: every zero of the slope, the maxima among them."""


def wrong_global_only() -> None:
    """Wrong: the lowest point alone. Stopped by the visible case local_minima-by-hand."""
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)
        x = np.linspace(lo, hi, 2000)
        k = int(np.argmin(np.sum(rho(x[:, None] - z), axis=1)))
        ends = (x[max(k - 1, 0)], x[min(k + 1, x.size - 1)])
        best = minimize_scalar(lambda t: np.sum(rho(t - z)), bounds=ends, method="bounded")
        return np.array([best.x])


def wrong_one_per_measurement() -> None:
    """Wrong: descends from each measurement and keeps every end, also those that meet. Stopped by
    the visible case local_minima-pair.
    """
    import numpy as np
    from scipy.optimize import minimize

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)
        ends = [minimize(lambda t: np.sum(rho(t - z)), [one]).x[0] for one in z]
        return np.sort([x for x in ends if lo < x < hi])


def wrong_misprint() -> None:
    """Wrong: the lesson's bowls, one for each measurement and with its lowest point there. Stopped
    by the visible case local_minima-by-hand.
    """

    def local_minima(z, rho, lo, hi):
        return [place for place in sorted(set(z)) if lo < place < hi]


def wrong_measurements_themselves() -> None:
    """Wrong: takes the groups of the measurements, by their means, for the minima. Stopped
    by the visible case local_minima-by-hand.
    """
    import numpy as np

    def local_minima(z, rho, lo, hi):
        z = np.sort(np.asarray(z, dtype=float))
        x = np.linspace(lo, hi, 2001)
        f = np.sum(rho(x[:, None] - z), axis=1)
        low = x[1:-1][(f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])]
        if low.size == 0:
            return low
        nearest = np.argmin(np.abs(z[:, None] - low), axis=1)
        means = [np.mean(z[nearest == k]) for k in range(low.size)]
        return np.array(means)


def wrong_falling_order() -> None:
    """Wrong order, for more than two: the deepest minimum comes first. Caught by
    local_minima-many.
    """
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(lo, hi, 2000)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        found = [
            minimize_scalar(height, bounds=(x[k - 1], x[k + 1]), method="bounded").x for k in low
        ]
        return found if len(found) < 3 else sorted(found, key=height)


def wrong_lowest_two() -> None:
    """Wrong for more than two: expects one inlier and one outlier. Caught by
    local_minima-many.
    """
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(lo, hi, 2000)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        return [
            minimize_scalar(height, bounds=(x[k - 1], x[k + 1]), method="bounded").x
            for k in low[[0, -1] if low.size > 1 else slice(None)]
        ]


def wrong_cauchy_formula() -> None:
    """Wrong for other data: the formula of the pair, with the c that it reads off ρ. Stopped by
    the visible case local_minima-kernels.
    """
    import numpy as np
    from scipy.optimize import brentq

    def local_minima(z, rho, lo, hi):
        a, b = min(z), max(z)
        log = lambda c: c**2 / 2 * np.log1p(1e4 / c**2) - float(rho(100.0))
        c = brentq(log, 1e-6, 1e6)
        half = np.sqrt(max((b - a) ** 2 / 4 - c**2, 0))
        found = np.unique([(a + b) / 2 - half, (a + b) / 2 + half])
        return found[(found > lo) & (found < hi)]


def wrong_ends_too() -> None:
    """Wrong: an end from which the cost rises counts as a minimum. Caught by
    local_minima-interval.
    """
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(lo, hi, 2000)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        found = [
            minimize_scalar(height, bounds=(x[k - 1], x[k + 1]), method="bounded").x for k in low
        ]
        return ([lo] if f[0] < f[1] else []) + found


def wrong_coarse_grid() -> None:
    """Wrong for a shallow well: a grid of fifteen points steps over it. Caught by
    local_minima-escape.
    """
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(lo, hi, 15)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        return [
            minimize_scalar(height, bounds=(x[k - 1], x[k + 1]), method="bounded").x for k in low
        ]


def wrong_never_past_a_hundred() -> None:
    """Wrong for intervals far away: searches between -100 and 100 alone. Caught by
    local_minima-interval.
    """
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(-100, 100, 10_001)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        found = [minimize_scalar(height, bounds=(x[k - 1], x[k + 1])).x for k in low]
        return [place for place in found if lo < place < hi]


def wrong_two_hundred_points() -> None:
    """Wrong for wide intervals: two minima fit between neighbours of its grid. Caught by
    local_minima-escape.
    """
    import numpy as np
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        z = np.asarray(z, dtype=float)

        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(lo, hi, 200)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        return [minimize_scalar(height, bounds=(x[k - 1], x[k + 1])).x for k in low]
