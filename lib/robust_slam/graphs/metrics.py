"""How good a map is, and how good the choice of closures was.

Maps are poses ``(n, 3)`` in SE(2) or ``(n, 3, 4)`` in SE(3).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, finite, mask
from robust_slam.graphs.group import Group, group_of


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
    """Return the poses ``estimate``, moved as one piece on to ``truth``.

    Both are ``(n, 3)`` or ``(n, 3, 4)``. The motion is the rigid one, without scale or
    reflection, that leaves the smallest sum of squared distances between positions (m).
    Where positions leave it open (one pose, or in space all on one line), it is one of the
    best.

    Raises:
        ValueError: the shapes differ, there are no poses, or an entry is not finite.

    Source: Umeyama 1991, with the scale held at 1.
    """
    estimate, truth, group = _maps(estimate, truth)
    place, goal = group.translation(estimate), group.translation(truth)
    middle, centre = place.mean(axis=0), goal.mean(axis=0)
    # The best rotation maximises tr(R Σ a bᵀ), a and b being the centred positions.
    u, _, vt = np.linalg.svd((goal - centre).T @ (place - middle))
    mirrored = np.linalg.det(u) * np.linalg.det(vt) < 0.0
    u[:, -1] *= -1.0 if mirrored else 1.0
    turn = u @ vt
    return group.compose(group.from_parts(turn, centre - turn @ middle), estimate)


def ate(estimate: ArrayLike, truth: ArrayLike) -> float:
    """Return the absolute trajectory error in m: the RMSE of positions after ``align``.

    ``estimate`` and ``truth`` are poses ``(n, 3)`` or ``(n, 3, 4)``. Headings are not judged.

    Raises:
        ValueError: as ``align``.

    Source: Sturm et al. 2012; Umeyama 1991.
    """
    estimate, truth, group = _maps(estimate, truth)
    gap = group.translation(align(estimate, truth)) - group.translation(truth)
    return _rms(gap)


def rpe(estimate: ArrayLike, truth: ArrayLike, delta: int = 1) -> tuple[float, float]:
    """Return the relative pose error over ``delta`` steps: RMSE in m and RMSE in rad.

    With the poses p of ``estimate`` and q of ``truth``, ``(n, 3)`` or ``(n, 3, 4)``, the
    error of step k is E_k = (q_k⁻¹ ∘ q_{k+Δ})⁻¹ ∘ (p_k⁻¹ ∘ p_{k+Δ}), for every k from 0 to
    n − Δ − 1, so that steps overlap. The first number is the root of the mean square length
    of its translation, the second that of its angle of rotation, in [0, π]. Nothing is
    aligned: moving either map as one piece changes neither number.

    Raises:
        ValueError: the shapes differ, an entry is not finite, or ``delta`` is not from 1
            to n − 1.

    Source: Sturm et al. 2012, who use the translation alone; the angle is measured in the
    same way.
    """
    estimate, truth, group = _maps(estimate, truth)
    if delta != int(delta) or not 1 <= delta < len(truth):
        raise ValueError(
            f"delta is {delta}, and there are {len(truth)} poses; give a whole number of at "
            "least 1 and below that"
        )
    walked, true = (
        group.between(poses[: -int(delta)], poses[int(delta) :]) for poses in (estimate, truth)
    )
    error = group.between(true, walked)
    return _rms(group.translation(error)), _rms(group.log(error)[:, group.DIMENSION :])


def _maps(estimate: ArrayLike, truth: ArrayLike) -> tuple[Array, Array, Group]:
    shape = (-1, 3, 4) if np.ndim(truth) == 3 else (-1, 3)
    true = finite("truth", truth, shape)
    estimated = finite("estimate", estimate, true.shape)
    if len(true) == 0:
        raise ValueError("truth: there are no poses; give at least one")
    return estimated, true, group_of(true)


def _rms(vectors: Array) -> float:
    """Return the root of the mean square length of the rows."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))
