"""Answers to exercise table of 02-four-costs: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_cell_by_cell() -> None:
    """Right: sixteen cells from scalar functions, as a list of rows."""
    import math

    def table(c):
        square = lambda u: u * u / 2
        huber = lambda u: square(u) if u <= c else c * u - square(c)
        cauchy = lambda u: square(c) * math.log(1 + (u / c) ** 2)
        tls = lambda u: square(min(u, c))
        costs = [[rho(1), rho(10)] for rho in (square, huber, cauchy, tls)]
        weights = [1, min(1, c / 10), 1 / (1 + 100 / c**2), 1 if c >= 10 else 0]
        return [[near, far, far / near, w] for (near, far), w in zip(costs, weights)]


def right_array() -> None:
    """Right: columns of arrays, put side by side; min(u, c) serves Huber and TLS."""

    def table(c):
        u = np.array([1.0, 10.0])
        inner = np.minimum(u, c)
        cauchy = c**2 / 2 * np.log1p((u / c) ** 2)
        cost = np.array([u**2 / 2, inner * (u - inner / 2), cauchy, inner**2 / 2])
        ratio = cost[:, 1] / cost[:, 0]
        weight = [1.0, min(1.0, c / 10), 1 / (1 + (10 / c) ** 2), float(c >= 10)]
        return np.column_stack([cost, ratio, weight])


def right_library_without_half() -> None:
    """Right: SciPy's Huber function, and TLS on the lesson's scale, without the ½."""
    from scipy.special import huber

    def table(c):
        filled = np.empty((4, 4))
        for column, u in enumerate((1.0, 10.0)):
            filled[0, column] = u**2 / 2
            filled[1, column] = huber(c, u)
            filled[2, column] = c**2 * np.log(np.hypot(1, u / c))
            filled[3, column] = min(u**2, c**2)
        filled[:, 2] = filled[:, 1] / filled[:, 0]
        filled[:, 3] = 1, min(1, c / 10), np.cos(np.arctan(10 / c)) ** 2, 10 <= c
        return filled


wrong_misprint = change(
    right_array,
    ("c**2 / 2 * np.log1p((u / c) ** 2)", "[0.347, 2.40]"),
    ("1 / (1 + (10 / c) ** 2)", "0.0099"),
    caught_by="table-cauchy",
)
"""Wrong: Cauchy's row typed from the lesson."""

wrong_residual_not_squared = change(right_array, "(u / c) ** 2", "u / c", caught_by="table-cauchy")
"""Wrong: Cauchy's logarithm is of 1 + u/c, the lesson's slip as a formula."""

wrong_one_threshold_only = change(
    right_array,
    ("np.minimum(u, c)", "np.minimum(u, 1)"),
    ("c**2 / 2 * np.log1p((u / c) ** 2)", "np.log1p(u**2) / 2"),
    caught_by="table-huber",
)
"""Wrong: the table of c = 1 for every c, but for the weights."""

wrong_one_is_always_inside = change(
    right_array, "np.minimum(u, c)", "np.minimum(u, [1, c])", caught_by="table-small"
)
"""Wrong for c below 1: takes 1 for an inlier."""

wrong_ten_is_always_outside = change(
    right_array, "np.minimum(u, c)", "np.minimum([1, np.inf], c)", caught_by="table-large"
)
"""Wrong for c above 10: takes 10 for an outlier whatever c is."""

wrong_mixed_tls = change(
    right_array, "weight = ", "cost[3, 1] *= 2\nweight = ", caught_by="table-tls"
)
"""Wrong: TLS with the ½ in one column and without it in the other."""

wrong_ratio_upside_down = change(
    right_array, "cost[:, 1] / cost[:, 0]", "cost[:, 0] / cost[:, 1]", stopped_by="table-by-hand"
)
"""Wrong: divides ρ(1) by ρ(10)."""

wrong_integers = change(
    right_array, "weight])", "weight]).astype(np.asarray(c).dtype)", caught_by="table-integer"
)
"""Wrong for integer c: an array of the type of c cuts off the fractions."""

wrong_inside_from_fifty = change(
    right_array, "u = np", "c = np.clip(c, 0.1, 50.0)\nu = np", caught_by="table-cauchy"
)
"""Wrong for tiny and for huge c: keeps c between 0.1 and 50."""
