"""Answers to exercise best_of of 04-non-convexity: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_min() -> None:
    """Right: the descents one after the other, and the end of least cost."""

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)

        def descend(x):
            kept = z[np.abs(z - x) <= c]
            new = np.mean(kept) if kept.size else x
            return float(x) if abs(new - x) < 1e-12 else descend(new)

        def cost(x):
            r = x - z
            return np.sum(np.minimum(r**2, c**2))

        ends = [descend(start) for start in starts]
        return min(ends, key=cost)


def right_argmin() -> None:
    """Right: all the descents at once, then the index of the least cost."""

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        x = np.array(starts, dtype=float)
        for _ in range(200):
            kept = np.abs(x[:, None] - z) <= c
            count = kept.sum(axis=1)
            x = np.where(count > 0, kept @ z / np.maximum(count, 1), x)
        costs = np.clip(np.abs(x[:, None] - z), 0, c) ** 2
        return x[np.argmin(costs.sum(axis=1))]


def right_plain_python() -> None:
    """Right: lists, sorted by cost and, where they tie, by place."""

    def best_of(z, c, starts):
        def descend(x):
            kept = [a for a in z if abs(a - x) <= c]
            new = sum(kept) / len(kept) if kept else x
            return x if abs(new - x) < 1e-12 else descend(new)

        ends = [descend(start) for start in starts]
        return sorted((sum(min((a - x) ** 2, c * c) for a in z), x) for x in ends)[0][1]


def right_last_of_the_tied() -> None:
    """Right: counts what is saved against a plateau; of tied ends it takes the last."""

    def best_of(z, c, starts):
        z = np.asarray(z, dtype=float)
        best, most = 0.0, -1.0
        for start in starts:
            x, kept = float(start), np.abs(z - start) <= c
            while kept.any() and abs(np.mean(z[kept]) - x) > 1e-12:
                x = float(np.mean(z[kept]))
                kept = np.abs(z - x) <= c
            saved = np.sum(c**2 - (z[kept] - x) ** 2)
            if saved >= most:
                best, most = x, saved
        return best


wrong_mean_of_ends = change(
    right_min, "min(ends, key=cost)", "np.mean(ends)", stopped_by="best_of-by-hand"
)
"""Wrong: averages the ends."""

wrong_median_of_ends = change(
    right_min, "min(ends, key=cost)", "np.median(ends)", stopped_by="best_of-by-hand"
)
"""Wrong: the end in the middle."""

wrong_last_start = change(right_min, "min(ends, key=cost)", "ends[-1]", stopped_by="best_of-order")
"""Wrong: each descent overwrites the one before."""

wrong_strictly_better_than_the_last = change(
    right_min,
    "return min(ends, key=cost)",
    """
    costs = [np.inf, *map(cost, ends)]
    return [x for x, before, after in zip(ends, costs, costs[1:]) if after < before][-1]
    """,
    stopped_by="best_of-order",
)
"""Wrong: compares each end with the one before it, and not with the best so far."""

wrong_best_start = change(
    right_min, "in starts", "in [min(starts, key=cost)]", stopped_by="best_of-end-not-start"
)
"""Wrong: descends from the cheapest start alone."""

wrong_start_returned = change(
    right_min,
    "min(ends, key=cost)",
    "min(starts, key=lambda x: cost(descend(x)))",
    stopped_by="best_of-by-hand",
)
"""Wrong: finds the right descent and returns where it began."""

wrong_misprint = change(
    right_min,
    "min(ends, key=cost)",
    "max(ends, key=lambda x: np.sum(np.abs(x - z) <= c))",
    caught_by="best_of-votes",
)
"""Wrong: the end that keeps the most measurements wins, however badly they fit."""

wrong_rejection_is_free = change(
    right_min, "np.minimum(r**2, c**2)", "r[np.abs(r) <= c] ** 2", stopped_by="best_of-by-hand"
)
"""Wrong: adds up the squares of the kept ones alone, so a plateau costs nothing."""

wrong_rejection_costs_c = change(
    right_min, "np.minimum(r**2, c**2)", "np.where(abs(r) > c, c, r**2)", caught_by="best_of-votes"
)
"""Wrong for c other than 1: a rejected measurement costs c and not c²."""

wrong_least_squares_cost = change(right_min, "c**2", "np.inf", stopped_by="best_of-by-hand")
"""Wrong: judges the ends by plain least squares."""

wrong_plateau_is_an_error = change(
    right_min,
    "min(ends,",
    "min((x for x in ends if np.any(np.abs(x - z) <= c)),",
    caught_by="best_of-shapes",
)
"""Wrong: skips a descent that keeps no measurement, so that some starts have no end at all."""

wrong_first_fifty_starts = change(
    right_min, "in starts", "in starts[:50]", caught_by="best_of-order"
)
"""Wrong for many starts: descends from the first fifty alone."""
