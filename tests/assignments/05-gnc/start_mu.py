"""Answers to exercise start_mu of 05-gnc: each body is a cell as handed in."""


def right_formulas() -> None:
    """Right: the two formulas, with the condition for TLS."""
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "tls":
            if 2 * u_max**2 <= c**2:
                return np.inf
            return c**2 / (2 * u_max**2 - c**2)
        return 2 * u_max**2 / c**2


def right_ratio() -> None:
    """Right: both from the one ratio 2u²/c²."""

    def start_mu(u_max, c, kind):
        ratio = 2.0 * (u_max / c) ** 2
        if kind == "gm":
            return ratio
        return float("inf") if ratio <= 1 else 1 / (ratio - 1)


def right_negative_means_inf() -> None:
    """Right: the formula first, and then what its sign says."""
    import math

    import numpy as np

    def start_mu(u_max, c, kind):
        u_max, c = np.float64(u_max), np.float64(c)
        if kind == "tls":
            gap = (math.sqrt(2) * u_max - c) * (math.sqrt(2) * u_max + c)
            mu = c**2 / gap
            return mu if mu > 0 else math.inf
        return np.square(math.sqrt(2) * u_max / c)


def right_search() -> None:
    """Right: SciPy finds the μ that puts the upper knee where it should be."""
    import numpy as np
    from scipy.optimize import brentq

    def start_mu(u_max, c, kind):
        goal = 2 * (u_max / c) ** 2
        if kind == "gm":
            return goal
        if goal <= 1:
            return np.inf
        return np.exp(brentq(lambda t: np.log1p(np.exp(-t)) - np.log(goal), -60, 60, xtol=1e-13))


def wrong_swapped() -> None:
    """Wrong: the formula of GM for TLS and that of TLS for GM. Stopped by the visible case
    start_mu-by-hand.
    """
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return c**2 / (2 * u_max**2 - c**2) if 2 * u_max**2 > c**2 else np.inf
        return 2 * u_max**2 / c**2


def wrong_misprint() -> None:
    """Wrong: begins at μ = 1, whatever the residuals are, as the lesson does. Stopped by the
    visible case start_mu-by-hand.
    """

    def start_mu(u_max, c, kind):
        return 1.0


def wrong_negative_mu() -> None:
    """Wrong for small residuals: the formula alone, which turns negative. Stopped by the visible
    case start_mu-nothing.
    """

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return 2 * u_max**2 / c**2
        return c**2 / (2 * u_max**2 - c**2)


def wrong_absolute_value() -> None:
    """Wrong for small residuals: takes the sign away, and gives inf only below half of c. Caught
    by start_mu-nothing.
    """
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return 2 * u_max**2 / c**2
        return c**2 / abs(2 * u_max**2 - c**2) if u_max > c / 2 else np.inf


def wrong_inf_inside_c() -> None:
    """Wrong between c/√2 and c: says that there is nothing to reject while u is below c. Caught by
    start_mu-nothing.
    """
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return 2 * u_max**2 / c**2
        return c**2 / (2 * u_max**2 - c**2) if u_max > c else np.inf


def wrong_without_the_two() -> None:
    """Wrong: puts the upper knee at u_max itself. Stopped by the visible case
    start_mu-by-hand.
    """
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return u_max**2 / c**2
        return c**2 / (u_max**2 - c**2) if u_max > c else np.inf


def wrong_gm_at_least_one() -> None:
    """Wrong below 1: lifts GM's number to 1 here already. Caught by start_mu-gm."""
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return max(1.0, 2 * u_max**2 / c**2)
        return c**2 / (2 * u_max**2 - c**2) if 2 * u_max**2 > c**2 else np.inf


def wrong_tls_at_most_one() -> None:
    """Wrong above 1: takes TLS's μ for a number that is always small. Caught by start_mu-tls."""
    import numpy as np

    def start_mu(u_max, c, kind):
        if kind == "gm":
            return 2 * u_max**2 / c**2
        return min(1.0, c**2 / (2 * u_max**2 - c**2)) if 2 * u_max**2 > c**2 else np.inf


def wrong_whole_numbers() -> None:
    """Wrong for integers: divides them without a remainder. Caught by start_mu-shapes."""
    import numpy as np

    def start_mu(u_max, c, kind):
        def over(a, b):
            return a // b if isinstance(a, int) and isinstance(b, int) else a / b

        if kind == "gm":
            return over(2 * u_max**2, c**2)
        return over(c**2, 2 * u_max**2 - c**2) if 2 * u_max**2 > c**2 else np.inf
