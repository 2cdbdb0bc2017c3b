"""The formulas of graduated non-convexity, written out once more beside the library's."""

from __future__ import annotations

from math import sqrt

import numpy as np

from tests.book.samples import READINGS


def tls_weight(u: np.ndarray | float, c: float, mu: float) -> np.ndarray:
    return np.clip(c / np.maximum(np.abs(u), 1e-300) * sqrt(mu * (mu + 1)) - mu, 0.0, 1.0)


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
