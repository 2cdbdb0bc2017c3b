"""Answers to exercise local_minima of 04-non-convexity: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_grid() -> None:
    """Right: a grid for the number of minima, SciPy's bounded search for each."""
    from scipy.optimize import minimize_scalar

    def local_minima(z, rho, lo, hi):
        def height(x):
            return np.sum(rho(np.subtract.outer(x, z)), axis=-1)

        x = np.linspace(lo, hi, 2000)
        f = height(x)
        low = np.flatnonzero((f[1:-1] < f[:-2]) & (f[1:-1] <= f[2:])) + 1
        ends = [minimize_scalar(height, bounds=(x[k - 1], x[k + 1])).x for k in low]
        return ends


def right_finer_and_finer() -> None:
    """Right: a grid inside the grid, three times."""

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

    def local_minima(z, rho, lo, hi):
        x = np.linspace(lo, hi, 60_001)
        f = np.zeros(x.size)
        for one in z:
            f += rho(x - one)
        a, b, c = f[:-2], f[1:-1], f[2:]
        low = (b < a) & (b <= c)
        shift = (a - c)[low] / (2 * (a - 2 * b + c)[low])
        return x[1:-1][low] + shift * (x[1] - x[0])


wrong_grid_only = change(right_grid, "return ends", "return x[low]", caught_by="local_minima-pair")
"""Wrong: the lowest points of a grid, no closer than its spacing."""

wrong_maxima_too = change(
    right_roots_of_the_slope, "< 0) & (s[1:] >=", "* s[1:] <=", stopped_by="local_minima-by-hand"
)
"""Wrong: every zero of the slope, the maxima among them."""

wrong_global_only = change(
    right_grid, "return ends", "return [min(ends, key=height)]", stopped_by="local_minima-by-hand"
)
"""Wrong: the lowest point alone."""

wrong_one_per_measurement = change(
    right_grid,
    ("import minimize_scalar", "import minimize"),
    ("minimize_scalar(height, bounds=(x[k - 1], x[k + 1])).x", "minimize(height, z[k]).x[0]"),
    ("for k in low", "for k in np.argsort(z)"),
    stopped_by="local_minima-pair",
)
"""Wrong: descends from each measurement and keeps every end, also those that meet."""

wrong_misprint = change(
    right_grid,
    "return ends",
    "return [place for place in sorted(set(z)) if lo < place < hi]",
    stopped_by="local_minima-by-hand",
)
"""Wrong: the lesson's bowls, one for each measurement and with its lowest point there."""

wrong_measurements_themselves = change(
    right_grid,
    "return ends",
    """
    nearest = np.argmin(np.abs(np.subtract.outer(x[low], z)), axis=0)
    return [np.mean(np.asarray(z)[nearest == k]) for k in range(len(low))]
    """,
    stopped_by="local_minima-by-hand",
)
"""Wrong: takes the groups of the measurements, by their means, for the minima."""

wrong_falling_order = change(
    right_grid,
    "return ends",
    "return ends if len(ends) < 3 else sorted(ends, key=height)",
    caught_by="local_minima-many",
)
"""Wrong order, for more than two: the deepest minimum comes first."""

wrong_lowest_two = change(
    right_grid,
    "return ends",
    "return ends if len(ends) < 3 else [ends[0], ends[-1]]",
    caught_by="local_minima-many",
)
"""Wrong for more than two: expects one inlier and one outlier."""

wrong_cauchy_formula = change(
    right_grid,
    "return ends",
    """
    c_squared = 2.5e-13 / (5e-7 - rho(1e-3))
    half = np.sqrt(max(np.ptp(z) ** 2 / 4 - c_squared, 0))
    ends = np.unique(np.array([-half, half]) + (max(z) + min(z)) / 2)
    return ends[(ends > lo) & (ends < hi)]
    """,
    stopped_by="local_minima-kernels",
)
"""Wrong for other data: the formula of the pair, with the c that it reads off ρ."""

wrong_ends_too = change(
    right_grid,
    "return ends",
    "return [lo, *ends] if f[0] < f[1] else ends",
    caught_by="local_minima-interval",
)
"""Wrong: an end from which the cost rises counts as a minimum."""

wrong_coarse_grid = change(right_grid, "2000", "15", caught_by="local_minima-escape")
"""Wrong for a shallow well: a grid of fifteen points steps over it."""

wrong_never_past_a_hundred = change(
    right_grid,
    ("lo, hi, 2000", "-100, 100, 10_001"),
    ("return ends", "return [place for place in ends if lo < place < hi]"),
    caught_by="local_minima-interval",
)
"""Wrong for intervals far away: searches between -100 and 100 alone."""

wrong_two_hundred_points = change(right_grid, "2000", "200", caught_by="local_minima-escape")
"""Wrong for wide intervals: two minima fit between neighbours of its grid."""
