"""Answers to exercise solve_switchable of 06-switches-and-consistency: each body is a cell."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_in_turns() -> None:
    """Right: x and the switches in turns, five hundred times."""

    def solve_switchable(z, sigma, is_loop, lam):
        z, sigma = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)
        s = np.ones(len(z))
        for _ in range(500):
            x = np.average(z, weights=(s / sigma) ** 2)
            s = np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0)
        return x, s


def right_plain_lists() -> None:
    """Right: plain Python, a list of switches, until x no longer changes."""

    def solve_switchable(z, sigma, is_loop, lam):
        sigmas = list(sigma) if hasattr(sigma, "__len__") else [sigma] * len(z)
        s, x, old = [1.0] * len(z), 0.0, float("inf")
        while abs(x - old) > 1e-12:
            w = [(switch / d) ** 2 for switch, d in zip(s, sigmas)]
            x, old = sum(a * b for a, b in zip(w, z)) / sum(w), x
            doubted = [lam / (lam + ((a - x) / d) ** 2) for a, d in zip(z, sigmas)]
            s = [one if loop else 1.0 for one, loop in zip(doubted, is_loop)]
        return x, s


def right_root_of_the_slope() -> None:
    """Right, an equivalent form: eliminates the switches and finds where the slope is zero."""
    from scipy.optimize import brentq

    def solve_switchable(z, sigma, is_loop, lam):
        z = np.asarray(z, dtype=float)
        sigma = np.asarray(sigma, dtype=float) * np.ones(z.shape)

        def switches(x):
            return np.where(is_loop, lam / (lam + ((z - x) / sigma) ** 2), 1.0)

        def slope(x):
            return np.sum(switches(x) ** 2 * (x - z) / sigma**2)

        x = brentq(slope, z.min() - 1, z.max() + 1, xtol=1e-13)
        return x, switches(x)


def right_joint_least_squares() -> None:
    """Right, a library routine: x and the switches of the loops together, as in the paper."""
    from scipy.optimize import least_squares

    def solve_switchable(z, sigma, is_loop, lam):
        z, sigma = np.asarray(z, dtype=float), np.full(len(z), sigma, dtype=float)

        def rows(v):
            s = np.where(is_loop, v[1:], 1.0)
            return np.append(s * (z - v[0]) / sigma, np.sqrt(lam) * (1 - v[1:]))

        start = np.append(np.average(z, weights=sigma**-2.0), np.ones(z.size))
        best = least_squares(rows, start, "3-point", xtol=1e-15, ftol=1e-15, gtol=1e-12).x
        return best[0], np.where(is_loop, best[1:], 1.0)


wrong_no_price = change(
    right_in_turns, "lam / (lam", "0 / (lam", stopped_by="solve_switchable-by-hand"
)
"""Wrong: without the price nothing holds a switch, and all loops are turned off."""

wrong_loops_and_odometry_confused = change(
    right_in_turns, "(is_loop", "(np.logical_not(is_loop)", stopped_by="solve_switchable-by-hand"
)
"""Wrong: the mask is read the other way round, and the trusted ones are doubted."""

wrong_everybody_doubted = change(
    right_in_turns,
    ("(is_loop", "(True"),
    ("return x, s", "return x, np.where(is_loop, s, 1.0)"),
    stopped_by="solve_switchable-by-hand",
)
"""Wrong: the solve doubts every measurement; only the switches that it returns are right."""

wrong_one_round = change(right_in_turns, "500", "2", stopped_by="solve_switchable-by-hand")
"""Wrong: sets the switches at plain least squares, solves once, and stops."""

wrong_weight_not_squared = change(
    right_in_turns, "(s / sigma) ** 2", "s / sigma**2", stopped_by="solve_switchable-by-hand"
)
"""Wrong: the switch itself is the weight, as if it scaled χ² and not the residual."""

wrong_returns_weights = change(
    right_in_turns, "return x, s", "return x, s**2", stopped_by="solve_switchable-by-hand"
)
"""Wrong: returns the weights s², and not the switches."""

wrong_one_switch_for_all = change(
    right_in_turns,
    "((z - x) / sigma) ** 2",
    "np.mean(((z - x) / sigma)[np.asarray(is_loop, dtype=bool)] ** 2)",
    caught_by="solve_switchable-outliers",
)
"""Wrong: all loops share one switch, from the mean of their χ²."""

wrong_not_whitened = change(
    right_in_turns, "((z - x) / sigma)", "(z - x)", caught_by="solve_switchable-sigmas"
)
"""Wrong: sets the switches from z - x, without dividing it by σ."""

wrong_loose_stop = change(right_plain_lists, "1e-12", "0.01", caught_by="solve_switchable-balance")
"""Wrong: stops as soon as x moves by less than a hundredth."""
