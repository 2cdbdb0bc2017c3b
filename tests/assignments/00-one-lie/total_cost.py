"""Answers to exercise total_cost of 00-one-lie: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_sum() -> None:
    """Right: the formula over whole arrays."""

    def total_cost(x, i, j, z, sigma):
        x = np.asarray(x, dtype=float)
        r = x[j] - x[i] - z
        return np.sum((r / sigma) ** 2)


def right_plain_loop() -> None:
    """Right: one edge at a time, plain Python."""

    def total_cost(x, i, j, z, sigma):
        cost = 0.0
        for k in range(len(z)):
            s = sigma[k] if hasattr(sigma, "__len__") else sigma
            cost += ((x[j[k]] - x[i[k]] - z[k]) / s) ** 2
        return cost


def right_quadratic_form() -> None:
    """Right, an equivalent form: builds J and Ω and multiplies r' Ω r."""

    def total_cost(x, i, j, z, sigma):
        m = len(z)
        J = np.zeros((m, len(x)))
        J[np.arange(m), j] += 1
        J[np.arange(m), i] -= 1
        r = J @ np.array(x) - np.array(z)
        Omega = np.diag(1 / (np.ones(m) * sigma) ** 2)
        return r @ Omega @ r


def right_norm() -> None:
    """Right: the squared norm of the whitened residuals, measured minus predicted."""

    def total_cost(x, i, j, z, sigma):
        steps = np.take(x, j) - np.take(x, i)
        return float(np.linalg.norm((np.array(z) - steps) / np.array(sigma)) ** 2)


wrong_half = change(right_sum, "np.sum", "0.5 * np.sum", stopped_by="total_cost-by-hand")
"""Wrong: the solvers' ½ in front; this chapter's cost has none."""

wrong_sigma_once = change(
    right_sum, "(r / sigma) ** 2", "r**2 / sigma", stopped_by="total_cost-by-hand"
)
"""Wrong: squares the residual first and then divides by σ instead of σ²."""

wrong_sum_before_square = change(
    right_sum, "np.sum((r / sigma) ** 2)", "np.sum(r / sigma) ** 2", caught_by="total_cost-lesson"
)
"""Wrong: adds the whitened residuals up before it squares, so that errors cancel."""

wrong_worst_edge = change(right_sum, "np.sum", "np.max", caught_by="total_cost-lesson")
"""Wrong: counts the worst edge alone; at the truth that is the outlier."""

wrong_last_sigma = change(
    right_sum, "/ sigma", "/ np.ravel(sigma)[-1]", caught_by="total_cost-random"
)
"""Wrong: takes the last edge's σ for all of them."""

wrong_distances = change(
    right_sum, "x[j] - x[i] - z", "abs(x[j] - x[i]) - np.abs(z)", caught_by="total_cost-directions"
)
"""Wrong: compares distances, which have no direction."""

wrong_sorted_ends = change(
    right_sum, "r =", "i, j = np.sort([i, j], axis=0)\nr =", stopped_by="total_cost-directions"
)
"""Wrong: turns a backward edge round and forgets to turn its measurement."""

wrong_whole_numbers = change(
    right_sum,
    ("np.asarray(x, dtype=float)", "np.asarray(x)"),
    ("(r / sigma)", "(r / sigma if r.dtype == float else r // sigma)"),
    caught_by="total_cost-shapes",
)
"""Wrong: rounds down, because the measurements were integers."""

wrong_room_for_fifty = change(
    right_quadratic_form,
    ("len(x)))", "50))"),
    ("J @ np.array(x)", "J[:, : len(x)] @ np.array(x)"),
    caught_by="total_cost-random",
)
"""Wrong for large graphs: a Jacobian with fifty columns, however many poses there are."""
