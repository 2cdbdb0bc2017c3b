"""Errors of maps, also beside their covariance, and precision and recall of kept closures.

Maps are poses ``(n, 3)`` in SE(2) or ``(n, 3, 4)`` in SE(3).
"""

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array, finite, mask, pose_numbers
from robust_slam.groups.group import Group, group_of
from robust_slam.groups.rotations import nearest_rotations


def precision_recall(kept: ArrayLike, true: ArrayLike) -> tuple[float, float]:
    """Return precision and recall: the share of kept closures that are true, and vice versa.

    ``kept`` and ``true`` are masks ``(k,)`` over the closures. A share of no closures is 1.

    Raises:
        ValueError: the masks differ in length or are not booleans.

    Source: van Rijsbergen 1979, chapter 7.

    >>> precision_recall([True, True, True, False], [True, True, False, True])
    (0.6666666666666666, 0.6666666666666666)
    """
    length = np.size(kept)
    kept, true = mask("kept", kept, length), mask("true", true, length)
    right = int(np.sum(kept & true))
    precision = right / int(np.sum(kept)) if np.any(kept) else 1.0
    recall = right / int(np.sum(true)) if np.any(true) else 1.0
    return precision, recall


def align(estimate: ArrayLike, truth: ArrayLike) -> Array:
    """Return the poses ``estimate``, aligned to ``truth`` by a rigid motion.

    Both are ``(n, 3)`` or ``(n, 3, 4)``. The motion, without scale or reflection, minimises
    the sum of squared distances between positions (m). Where it is not unique (one pose, or
    in space all positions on a line), it is one of the minimisers.

    Raises:
        ValueError: the shapes differ, there are no poses, or an entry is not finite.

    Source: Umeyama 1991, the theorem on least-squares estimation, with the scale fixed at 1.
    """
    estimate, truth, group = _maps(estimate, truth)
    position, goal = group.translation(estimate), group.translation(truth)
    from_centre, to_centre = position.mean(axis=0), goal.mean(axis=0)
    # The optimal rotation maximises tr(R Σ a bᵀ), a and b being the centred positions.
    rotation = nearest_rotations((goal - to_centre).T @ (position - from_centre))
    motion = group.from_parts(rotation, to_centre - rotation @ from_centre)
    return group.compose(motion, estimate)


def ate(estimate: ArrayLike, truth: ArrayLike) -> float:
    """Return the absolute trajectory error in m: the RMSE of positions after ``align``.

    ``estimate`` and ``truth`` are poses ``(n, 3)`` or ``(n, 3, 4)``. Orientations are ignored.
    Rows are not matched by time, so do this first: ``estimate[file.nearest(t)]`` are the poses of
    a file at the times t ``(k,)`` of a truth. Beside a map in the plane, a truth in space is
    ``np.pad(truth[:, :2, 3], ((0, 0), (0, 1)))``.

    Source: Sturm et al. 2012, the absolute trajectory error; Umeyama 1991.

    >>> truth = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    >>> round(ate(truth * 1.1 + [5.0, 0.0, 0.0], truth), 4)
    0.0816
    """
    estimate, truth, group = _maps(estimate, truth)
    error = group.translation(align(estimate, truth)) - group.translation(truth)
    return float(np.sqrt(np.mean(np.sum(error**2, axis=1))))


def nees(estimate: ArrayLike, truth: ArrayLike, k: ArrayLike, covariance: ArrayLike) -> Array:
    """Return the normalised estimation error squared eᵀ Σ⁻¹ e of poses ``k`` ``(…)``, ``(…)``.

    ``estimate`` and ``truth`` are whole maps ``(n, 3)`` or ``(n, 3, 4)``, and ``covariance``
    ``(…, D, D)`` is that of ``robust_slam.covariance`` at the same ``k``. The error has the
    coordinates of that covariance: e = Log(x⁻¹ ∘ y), where x is the estimated pose and y the true
    one, both in the frame of their pose 0. The difference of coordinates y − x has other ones,
    and its numbers are too large.

    Where the covariance is right, the number has nearly a χ² distribution with D degrees of
    freedom: the mean over N independent maps is within 1.96 √(2D/N) of D in 95 % of all cases.

    Raises:
        ValueError: the shapes differ, an entry is not finite, ``k`` is not a pose, or a
            covariance is not positive definite, as that of pose 0.

    Source: Bar-Shalom, Li and Kirubarajan 2001, section 5.4, the test of consistency; Solà et al.
    2018 for the coordinates.

    >>> truth = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    >>> float(nees(truth + [[0, 0, 0], [0.2, 0, 0]], truth, 1, 0.01 * np.eye(3)).round(6))
    4.0
    """
    estimate, truth, group = _maps(estimate, truth)
    chosen = pose_numbers("k", k, len(truth))
    sigma = finite("covariance", covariance, (*chosen.shape, group.DOF, group.DOF))
    definite = np.linalg.eigvalsh(sigma)[..., 0] > 0.0
    for pose in chosen[~definite][:1]:
        raise ValueError(
            f"covariance: that of pose {pose} is not positive definite; pose 0 is held and has "
            "none, so leave it out, and take the others from robust_slam.covariance"
        )
    here, there = (group.between(poses[0], poses[chosen]) for poses in (estimate, truth))
    error = group.log(group.between(here, there))
    return np.asarray(np.sum(error * np.linalg.solve(sigma, error[..., None])[..., 0], axis=-1))


def _maps(estimate: ArrayLike, truth: ArrayLike) -> tuple[Array, Array, Group]:
    shape = (-1, 3, 4) if np.ndim(truth) == 3 else (-1, 3)
    true = finite("truth", truth, shape)
    estimated = finite("estimate", estimate, true.shape)
    if len(true) == 0:
        raise ValueError("truth: there are no poses; give at least one")
    return estimated, true, group_of(true)
