"""Answers to exercise cost of 04-non-convexity: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_broadcast() -> None:
    """Right: a table of residuals, summed over the measurements."""
    import numpy as np

    def cost(x, z, rho):
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        return rho(x[..., None] - z).sum(axis=-1)


def right_one_measurement_at_a_time() -> None:
    """Right: adds the landscape of each measurement."""
    import numpy as np

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
    import numpy as np

    def cost(x, z, rho):
        x = np.asarray(x, dtype=float)
        table = np.subtract.outer(np.asarray(z, dtype=float), x)
        return np.sum(rho(table), axis=0)


def wrong_misprint() -> None:
    """Wrong: the lesson's two bowls stay two, where a sum of squares is one bowl. Stopped by the
    visible case cost-by-hand.
    """
    import numpy as np

    def cost(x, z, rho):
        return np.min(rho(np.subtract.outer(x, z)), axis=-1)


def wrong_mean() -> None:
    """Wrong: the mean over the measurements. Stopped by the visible case cost-by-hand."""
    import numpy as np

    def cost(x, z, rho):
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        return np.mean(rho(x[..., None] - z), axis=-1)


wrong_cost_of_the_sum = change(
    right_broadcast,
    "rho(x[..., None] - z).sum(axis=-1)",
    "rho(np.sum(x[..., None] - z, axis=-1))",
    stopped_by="cost-by-hand",
)
"""Wrong: adds up the residuals first, where they cancel."""

wrong_always_the_square = change(
    right_broadcast,
    "rho(x[..., None] - z).sum(axis=-1)",
    "np.sum((x[..., None] - z) ** 2, axis=-1) / 2",
    stopped_by="cost-robust",
)
"""Wrong: the square is written in and ρ is ignored."""

wrong_cost_of_the_distance = change(
    right_broadcast,
    "rho(x[..., None] - z).sum(axis=-1)",
    "rho(np.sqrt(np.sum((x[..., None] - z) ** 2, axis=-1)))",
    stopped_by="cost-robust",
)
"""Wrong: adds up squares and asks ρ for their root, one robust cost for all together."""


def wrong_pair_by_pair() -> None:
    """Wrong where there are as many places as measurements: pairs them off. Stopped by the visible
    case cost-as-many.
    """
    import numpy as np

    def cost(x, z, rho):
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        if x.shape == z.shape:
            return rho(x - z)
        return np.sum(rho(x[..., None] - z), axis=-1)


def wrong_sum_over_places() -> None:
    """Wrong where there are as many places as measurements: sums the table over the places, which
    shows in the shape elsewhere, and is turned round there. Caught by cost-as-many.
    """
    import numpy as np

    def cost(x, z, rho):
        x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
        table = rho(x[..., None] - z)
        total = np.sum(table, axis=0)
        return total if total.shape == x.shape else np.sum(table, axis=-1)


def wrong_number_refused() -> None:
    """Wrong for one place: a number comes out as a list of one. Stopped by the visible case
    cost-shapes.
    """
    import numpy as np

    def cost(x, z, rho):
        return np.array([np.sum(rho(one - np.asarray(z, dtype=float))) for one in np.ravel(x)])


wrong_integers = change(
    right_one_measurement_at_a_time,
    (
        "x = np.asarray(x, dtype=float)\ntotal = np.zeros(x.shape)",
        "x = np.asarray(x)\ntotal = np.zeros_like(x)",
    ),
    ("total = total + rho(x - float(one))", "total = total + rho(x - one).astype(x.dtype)"),
    caught_by="cost-shapes",
)
"""Wrong for integers: keeps the costs in an array of the places' own type."""
