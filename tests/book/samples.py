"""Problems and formulas that several pages return to, written out beside the library's."""

import math
from collections.abc import Callable

import numpy as np
from robust_slam.estimators import kernels
from robust_slam.problems import LinearProblem, chain
from robust_slam_course.quiz import Question
from scipy.integrate import quad

READINGS = np.array([0.1, -0.2, 0.15, -0.1, 5.0])
"""Four inliers and an outlier of 5 m; the chapters give them a sigma of 0.3."""


def three_poses(*closures: float, sigma: float = 0.05, odometry: float = 0.1) -> LinearProblem:
    """The chain of chapter 00: two steps of 1 m, and closures of these lengths over both."""
    ends = [(0, 1), (1, 2)] + [(0, 2)] * len(closures)
    spread = [odometry] * 2 + list(np.broadcast_to(sigma, len(closures)))
    trusted = [True, True] + [False] * len(closures)
    return chain(3, *np.transpose(ends), [1.0, 1.0, *closures], spread, trusted=trusted)


def assert_right_options_are_hidden(questions: list[Question], ratio: float) -> set[int]:
    """Fail if a right option is longer than others by the ratio; return the right places."""
    places = set()
    for question in questions:
        right = [option.correct for option in question.options].index(True)
        lengths = [len(option.text) for option in question.options]
        assert lengths.pop(right) <= ratio * max(lengths), question.prompt
        places.add(right)
    return places


def tls_weight(u: np.ndarray | float, c: float, mu: float) -> np.ndarray:
    return np.clip(c / np.maximum(np.abs(u), 1e-300) * math.sqrt(mu * (mu + 1)) - mu, 0.0, 1.0)


def gm_weight(u: np.ndarray | float, c: float, mu: float) -> np.ndarray:
    return (mu * c**2 / (np.square(u) + mu * c**2)) ** 2


def lesson_surrogate(u: float, mu: float, c: float = 2.0) -> float:
    """The lesson's surrogate, without the ½."""
    return c**2 * mu * u**2 / ((mu + 1) * c**2 + u**2)


def listing(steps: int, x: float = 0.0) -> tuple[float, float]:
    """The lesson's loop with its own weights: x and the outlier's weight."""
    mu, w = 1.0, np.ones(5)
    for _ in range(steps):
        w = mu * (mu + 1) / ((mu + 1) + (READINGS - x) ** 2) ** 2
        x = float(w @ READINGS / w.sum())
        mu *= 1.4
    return x, float(w[-1])


def efficiency(kernel: kernels.Kernel, d: int = 1) -> float:
    """Return the share for Gaussian residuals of ``d`` numbers, judged by their norm.

    The formula is another than the chapter's: by Stein's lemma the mean slope is E uψ.
    """
    scale = 2 ** (1 - d / 2) / math.gamma(d / 2)

    def mean(values: Callable[[float, float], float]) -> float:
        """The mean over the chi distribution, of ``d`` degrees of freedom, of the norm."""

        def share(u: float) -> float:
            return values(u, float(kernel.psi(u))) * scale * u ** (d - 1) * math.exp(-(u**2) / 2)

        return quad(share, 0, 14, points=[kernel.scale])[0]

    return mean(lambda u, psi: u * psi) ** 2 / (d * mean(lambda u, psi: psi**2))
