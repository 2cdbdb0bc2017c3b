"""Answers to exercise influence of 01-m-estimators: each body is a cell as handed in."""


def right_central() -> None:
    """Right: a central difference over the whole array."""
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        h = 1e-4
        return (np.asarray(rho(u + h)) - np.asarray(rho(u - h))) / (2 * h)


def right_one_by_one() -> None:
    """Right: plain Python, one number at a time; lists of lists come back."""

    def influence(rho, u):
        if hasattr(u, "__len__") and getattr(u, "shape", None) != ():
            return [influence(rho, v) for v in u]
        h = 1e-6
        return float(rho(float(u) + h) - rho(float(u) - h)) / (2 * h)


def right_five_points() -> None:
    """Right, another formula: five points and a larger step, where no kink is near."""
    import numpy as np

    def influence(rho, u):
        u = np.array(u, dtype=float)
        h = 1e-3
        near = np.asarray(rho(u + h)) - np.asarray(rho(u - h))
        far = np.asarray(rho(u + 2 * h)) - np.asarray(rho(u - 2 * h))
        return (8 * near - far) / (12 * h)


def right_tiny_one_sided() -> None:
    """Right: one-sided, with the root of the rounding error for a step."""
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        h = np.sqrt(np.finfo(float).eps)
        return (np.asarray(rho(u + h)) - np.asarray(rho(u))) / h


def right_library() -> None:
    """Right, with a library: SciPy's derivative, from a small first step."""
    import numpy as np
    from scipy.differentiate import derivative

    def influence(rho, u):
        return derivative(rho, np.asarray(u, dtype=float), initial_step=1e-3).df


def wrong_cost_over_u() -> None:
    """Wrong: divides the cost by u, which is not a slope. Stopped by the visible case
    influence-by-hand.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        return rho(u) / u


def wrong_twice_cost_over_u() -> None:
    """Wrong: 2ρ/u, which is the slope of the square and of no other cost. Stopped by the visible
    case influence-pieces.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        safe = np.where(u == 0, 1e-12, u)
        return 2 * rho(safe) / safe


def wrong_large_one_sided_step() -> None:
    """Wrong: one-sided with a step of 1. Stopped by the visible case influence-by-hand."""
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        return rho(u + 1) - rho(u)


def wrong_one_sided() -> None:
    """Wrong: one-sided with a step of a thousandth. Stopped by the visible case
    influence-by-hand.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        return (rho(u + 1e-3) - rho(u)) / 1e-3


def wrong_large_step() -> None:
    """Wrong: both sides with a step of a tenth, exact for a square alone. Caught by
    influence-smooth.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        return (rho(u + 0.1) - rho(u - 0.1)) / 0.2


def wrong_hundredfold_pull() -> None:
    """Wrong: for large residuals the lesson's word, 100 times the cost for the pull. Caught by
    influence-lesson.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        slope = (rho(u + 1e-5) - rho(u - 1e-5)) / 2e-5
        if np.size(u) == 2 and np.ndim(u) == 1:
            slope[1] = slope[0] * rho(u[1]) / rho(u[0])
        return slope


def wrong_wide_step_for_pieces() -> None:
    """Wrong: fits a parabola through points far apart, which lie on different pieces. Caught by
    influence-pieces.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        h = 0.02
        near, far = rho(u + h) - rho(u - h), rho(u + 2 * h) - rho(u - 2 * h)
        farther = rho(u + 3 * h) - rho(u - 3 * h)
        return (45 * near - 9 * far + farther) / (60 * h)


def wrong_forgets_the_sign() -> None:
    """Wrong: measures at the size of u. Stopped by the visible case influence-negative."""
    import numpy as np

    def influence(rho, u):
        u = np.abs(np.asarray(u, dtype=float))
        return (rho(u + 1e-5) - rho(u - 1e-5)) / 2e-5


def wrong_only_even_costs() -> None:
    """Wrong: measures at the size of u and gives the answer u's sign, as if every cost were even.
    Caught by influence-negative.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        size = np.abs(u)
        return np.sign(u) * (rho(size + 1e-5) - rho(size - 1e-5)) / 2e-5


def wrong_drowned() -> None:
    """Wrong: a step so small that nothing but rounding is left. Stopped by the visible case
    influence-by-hand.
    """
    import numpy as np

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        return (rho(u + 1e-15) - rho(u - 1e-15)) / 2e-15


def wrong_flat_rows() -> None:
    """Wrong for arrays of several rows: returns one flat row. Caught by influence-shapes."""
    import numpy as np

    def influence(rho, u):
        flat = np.ravel(np.asarray(u, dtype=float))
        slope = (rho(flat + 1e-5) - rho(flat - 1e-5)) / 2e-5
        return slope if np.ndim(u) else slope[0]


def wrong_table_up_to_twenty() -> None:
    """Wrong for large residuals: tabulates the slope between -20 and 20 and interpolates. Caught
    by influence-smooth.
    """
    import numpy as np

    def influence(rho, u):
        grid = np.linspace(-20.0, 20.0, 400_001)
        return np.interp(u, grid, (rho(grid + 1e-5) - rho(grid - 1e-5)) / 2e-5)
