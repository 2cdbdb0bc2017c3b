"""Answers to exercise convex_until of 02-four-costs: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_fine_grid() -> None:
    """Right: the first second difference below zero on a fine grid."""

    def convex_until(rho, lo, hi):
        u, h = np.linspace(lo, hi, 200_001), 1e-3
        curvature = (rho(u + h) - 2 * rho(u) + rho(u - h)) / h**2
        concave = curvature < -1e-6
        return u[np.argmax(concave)] if concave.any() else np.inf


def right_brent() -> None:
    """Right: SciPy's root finder on the second difference between the two ends."""
    from scipy.optimize import brentq

    def convex_until(rho, lo, hi):
        def second(u, h=1e-3):
            return float(rho(u + h) - 2 * rho(u) + rho(u - h)) / h**2

        return np.inf if second(hi) > -1e-6 else brentq(second, lo + 1e-6, hi)


def right_largest_influence() -> None:
    """Right, an equivalent condition: ρ'' turns where the influence is largest."""
    from scipy.optimize import minimize_scalar

    def convex_until(rho, lo, hi):
        def pull(u, h=1e-3):
            return float(rho(u - h) - rho(u + h)) / (2 * h)

        best = minimize_scalar(pull, bounds=(lo, hi), options={"xatol": 1e-7})
        return best.x if pull(hi) - best.fun > 1e-6 else float("inf")


def right_finer_and_finer() -> None:
    """Right: NumPy's gradient taken twice on a grid that closes in, four times."""

    def convex_until(rho, lo, hi):
        for _ in range(4):
            u = np.linspace(lo, hi, 201)
            step = 1e-3
            slope = (rho(u + step) - rho(u - step)) / (2 * step)
            steeper = (rho(u + 2 * step) - rho(u)) / (2 * step)
            concave = (steeper - slope) / step < -1e-6
            if not concave.any():
                return np.inf
            first = int(concave.argmax())
            lo, hi = u[max(first - 1, 0)], u[first]
        return float(hi) + 5e-4


def right_plain_loop() -> None:
    """Right: walks from lo in steps of a hundredth, then in ever smaller ones."""

    def convex_until(rho, lo, hi):
        def bends_down(u):
            return (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6 < -1e-6

        u, step = lo, (hi - lo) / 100
        for _ in range(4):
            while not bends_down(u):
                u += step
                if u > hi:
                    return float("inf")
            u, step = max(lo, u - step), step / 20
        return u


wrong_misprint = change(
    right_fine_grid,
    "return",
    "u = u / np.sqrt(2) if rho(1e4) > rho(1e3) + 0.01 else u\nreturn",
    caught_by="convex_until-cauchy",
)
"""Wrong: the lesson's c/√2, which is Welsch's, for Cauchy's cost too."""

wrong_two_costs_by_heart = change(
    right_fine_grid,
    "return",
    """
    if rho(1e4) < rho(1e3) + 0.01:
        u = 0 * u + 9e-6 / np.sqrt(8 * (4.5e-6 - rho(3e-3)))
    return""",
    caught_by="convex_until-geman-mcclure",
)
"""Wrong: reads c off the cost near 0 and takes every flat cost for Welsch's."""

wrong_most_concave = change(
    right_fine_grid, "argmax(concave)", "argmin(curvature)", stopped_by="convex_until-by-hand"
)
"""Wrong: finds where the curvature is lowest, not where it changes its sign."""

wrong_coarse_grid = change(right_fine_grid, "200_001", "50", stopped_by="convex_until-by-hand")
"""Wrong accuracy: returns the first point of a coarse grid."""

wrong_zero_counts = change(right_fine_grid, "< -1e-6", "<= 1e-6", stopped_by="convex_until-huber")
"""Wrong for a straight line: takes ρ'' = 0 for the end of convexity."""

wrong_line_past_a_bend = change(
    right_fine_grid,
    "curvature < -1e-6",
    "(curvature < 1e-6 * curvature[0]) & (curvature[0] > 1e-6)",
    caught_by="convex_until-huber",
)
"""Wrong for Huber: takes the bend at k, where the curvature falls to nothing, for the turn."""

wrong_own_interval = change(
    right_fine_grid, "lo, hi, 200_001", "0.0, 20.0, 200_001", caught_by="convex_until-interval"
)
"""Wrong interval: searches from 0 to 20, whatever lo and hi are."""

wrong_never_past_twenty = change(
    right_fine_grid, "hi, 200", "min(hi, 20), 200", caught_by="convex_until-interval"
)
"""Wrong for a large hi: the search never goes past 20."""
