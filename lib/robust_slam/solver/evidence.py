"""Which of two maps the measurements support more: the evidence of a set of kept closures.

The evidence of a map is the probability of all measurements if its closures are inliers, over
all poses, and the others are outliers. Outliers measure what closures measure, a Gaussian with
the mean and the spread of all of them. So a closure is worth keeping if the map predicts it
better than this.

Source: Laplace 1774, as in MacKay 2003, chapter 28, for the integral over the poses; the density
of an outlier is derived here.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs.pose_graph import PoseGraph, residual_norms
from robust_slam.groups.group import Group
from robust_slam.solver.fitted import Fitted, relative_squares

_NEARBY = 1 / 3
"""A wrong closure is off by about this share of a step of the odometry at least …"""
_TURNED = 0.1
"""… and by about so many radians; else it would not be wrong."""
_FEW = 5
_ISOTROPIC = 1e-9
"""The mean of unit vectors is taken to be at least so long."""
_TINY = 1e-12


def outlier_entropy(graph: PoseGraph) -> float:
    """Return the entropy of what the closures of ``graph`` measure, in nats.

    It is that of a Gaussian in position and rotation, at most that of a uniform rotation. Of a
    few closures alone the spread is not known: then positions spread around 0, and rotations are
    uniform.
    """
    closures, d = ~graph.is_odometry, graph.group.DIMENSION
    translation, rotation = graph.translation[closures], graph.rotation[closures]
    steps = np.linalg.norm(graph.translation[graph.is_odometry], axis=1)
    nearby = (_NEARBY * float(np.median(steps)) if steps.size else 1.0) ** 2
    anything = _anything(d)
    if len(translation) < _FEW:
        square = translation.T @ translation / max(1, len(translation))
        return gaussian_entropy(square, nearby) + anything
    if d == 2:
        angle = np.arctan2(rotation[:, 1, 0], rotation[:, 0, 0])
        length = max(abs(np.exp(1j * angle).mean()), _ISOTROPIC)
        turned = np.array([[-2.0 * np.log(length)]])
    else:
        turned = np.cov(Rotation.from_matrix(rotation.copy()).as_rotvec().T)
    turn = gaussian_entropy(turned, _TURNED**2)
    return gaussian_entropy(np.cov(translation.T), nearby) + min(anything, turn)


def any_entropy(group: Group, poses: Array) -> float:
    """Return the entropy (nats) of where one of the ``poses`` ``(n, …)`` is seen from another."""
    spread = 2.0 * np.cov(group.translation(poses).T)
    return gaussian_entropy(spread, _TINY) + _anything(group.DIMENSION)


def _anything(d: int) -> float:
    """Return the entropy of a uniform rotation."""
    return float(np.log(2 * np.pi if d == 2 else 8 * np.pi**2))


def gaussian_entropy(covariance: Array, added: float) -> float:
    """Return the entropy of a Gaussian with ``covariance`` ``(d, d)`` and ``added`` on top."""
    d = len(covariance)
    spread = covariance + max(added, _TINY) * np.eye(d)
    return 0.5 * float(d * (1.0 + np.log(2.0 * np.pi)) + np.linalg.slogdet(spread)[1])


def evidence(
    graph: PoseGraph, poses: Array, kept: Mask, entropy: float, fit: Fitted | None = None
) -> float:
    """Return the log-evidence that the ``kept`` edges ``(m,)`` are the inliers.

    It is relative to odometry alone, with the same deviations: 0 where no closure is kept and
    ``poses`` are dead reckoning. An edge of the odometry that is not kept is an outlier too.
    ``poses`` are a minimum, and ``entropy`` is that of outliers. A ``fit`` of the kept edges at
    these poses, with whatever deviations, is used again. A map that is not determined has none.
    """
    squares = float(np.sum(residual_norms(graph, poses)[kept] ** 2))
    precision = float(np.sum(np.linalg.slogdet(graph.information[kept])[1]))
    odometry = graph.is_odometry
    closures = int(np.sum(kept & ~odometry)) - int(np.sum(~kept & odometry))
    constant = closures * (entropy - 0.5 * graph.group.DOF * np.log(2.0 * np.pi))
    fit = Fitted.of(graph, poses, kept) if fit is None else fit
    spread = fit.log_determinant(graph.information[kept])
    return float(constant + 0.5 * (precision - squares - spread))


def gains(graph: PoseGraph, poses: Array, kept: Mask, asked: Mask, entropy: float) -> Array:
    """Return how much evidence each closure that is ``asked`` about adds to a map, ``(k,)``.

    It is how much better, in nats, the map of the others predicts it than chance does, to first
    order: below 0 the map has more evidence without it. ``asked`` ``(m,)`` marks ``kept``
    closures without which the others still determine the poses; the rest is as in ``evidence``.

    Source: Baarda 1968 for what the others leave of a measurement; derived here from ``evidence``.
    """
    fit = Fitted.of(graph, poses, kept)
    closures = np.flatnonzero(asked[kept])
    return gained(fit, closures, fit.left(closures), entropy)


def gained(fit: Fitted, closures: Indices, left: Array, entropy: float) -> Array:
    """Return ``gains`` of ``closures`` ``(k,)`` of a fit, where noise leaves ``left`` of them."""
    off = fit.residuals[closures]
    precision = fit.graph.information[closures] @ left
    squares = relative_squares(off, left)
    chance = entropy - 0.5 * fit.graph.group.DOF * np.log(2.0 * np.pi)
    return np.asarray(chance + 0.5 * (np.linalg.slogdet(precision)[1] - squares))
