"""Answers to exercise classify of 01-m-estimators: each body is a cell as handed in."""

import numpy as np
from robust_slam_autograder.lint.answers import change


def right_pair() -> None:
    """Right: compares two places far out."""

    def classify(psi):
        near, far = float(psi(1e7)), float(psi(1e8))
        if far <= near / 2:
            return "redescending"
        return "unbounded" if far >= 2 * near else "bounded"


def right_beside_the_peak() -> None:
    """Right: what is left far out, beside the most that there ever was."""

    def classify(psi):
        pull = np.abs(psi(np.logspace(-4, 8, 2001)))
        if pull[-1] < 0.01 * np.max(pull):
            return "redescending"
        return "bounded" if pull[-1] < 1.1 * pull[-200] else "unbounded"


def right_slope_of_the_logarithm() -> None:
    """Right, another formula: the power of u with which ψ ends."""

    def classify(psi):
        at = np.array([1e7, 1e8])
        near, far = np.log(np.abs(psi(at)) + 1e-300)
        power = (far - near) / np.log(10.0)
        if power > 0.1:
            return "unbounded"
        return "redescending" if power < -0.1 or far < -600 else "bounded"


def right_decade_by_decade() -> None:
    """Right: walks out decade by decade and counts the last steps up and down."""

    def classify(psi):
        pulls = [float(psi(10.0**k)) for k in range(4, 9)]
        if pulls[-1] <= 0.01 * max(pulls) or pulls[-1] < 0.5 * pulls[-2]:
            return "redescending"
        if pulls[-1] > 1.2 * pulls[-2]:
            return "unbounded"
        return "bounded"


wrong_huber_unbounded = change(
    right_pair,
    "far >= 2 * near",
    "np.sum(psi(np.arange(1e4))) > 1.5 * np.sum(psi(np.arange(5e3)))",
    stopped_by="classify-by-hand",
)
"""Wrong: judges the cost ∫ψ, which for Huber grows for ever."""

wrong_near_sighted = change(
    right_pair,
    ("psi(1e7)), float(psi(1e8))", "psi(10.0)), float(psi(100.0))"),
    ("2 * near", "1.2 * near"),
    caught_by="classify-large",
)
"""Wrong: looks out to 100, below large thresholds."""

wrong_divides_by_nothing = change(
    right_pair, "far <= near / 2", "np.divide(far, near) < 0.5", caught_by="classify-redescending"
)
"""Wrong: divides two pulls that may both be 0, and 0/0 is neither large nor small."""

wrong_small_is_a_number = change(
    right_pair, "far <= near / 2", "far < 0.1", caught_by="classify-small"
)
"""Wrong: calls a pull below a tenth nothing, though ψ may never have been larger."""

wrong_any_fall = change(right_beside_the_peak, "0.01", "0.9", caught_by="classify-levels")
"""Wrong: takes every fall for a fall to 0."""

wrong_any_rise = change(
    right_pair, ("1e7", "1e4"), ("far >= 2 * near", "far > near"), stopped_by="classify-levels"
)
"""Wrong: takes every rise for growth without end."""

wrong_only_straight_growth = change(
    right_pair, "2 * near", "9 * near", stopped_by="classify-growth"
)
"""Wrong: calls unbounded only what grows like u itself."""

wrong_growth_must_be_fast = change(
    right_pair, "far >= 2 * near", "far > 5e3", caught_by="classify-growth"
)
"""Wrong: calls unbounded only what has passed five thousand far out."""

wrong_names = change(
    right_pair, '"redescending"', '"hard redescender"', stopped_by="classify-by-hand"
)
"""Wrong: the word of another book."""

wrong_ten_thousand_is_far = change(
    right_pair, ("1e7", "1e3"), ("1e8", "1e4"), caught_by="classify-growth"
)
"""Wrong horizon: looks out to ten thousand and no further."""
