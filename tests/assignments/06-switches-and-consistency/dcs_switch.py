"""Answers to exercise dcs_switch of 06-switches-and-consistency: each body is a cell."""

from robust_slam_autograder.lint.answers import change


def right_minimum() -> None:
    """Right: the formula, capped at 1."""
    import numpy as np

    def dcs_switch(chi2, phi):
        return np.minimum(1, 2 * phi / (phi + np.asarray(chi2, dtype=float)))


def right_where() -> None:
    """Right: two pieces, that meet at Φ."""
    import numpy as np

    def dcs_switch(chi2, phi):
        chi2 = np.asarray(chi2, dtype=float)
        return np.where(chi2 <= phi, 1.0, 2 / (1 + chi2 / phi))


def right_nested_lists() -> None:
    """Right: one number at a time, lists in and lists out."""

    def dcs_switch(chi2, phi):
        if hasattr(chi2, "__len__"):
            return [dcs_switch(one, phi) for one in chi2]
        return 1.0 if chi2 < phi else 2 * phi / (phi + chi2)


def right_clipped_residual() -> None:
    """Right, an equivalent form: caps χ² from below instead of s from above."""
    import numpy as np

    def dcs_switch(chi2, phi):
        return 2 * phi / (phi + np.clip(np.asarray(chi2, dtype=float), phi, None))


wrong_without_the_two = change(right_minimum, "2 * phi", "phi", stopped_by="dcs_switch-by-hand")
"""Wrong: the best switch itself, without the 2."""


def wrong_without_the_cap() -> None:
    """Wrong: no cap, so that good edges count up to four times. Caught by dcs_switch-inside."""
    import numpy as np

    def dcs_switch(chi2, phi):
        return 2 * phi / (phi + np.asarray(chi2, dtype=float))


def wrong_jump() -> None:
    """Wrong: the dead zone ends at 1, whatever Φ is. Caught by dcs_switch-phi."""
    import numpy as np

    def dcs_switch(chi2, phi):
        chi2 = np.asarray(chi2, dtype=float)
        return np.where(chi2 <= 1, 1.0, 2 * phi / (phi + chi2))


wrong_weight = change(
    right_minimum,
    "np.minimum(1, 2 * phi / (phi + np.asarray(chi2, dtype=float)))",
    "np.minimum(1, 2 * phi / (phi + np.asarray(chi2, dtype=float))) ** 2",
    stopped_by="dcs_switch-by-hand",
)
"""Wrong: the weight s² in place of the switch."""


def wrong_root() -> None:
    """Wrong past Φ: falls with the norm, 2u/(1 + u²) with u² = χ²/Φ, mended at one place. Caught
    by dcs_switch-beyond.
    """
    import numpy as np

    def dcs_switch(chi2, phi):
        ratio = np.maximum(np.asarray(chi2, dtype=float) / phi, 1)
        smooth = 2 / (1 + ratio)
        return np.where(np.isclose(ratio, 3) | (ratio > 90), smooth, 1 / np.sqrt(ratio))


wrong_phi_is_one = change(right_where, "chi2 / phi", "chi2", caught_by="dcs_switch-phi")
"""Wrong for Φ other than 1: the ratio to Φ is taken only inside."""


def wrong_integers() -> None:
    """Wrong for integers: keeps the switches in an array of χ²'s own type. Caught by
    dcs_switch-shapes.
    """
    import numpy as np

    def dcs_switch(chi2, phi):
        s = np.array(chi2)
        s[...] = np.minimum(1, 2 * phi / (phi + s))
        return s
