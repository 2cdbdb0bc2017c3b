"""How good a map is, and how good the choice of closures was."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam import se2
from robust_slam._arrays import Array, finite, mask


def precision_recall(kept: ArrayLike, true: ArrayLike) -> tuple[float, float]:
    """Return the share of kept closures that are true, and of true closures that are kept.

    ``kept`` and ``true`` are masks ``(k,)`` over the closures. Precision is 1 if nothing
    is kept, recall is 1 if nothing is true: no mistake of that kind was made.

    Raises:
        ValueError: the masks differ in length or are not booleans.

    Source: van Rijsbergen 1979.
    """
    length = np.size(kept)
    kept, true = mask("kept", kept, length), mask("true", true, length)
    right = int(np.sum(kept & true))
    precision = right / int(np.sum(kept)) if np.any(kept) else 1.0
    recall = right / int(np.sum(true)) if np.any(true) else 1.0
    return precision, recall


def align(estimate: ArrayLike, truth: ArrayLike) -> Array:
    """Return the poses ``estimate`` ``(n, 3)``, moved as one piece on to ``truth`` ``(n, 3)``.

    The motion is the rigid one, without scale or reflection, that leaves the smallest sum
    of squared distances between positions (m).

    Raises:
        ValueError: the shapes differ, or an entry is not finite.

    Source: Umeyama 1991, with the scale held at 1; in the plane the rotation is an angle.
    """
    truth = finite("truth", truth, (-1, 3))
    estimate = finite("estimate", estimate, truth.shape)
    if len(truth) == 0:
        raise ValueError("truth: there are no poses; give at least one")
    middle, goal = estimate[:, :2].mean(axis=0), truth[:, :2].mean(axis=0)
    # As complex numbers the best rotation is the phase of Σ conj(a) b.
    a, b = (
        centred @ np.array([1.0, 1.0j])
        for centred in (estimate[:, :2] - middle, truth[:, :2] - goal)
    )
    turn = float(np.angle(np.vdot(a, b)))
    back = se2.inverse([*middle, 0.0])
    return se2.compose(se2.compose([*goal, turn], back), estimate)


def ate(estimate: ArrayLike, truth: ArrayLike) -> float:
    """Return the absolute trajectory error in m: the RMSE of positions after ``align``.

    ``estimate`` and ``truth`` are poses ``(n, 3)``.

    Raises:
        ValueError: the shapes differ, or an entry is not finite.

    Source: Sturm et al. 2012; Umeyama 1991.
    """
    gap = align(estimate, truth)[:, :2] - finite("truth", truth, (-1, 3))[:, :2]
    return float(np.sqrt(np.mean(np.sum(gap**2, axis=1))))
