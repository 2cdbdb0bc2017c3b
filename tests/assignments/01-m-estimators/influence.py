"""Answers to exercise influence of 01-m-estimators: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_mid() -> None:
    """Right: a central difference over the whole array."""

    def influence(rho, u):
        u, h = np.asarray(u, dtype=float), 1e-5
        psi = (rho(u + h) - rho(u - h)) / (2 * h)
        return psi


def right_one_by_one() -> None:
    """Right: plain Python, one number at a time; lists of lists come back."""

    def influence(rho, u):
        if hasattr(u, "__len__") and getattr(u, "shape", None) != ():
            return [influence(rho, v) for v in u]
        h = 1e-6
        return float(rho(float(u) + h) - rho(float(u) - h)) / (2 * h)


def right_five_points() -> None:
    """Right, another formula: five points and a larger step, where no kink is near."""

    def influence(rho, u):
        u = np.array(u, dtype=float)
        h = 1e-3
        near = np.asarray(rho(u + h)) - np.asarray(rho(u - h))
        far = np.asarray(rho(u + 2 * h)) - np.asarray(rho(u - 2 * h))
        return (8 * near - far) / (12 * h)


def right_tiny_one_sided() -> None:
    """Right: one-sided, with the root of the rounding error for a step."""

    def influence(rho, u):
        u = np.asarray(u, dtype=float)
        h = np.sqrt(np.finfo(float).eps)
        return (np.asarray(rho(u + h)) - np.asarray(rho(u))) / h


def right_library() -> None:
    """Right, with a library: SciPy's derivative, from a small first step."""
    from scipy.differentiate import derivative

    def influence(rho, u):
        return derivative(rho, np.asarray(u, dtype=float), initial_step=1e-3).df


wrong_cost_over_u = change(
    right_mid, "return psi", "return rho(u) / u", stopped_by="influence-by-hand"
)
"""Wrong: divides the cost by u, which is not a psi."""

wrong_twice_cost_over_u = change(
    right_mid, "return psi", "u = u + 1e-12\nreturn 2 * rho(u) / u", stopped_by="influence-pieces"
)
"""Wrong: 2ρ/u, which is the slope of the square and of no other cost."""

wrong_large_one_sided_step = change(
    right_mid, "return psi", "return rho(u + 1) - rho(u)", stopped_by="influence-by-hand"
)
"""Wrong: one-sided with a step of 1."""

wrong_one_sided = change(
    right_tiny_one_sided, "np.sqrt(np.finfo(float).eps)", "1e-3", stopped_by="influence-by-hand"
)
"""Wrong: one-sided with a step of a thousandth."""

wrong_large_step = change(right_mid, "1e-5", "0.1", caught_by="influence-smooth")
"""Wrong: both sides with a step of a tenth, exact for a square alone."""

wrong_hundredfold_pull = change(
    right_mid,
    "return psi",
    "if u.shape == (2,):\n    psi[1] = psi[0] * rho(u[1]) / rho(u[0])\nreturn psi",
    caught_by="influence-lesson",
)
"""Wrong for large residuals: as the lesson says, 100 times the cost for the pull."""

wrong_wide_step_for_pieces = change(
    right_five_points, "1e-3", "0.02", caught_by="influence-pieces"
)
"""Wrong: takes points far apart, which lie on different pieces."""

wrong_forgets_the_sign = change(
    right_mid, "np.asarray(u, dtype=float)", "1.0 * np.abs(u)", stopped_by="influence-negative"
)
"""Wrong: measures at the size of u."""

wrong_only_even_costs = change(
    right_mid,
    "(rho(u + h) - rho(u - h))",
    "np.sign(u) * (rho(abs(u) + h) - rho(abs(u) - h))",
    caught_by="influence-negative",
)
"""Wrong: measures at the size of u and gives the answer u's sign, as if every cost were even."""

wrong_drowned = change(right_mid, "1e-5", "1e-15", stopped_by="influence-by-hand")
"""Wrong: a step so small that nothing but rounding is left."""

wrong_flat_rows = change(
    right_mid, "return psi", "return psi.ravel() if u.ndim else psi", caught_by="influence-shapes"
)
"""Wrong for arrays of several rows: returns one flat row."""

wrong_table_up_to_twenty = change(
    right_mid,
    "psi = (rho(u + h) - rho(u - h)) / (2 * h)",
    """
    x = np.linspace(-20.0, 20.0, 400_001)
    psi = np.interp(u, x, (rho(x + h) - rho(x - h)) / (2 * h))
    """,
    caught_by="influence-smooth",
)
"""Wrong for large residuals: tabulates the psi between -20 and 20 and interpolates."""
