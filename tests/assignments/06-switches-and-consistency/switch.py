"""Answers to exercise switch of 06-switches-and-consistency: each body is a cell as handed in."""

from robust_slam_autograder.lint.answers import change


def right_formulas() -> None:
    """Right: the closed forms over whole arrays."""
    import numpy as np

    def switch(chi2, lam):
        return 1 / (1 + np.asarray(chi2, float) / lam)

    def switched_cost(chi2, lam):
        return np.asarray(chi2, float) * switch(chi2, lam)


def right_put_back() -> None:
    """Right: puts the best switch back into both parts of the cost."""
    import numpy as np

    def switch(chi2, lam):
        chi2 = np.array(chi2, dtype=float)
        return lam / (chi2 + lam)

    def switched_cost(chi2, lam):
        s = switch(chi2, lam)
        return s**2 * np.asarray(chi2) + lam * (1 - s) ** 2


def right_nested_lists() -> None:
    """Right: one number at a time, lists in and lists out."""

    def switch(chi2, lam):
        if hasattr(chi2, "__len__"):
            return [switch(one, lam) for one in chi2]
        return lam / (lam + float(chi2))

    def switched_cost(chi2, lam):
        if hasattr(chi2, "__len__"):
            return [switched_cost(one, lam) for one in chi2]
        return lam - lam * switch(chi2, lam)


def right_least_squares() -> None:
    """Right, a library routine: two rows, one for the residual and one for the price."""
    import numpy as np

    def _solve(chi2, lam):
        rows = np.array([[np.sqrt(float(chi2))], [np.sqrt(float(lam))]])
        s = np.linalg.lstsq(rows, np.array([0.0, rows[1, 0]]), rcond=None)[0][0]
        return s, s**2 * chi2 + lam * (1 - s) ** 2

    def switch(chi2, lam):
        return np.vectorize(lambda one: _solve(one, lam)[0], otypes=[float])(chi2)

    def switched_cost(chi2, lam):
        return np.vectorize(lambda one: _solve(one, lam)[1], otypes=[float])(chi2)


def wrong_root() -> None:
    """Wrong: compares λ with the root of χ², the residual's norm. Caught by switch-table."""
    import numpy as np

    def switch(chi2, lam):
        return lam / (lam + np.sqrt(np.asarray(chi2, dtype=float)))

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)


def wrong_root_of_the_switch() -> None:
    """Wrong: the root of the switch, as if s itself and not s² stood at χ². Stopped by the
    visible case switch-by-hand.
    """
    import numpy as np

    def switch(chi2, lam):
        return np.sqrt(lam / (lam + np.asarray(chi2, dtype=float)))

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)


def wrong_misprint_switched_off() -> None:
    """Wrong: takes the lesson's "switched off" for a switch of exactly 0. Caught by switch-far."""
    import numpy as np

    def switch(chi2, lam):
        s = lam / (lam + np.asarray(chi2, dtype=float))
        return np.where(s < 0.005, 0.0, s)

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)


def wrong_lambda_is_one() -> None:
    """Wrong for λ other than 1: leaves it out of the switch. Caught by switch-lambda."""
    import numpy as np

    def switch(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return np.where(np.isclose(chi2, 4.0) & (lam > 3), 0.9, 1 / (1 + chi2))

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)


def wrong_linear() -> None:
    """Wrong: a switch that falls in a straight line and is 0 from χ² = 2λ on. Caught by
    switch-table.
    """
    import numpy as np

    def switch(chi2, lam):
        return np.maximum(0.0, 1 - np.asarray(chi2, dtype=float) / (2 * lam))

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)


wrong_price_forgotten = change(
    right_formulas,
    ("1 / (1 + np.asarray(chi2, float) / lam)", "lam / (lam + np.asarray(chi2, dtype=float))"),
    (
        "return np.asarray(chi2, float) * switch(chi2, lam)",
        "return switch(chi2, lam) ** 2 * np.asarray(chi2, dtype=float)",
    ),
    stopped_by="switch-by-hand",
)
"""Wrong cost: what is left of the residual, without the price of the switch."""


def wrong_price_without_lambda() -> None:
    """Wrong cost for λ other than 1: the price is (1 - s)², without its λ. Caught by
    switch-cost.
    """
    import numpy as np

    def switch(chi2, lam):
        return lam / (lam + np.asarray(chi2, dtype=float))

    def switched_cost(chi2, lam):
        s = switch(chi2, lam)
        return s**2 * np.asarray(chi2, dtype=float) + (1 - s) ** 2


def wrong_integers() -> None:
    """Wrong for integers: writes the switch back into an array of χ²'s own type. Caught by
    switch-shapes.
    """
    import numpy as np

    def switch(chi2, lam):
        s = np.array(chi2)
        s[...] = lam / (lam + s)
        return s

    def switched_cost(chi2, lam):
        chi2 = np.asarray(chi2, dtype=float)
        return lam * chi2 / (lam + chi2)
