"""Pose graphs as GTSAM's factor graphs, where gtsam is installed.

Each edge is a between factor with Gaussian noise of its information matrix. The error of the
factor graph is the cost of ``pose_graph.cost``, and a prior on pose 0 fixes the frame. At a
minimum it has no cost, and its deviations, 1 mm and 1 mrad, do not move the map. They are part of
GTSAM's marginals: that of pose 0 is 1e-6 I, while ``covariance`` returns 0.

Source: Dellaert 2012, "Factor graphs and GTSAM", for the conventions of the factors.
"""

from __future__ import annotations

from collections import Counter
from contextlib import suppress
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from robust_slam._arrays import Array
from robust_slam._words import counted
from robust_slam.files.formats import BITS, PYFG
from robust_slam.files.g2o import checked_names
from robust_slam.files.graph_file import GraphFile
from robust_slam.graphs.pose_graph import PoseGraph, check_poses, steps_of

if TYPE_CHECKING:
    import gtsam

_PRIOR_SIGMA = 1e-3
"""Standard deviation of the prior, in m and rad."""
_ORDER = {2: np.arange(3), 3: np.array([3, 4, 5, 0, 1, 2])}
"""In space GTSAM has the rotation first."""


def to_gtsam(
    graph: PoseGraph, poses: ArrayLike, names: ArrayLike | None = None
) -> tuple[gtsam.NonlinearFactorGraph, gtsam.Values]:
    """Return GTSAM's factor graph of ``graph`` and its values at ``poses``.

    ``poses`` are ``(n, 3)`` or ``(n, 3, 4)``, and ``names`` ``(n,)`` their keys, such as the
    ``ids`` of ``from_gtsam``, by default 0 to n − 1. The factors have the order of the edges,
    followed by the prior on pose 0.

    Raises:
        ImportError, ValueError: gtsam is not installed, or ``poses`` or ``names`` do not fit.
    """
    checked = check_poses("poses", poses, graph)
    gtsam = _gtsam()
    d = graph.group.DIMENSION
    between, prior = (getattr(gtsam, f"{kind}FactorPose{d}") for kind in ("Between", "Prior"))
    order = _ORDER[d]
    information = graph.information[:, order][:, :, order]
    factors, values = gtsam.NonlinearFactorGraph(), gtsam.Values()
    keys = checked_names(names, graph.n)
    edges = keys[graph.edges].tolist()
    for (i, j), z, omega in zip(edges, graph.measurement, information, strict=True):
        factors.add(between(i, j, _theirs(z), gtsam.noiseModel.Gaussian.Information(omega)))
    noise = gtsam.noiseModel.Isotropic.Sigma(graph.group.DOF, _PRIOR_SIGMA)
    factors.add(prior(int(keys[0]), _theirs(checked[0]), noise))
    for key, pose in zip(keys.tolist(), checked, strict=True):
        values.insert(key, _theirs(pose))
    return factors, values


def poses_from_gtsam(
    values: gtsam.Values, graph: PoseGraph, names: ArrayLike | None = None
) -> Array:
    """Return the poses ``(n, 3)`` or ``(n, 3, 4)`` of the keys that ``to_gtsam`` gave them.

    Raises:
        ValueError: a key is missing, or holds something other than a pose of the group.
    """
    at = values.atPose2 if graph.group.DIMENSION == 2 else values.atPose3
    try:
        return np.array([_ours(at(key)) for key in checked_names(names, graph.n).tolist()])
    except RuntimeError as error:
        raise ValueError(
            f"values: {str(error).rstrip('.')}; give the values of this graph's factors"
        ) from None


def from_gtsam(
    factors: gtsam.NonlinearFactorGraph, values: gtsam.Values | None = None
) -> GraphFile:
    """Return the pose graph of GTSAM's between factors, and ``values`` as its poses.

    Its ``ids`` are the keys, ascending, and its ``names`` those of symbols, such as x7. Of robust
    noise the Gaussian part is taken. Which edges are odometry is found as for files, where the
    letter of a symbol is the robot. Other factors, such as priors, are left out, with a note.

    Raises:
        ImportError: gtsam is not installed.
        ValueError: there is no between factor of poses, they are of both groups or do not
            connect all keys, a noise model is not Gaussian, or a value is missing.

    Source: Dellaert 2012, for the conventions of the factors.
    """
    gtsam, others = _gtsam(), Counter[str]()
    kinds = {gtsam.BetweenFactorPose2: [], gtsam.BetweenFactorPose3: []}  # type: ignore[var-annotated]
    for factor in map(factors.at, range(factors.size())):
        if type(factor) in kinds:
            kinds[type(factor)].append(factor)
        elif factor is not None:
            others[type(factor).__name__] += 1
    used = [found for found in kinds.values() if found]
    if len(used) != 1:
        raise ValueError("factors: give BetweenFactorPose2 or BetweenFactorPose3, and one of both")
    keys = np.array([list(factor.keys()) for factor in used[0]], dtype=np.int64)
    plane, ids = used[0] is kinds[gtsam.BetweenFactorPose2], np.unique(keys)
    edges = np.searchsorted(ids, keys)
    measured = np.array([_ours(factor.measured()) for factor in used[0]])
    order = _ORDER[2 if plane else 3]
    information = np.array([_information(gtsam, factor) for factor in used[0]])
    information, steps = information[:, order][:, :, order], steps_of(edges, measured, ids >> BITS)
    graph = PoseGraph(ids.size, edges, measured, information, steps)
    poses = None if values is None else poses_from_gtsam(values, graph, ids)
    names = PYFG.names(ids) if np.all(ids >> BITS) else ids
    notes = (f"left out {counted(count, 'factor')} {kind}" for kind, count in others.items())
    return GraphFile(graph, poses, ids, names, notes=tuple(notes))


def _information(gtsam: ModuleType, factor: Any) -> Array:  # noqa: ANN401 (a between factor)
    noise = factor.noiseModel()
    if isinstance(noise, gtsam.noiseModel.Robust):
        noise = noise.noise()
    if not isinstance(noise, gtsam.noiseModel.Gaussian):
        raise ValueError(f"factors: the noise of {factor.keys()} is not Gaussian; give it sigmas")
    return np.asarray(noise.R().T @ noise.R())


def _gtsam() -> ModuleType:
    with suppress(ImportError):
        return import_module("gtsam")
    raise ImportError("gtsam is missing; install it with: pip install gtsam")


def _ours(pose: Any) -> Array:  # noqa: ANN401 (a Pose2 or a Pose3)
    if hasattr(pose, "theta"):
        return np.array([pose.x(), pose.y(), pose.theta()])
    return np.asarray(pose.matrix()[:3])


def _theirs(pose: Array) -> Any:  # noqa: ANN401 (a Pose2 or a Pose3)
    gtsam = _gtsam()
    plane = pose.ndim == 1
    return gtsam.Pose2(*pose) if plane else gtsam.Pose3(gtsam.Rot3(pose[:, :3]), pose[:, 3])
