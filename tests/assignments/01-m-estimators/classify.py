"""Answers to exercise classify of 01-m-estimators: each body is a cell as handed in."""


def right_two_places() -> None:
    """Right: compares two places far out."""

    def classify(psi):
        near, far = abs(float(psi(1e6))), abs(float(psi(1e8)))
        if far == 0 or far < 0.2 * near:
            return "redescending"
        return "unbounded" if far > 1.5 * near else "bounded"


def right_beside_the_peak() -> None:
    """Right: what is left far out, beside the most that there ever was."""
    import numpy as np

    def classify(psi):
        pull = np.abs(psi(np.logspace(-4, 8, 2001)))
        if pull[-1] < 0.01 * np.max(pull):
            return "redescending"
        return "bounded" if pull[-1] < 1.1 * pull[-200] else "unbounded"


def right_slope_of_the_logarithm() -> None:
    """Right, another formula: the power of u with which ψ ends."""
    import numpy as np

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


def wrong_huber_unbounded() -> None:
    """Wrong: judges the cost ∫ψ, which for Huber grows for ever. Stopped by the visible case
    classify-by-hand.
    """
    import numpy as np

    def classify(psi):
        u = np.linspace(0.0, 1e4, 10_001)
        cost = np.cumsum(psi(u))
        if psi(1e8) < 1e-3:
            return "redescending"
        return "unbounded" if cost[-1] > 1.5 * cost[len(u) // 2] else "bounded"


def wrong_near_sighted() -> None:
    """Wrong: looks out to 100, below large thresholds. Caught by classify-large."""

    def classify(psi):
        near, far = float(psi(10.0)), float(psi(100.0))
        if far <= near / 2:
            return "redescending"
        return "unbounded" if far >= 1.2 * near else "bounded"


def wrong_divides_by_nothing() -> None:
    """Wrong: divides two pulls that may both be 0, and 0/0 is neither large nor small. Caught by
    classify-redescending.
    """
    import numpy as np

    def classify(psi):
        near, far = np.asarray(psi(np.array([1e7, 1e8])), dtype=float)
        ratio = far / near
        if ratio < 0.5:
            return "redescending"
        return "unbounded" if ratio > 2 else "bounded"


def wrong_small_is_a_number() -> None:
    """Wrong: calls a pull below a tenth nothing, though it may be all there ever was. Caught by
    classify-small.
    """

    def classify(psi):
        near, far = float(psi(1e7)), float(psi(1e8))
        if far < 0.1:
            return "redescending"
        return "unbounded" if far > 2 * near else "bounded"


def wrong_any_fall() -> None:
    """Wrong: takes every fall for a fall to 0. Caught by classify-levels."""
    import numpy as np

    def classify(psi):
        pull = np.asarray(psi(np.append(np.logspace(-4, 4, 801), [1e7, 1e8])), dtype=float)
        if pull[-1] < 0.9 * np.max(pull):
            return "redescending"
        return "unbounded" if pull[-1] > 1.5 * pull[-2] else "bounded"


def wrong_any_rise() -> None:
    """Wrong: takes every rise for growth without end. Stopped by the visible case
    classify-levels.
    """

    def classify(psi):
        near, far = float(psi(1e4)), float(psi(1e8))
        if far <= near / 2:
            return "redescending"
        return "unbounded" if far > near else "bounded"


def wrong_only_straight_growth() -> None:
    """Wrong: calls unbounded only what grows like u itself. Stopped by the visible case
    classify-growth.
    """

    def classify(psi):
        near, far = float(psi(1e7)), float(psi(1e8))
        if far <= near / 2:
            return "redescending"
        return "unbounded" if far > 9 * near else "bounded"


def wrong_growth_must_be_fast() -> None:
    """Wrong: calls unbounded only what has passed five thousand far out. Caught by
    classify-growth.
    """

    def classify(psi):
        near, far = float(psi(1e7)), float(psi(1e8))
        if far <= near / 2:
            return "redescending"
        return "unbounded" if far > 5e3 else "bounded"


def wrong_names() -> None:
    """Wrong: the words of another book. Stopped by the visible case classify-by-hand."""

    def classify(psi):
        near, far = float(psi(1e7)), float(psi(1e8))
        if far <= near / 2:
            return "hard redescender"
        return "unbounded" if far >= 2 * near else "monotone"


def wrong_ten_thousand_is_far() -> None:
    """Wrong horizon: looks out to ten thousand and no further. Caught by classify-growth."""
    import numpy as np

    def classify(psi):
        nearer, farther = psi(np.logspace(3, 4, 2))
        if farther <= nearer / 2:
            return "redescending"
        return "unbounded" if farther >= 2 * nearer else "bounded"
