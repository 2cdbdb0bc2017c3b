"""Answers to exercise convex_until of 02-four-costs: each body is a cell as handed in."""


def right_scan_and_halve() -> None:
    """Right: second differences on a grid, then halving the interval where the sign changes."""
    import numpy as np

    def convex_until(rho, lo, hi):
        h = 1e-3

        def curvature(u):
            return (rho(u + h) - 2 * rho(u) + rho(u - h)) / h**2

        u = np.linspace(lo, hi, 1001)
        where = np.nonzero(curvature(u) < -1e-6)[0]
        if len(where) == 0:
            return np.inf
        a, b = u[max(where[0] - 1, 0)], u[where[0]]
        for _ in range(40):
            m = (a + b) / 2
            if curvature(m) < -1e-6:
                b = m
            else:
                a = m
        return b


def right_brent() -> None:
    """Right: SciPy's root finder on the second difference between the two ends."""
    import math

    from scipy.optimize import brentq

    def convex_until(rho, lo, hi):
        h = 1e-3

        def second(u):
            return float(rho(u + h) - 2 * rho(u) + rho(u - h)) / h**2

        if second(hi) > -1e-6:
            return math.inf
        return brentq(second, lo + 1e-6, hi)


def right_largest_influence() -> None:
    """Right, an equivalent condition: ρ'' turns where the influence is largest."""
    from scipy.optimize import minimize_scalar

    def convex_until(rho, lo, hi):
        h = 1e-3

        def influence(u):
            return float(rho(u + h) - rho(u - h)) / (2 * h)

        found = minimize_scalar(
            lambda u: -influence(u), bounds=(lo, hi), method="bounded", options={"xatol": 1e-7}
        )
        falls = influence(found.x) - influence(hi) > 1e-6
        return found.x if falls else float("inf")


def right_finer_and_finer() -> None:
    """Right: NumPy's gradient taken twice on a grid that closes in, four times."""
    import numpy as np

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


def wrong_misprint() -> None:
    """Wrong: reads c off the cost near 0 and answers the lesson's c/√2, which is Welsch's. Caught
    by convex_until-cauchy.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = 0.05
        gap = float(u**2 / 2 - rho(u))
        if gap < 1e-12:
            return np.inf
        c = u**2 / np.sqrt(4 * gap)
        for _ in range(30):
            c = np.sqrt(u**4 / 4 / gap * (1 - u**2 / (3 * c**2)))
        found = c / np.sqrt(2)
        return found if lo < found < hi else np.inf


def wrong_two_costs_by_heart() -> None:
    """Wrong: knows Cauchy and Welsch by heart and takes every flat cost for Welsch's. Caught by
    convex_until-geman-mcclure.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = 0.05
        gap = float(u**2 / 2 - rho(u))
        if gap < 1e-12:
            return np.inf
        flat = rho(1e4) - rho(1e3) < 1e-2
        c = u**2 / np.sqrt(4 * gap)
        third = 1 / 3 if flat else 2 / 3
        for _ in range(30):
            c = np.sqrt(u**4 / 4 / gap * (1 - third * u**2 / c**2))
        found = c / np.sqrt(2) if flat else c
        return found if lo < found < hi else np.inf


def wrong_most_concave() -> None:
    """Wrong: finds where the curvature is lowest, not where it changes its sign. Stopped by the
    visible case convex_until-by-hand.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = np.linspace(lo, hi, 200_001)
        curvature = (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6
        return u[np.argmin(curvature)] if curvature.min() < -1e-6 else np.inf


def wrong_coarse_grid() -> None:
    """Wrong accuracy: returns the first point of a coarse grid. Stopped by the visible case
    convex_until-by-hand.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = np.linspace(lo, hi, 50)
        concave = (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6 < -1e-6
        return u[np.argmax(concave)] if concave.any() else np.inf


def wrong_zero_counts() -> None:
    """Wrong for a straight line: takes ρ'' = 0 for the end of convexity. Stopped by the visible
    case convex_until-huber.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = np.linspace(lo, hi, 400_001)
        curvature = (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6
        ended = curvature <= 1e-6
        return u[np.argmax(ended)] if ended.any() else np.inf


def wrong_line_past_a_bend() -> None:
    """Wrong for Huber: waits for the curvature to fall to nothing, and takes the bend at k for the
    turn. Caught by convex_until-huber.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = np.linspace(lo, hi, 400_001)
        curvature = (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6
        ended = curvature < 1e-6 * curvature[0]
        if not ended.any() or ended[0]:
            return np.inf
        return u[np.argmax(ended)]


def wrong_own_interval() -> None:
    """Wrong interval: searches from 0 to 20, whatever lo and hi are. Caught by
    convex_until-interval.
    """
    import numpy as np

    def convex_until(rho, lo, hi):
        u = np.linspace(0.0, 20.0, 400_001)
        concave = (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6 < -1e-6
        return u[np.argmax(concave)] if concave.any() else np.inf


def wrong_never_past_twenty() -> None:
    """Wrong for a large hi: the search never goes past 20. Caught by convex_until-interval."""
    import numpy as np

    def convex_until(rho, lo, hi):
        u = np.linspace(lo, min(hi, 20.0), 400_001)
        concave = (rho(u + 1e-3) - 2 * rho(u) + rho(u - 1e-3)) / 1e-6 < -1e-6
        return u[np.argmax(concave)] if concave.any() else np.inf
