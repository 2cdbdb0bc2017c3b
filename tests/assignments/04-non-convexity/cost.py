"""Answers to exercise cost of 04-non-convexity: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_sum() -> None:
    """Right: a table of residuals, summed over the measurements."""

    def cost(x, z, rho):
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        r = x[..., None] - z
        return np.sum(rho(r), axis=-1)


def right_one_measurement_at_a_time() -> None:
    """Right: adds the landscape of each measurement."""

    def cost(x, z, rho):
        x = np.asarray(x, dtype=float)
        total = np.zeros(x.shape)
        for one in z:
            total = total + rho(x - float(one))
        return total


def right_one_place_at_a_time() -> None:
    """Right: plain Python over the places, a list out of a list."""

    def cost(x, z, rho):
        if hasattr(x, "__len__"):
            return [cost(one, z, rho) for one in x]
        return sum(float(rho(float(x) - float(one))) for one in z)


def right_outer() -> None:
    """Right: NumPy's table of differences, with the sign the other way round."""

    def cost(x, z, rho):
        x = np.asarray(x, dtype=float)
        table = np.subtract.outer(np.asarray(z, dtype=float), x)
        return np.sum(rho(table), axis=0)


wrong_misprint = change(right_sum, "np.sum", "np.min", stopped_by="cost-by-hand")
"""Wrong: the lesson's two bowls stay two, where a sum of squares is one bowl."""

wrong_mean = change(right_sum, "np.sum", "np.mean", stopped_by="cost-by-hand")
"""Wrong: the mean over the measurements."""

wrong_cost_of_the_sum = change(
    right_sum, "np.sum(rho(r), axis=-1)", "rho(np.sum(r, axis=-1))", stopped_by="cost-by-hand"
)
"""Wrong: adds up the residuals first, where they cancel."""

wrong_always_the_square = change(right_sum, "rho(r)", "r**2 / 2", stopped_by="cost-robust")
"""Wrong: the square is written in and ρ is ignored."""

wrong_cost_of_the_distance = change(
    right_sum, "np.sum(rho(r), axis=-1)", "rho(np.sum(r**2, -1) ** 0.5)", stopped_by="cost-robust"
)
"""Wrong: adds up squares and asks ρ for their root, one robust cost for all together."""

wrong_pair_by_pair = change(
    right_sum, "return", "return rho(x - z) if x.shape == z.shape else", stopped_by="cost-as-many"
)
"""Wrong where there are as many places as measurements: pairs them off."""

wrong_sum_over_places = change(
    right_sum, "axis=-1", "axis=0 if x.shape == z.shape else -1", caught_by="cost-as-many"
)
"""Wrong where there are as many places as measurements: sums the table over the places."""

wrong_number_refused = change(
    right_sum, "x[..., None]", "np.ravel(x)[:, None]", stopped_by="cost-shapes"
)
"""Wrong for one place: a number comes out as a list of one."""

wrong_integers = change(
    right_one_measurement_at_a_time,
    ("np.asarray(x, dtype=float)", "np.asarray(x)"),
    ("rho(x - float(one))", "rho(x - one).astype(x.dtype)"),
    caught_by="cost-shapes",
)
"""Wrong for integers: keeps the costs in an array of the places' own type."""
