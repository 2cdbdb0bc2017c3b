"""Pose graphs with known true poses: a circle, a walk through a town, a sphere.

Measurements are z = x_i⁻¹ ∘ x_j ∘ Exp(η) with Gaussian η, so at the true poses the whitened
residuals are exactly standard normal. The true poses start at the identity; derived here.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from robust_slam._arrays import Array, Indices, finite, positive
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.groups import se2, se3
from robust_slam.groups.group import Group, group_of

_MORE = 1.0 + 1e-9
"""Distances that rounding makes larger by this factor are near enough."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations of each coordinate of the translation and the rotation, in m and rad.

    ``scale`` multiplies the noise but not the information matrix; 0 gives exact measurements.
    """

    odometry: tuple[float, float] = (0.05, 0.02)
    closure: tuple[float, float] = (0.05, 0.02)
    scale: float = 1.0


def circle(
    n: int,
    rng: int | np.random.Generator,
    *,
    radius: float = 5.0,
    laps: int = 1,
    closures: int = 1,
    noise: Noise | None = None,
) -> tuple[PoseGraph, Array]:
    """Return a drive of ``n`` poses around a circle, and the true poses ``(n, 3)``.

    The robot drives ``laps`` rounds of ``radius`` m anticlockwise. The ``closures`` are drawn from
    all pairs no further apart than consecutive poses: in one round the last pose and pose 0.

    Raises:
        ValueError: an argument is out of range, or there are fewer such pairs.

    >>> graph, truth = circle(8, np.random.default_rng(0), noise=Noise(scale=0.0))
    >>> graph.n, len(graph.edges), truth[4].round(3).tolist()
    (8, 8, [0.0, 10.0, 3.142])
    """
    rng = np.random.default_rng(rng)
    if n < 3 or laps < 1:
        raise ValueError(f"n is {n} and laps {laps}; give at least 3 poses and 1 lap")
    angle = 2.0 * np.pi * laps * np.arange(n) / n
    radius = positive("radius", radius)
    x, y = radius * np.sin(angle), radius * (1.0 - np.cos(angle))
    truth = np.column_stack([x, y, se2.wrap(angle)])
    reach = 2.0 * radius * np.sin(np.pi * laps / n)
    pairs = _drawn(near_pairs(truth[:, :2], reach * _MORE), closures, rng)
    return _measured(truth, pairs, noise, rng), truth


def manhattan(
    n: int,
    rng: int | np.random.Generator,
    *,
    block: float = 1.0,
    side: int | None = None,
    turn: float = 0.3,
    closures: int | None = None,
    noise: Noise | None = None,
) -> tuple[PoseGraph, Array]:
    """Return a walk of ``n`` poses through a town of blocks, and the true poses ``(n, 3)``.

    The town has ``side`` by ``side`` blocks of ``block`` m, by default about √n/2, and the walk
    starts at a corner. Each step leads one block ahead. At each crossing the robot turns left
    or right with probability ``turn``, and always where the street ends. The ``closures``, by
    default n/5, are drawn from all pairs of poses at most one block apart and not consecutive.

    Raises:
        ValueError: an argument is out of range, or there are fewer such pairs.

    Source: Olson, Leonard and Teller 2006, the simulated Manhattan world.

    >>> graph, truth = manhattan(50, np.random.default_rng(0), closures=6)
    >>> len(graph.edges), int(graph.is_odometry.sum()), truth.shape
    (55, 49, (50, 3))
    """
    rng = np.random.default_rng(rng)
    if n < 3:
        raise ValueError(f"n is {n}; give at least 3 poses")
    if not 0.0 <= turn <= 1.0:
        raise ValueError(f"turn is {turn}; give a probability from 0 to 1")
    side = max(1, round(np.sqrt(n) / 2.0)) if side is None else side
    if side < 1:
        raise ValueError(f"side is {side}; give at least 1 block")
    block = positive("block", block)
    crossing, facing = _walk(n, side, turn, rng)
    truth = np.column_stack([block * crossing, se2.wrap(facing * np.pi / 2)])
    count = n // 5 if closures is None else closures
    pairs = _drawn(near_pairs(truth[:, :2], block * _MORE), count, rng)
    return _measured(truth, pairs, noise, rng), truth


def sphere(
    n: int,
    rng: int | np.random.Generator,
    *,
    around: int | None = None,
    radius: float = 5.0,
    neighbours: int = 1,
    closures: int | None = None,
    noise: Noise | None = None,
) -> tuple[PoseGraph, Array]:
    """Return a spiral path of ``n`` poses on a sphere, and the true poses ``(n, 3, 4)``.

    The path winds from pole to pole with ``around`` poses per ring, by default about √n. The robot
    faces its direction of motion, and its z axis points outwards from the sphere of ``radius`` m.
    The ``closures``, by default all, are drawn from the pairs (k, k + around), neighbours on
    consecutive rings, or with ``neighbours`` 3, 5, … from that many poses of the next ring.

    Raises:
        ValueError: an argument is out of range, or there are fewer such pairs.

    Source: derived here, modelled on the graph sphere2500.
    """
    rng = np.random.default_rng(rng)
    if n < 3:
        raise ValueError(f"n is {n}; give at least 3 poses")
    around = max(3, round(np.sqrt(n))) if around is None else around
    if around < 3:
        raise ValueError(f"around is {around}; give at least 3 poses a turn")
    if neighbours < 1 or neighbours % 2 == 0 or neighbours > around:
        raise ValueError(f"neighbours is {neighbours}; give an odd number up to {around}")
    truth = _winding(n, around, positive("radius", radius))
    beside = np.arange(neighbours) - neighbours // 2
    first, after = np.divmod(np.arange(n * neighbours), neighbours)
    pairs = np.stack([first, first + around + beside[after]], axis=1)
    pairs = pairs[(pairs[:, 1] < n) & (pairs[:, 1] > pairs[:, 0] + 1)]
    count = len(pairs) if closures is None else closures
    return _measured(truth, _drawn(pairs, count, rng), noise, rng), truth


def _winding(n: int, around: int, radius: float) -> Array:
    """Return ``n`` poses on a spiral from pole to pole, in the frame of the first.

    At time k the colatitude is π (k + ½)/n and the longitude 2π k/around; x is ahead.
    """
    time = np.arange(n)
    down, east = np.pi * (time + 0.5) / n, 2.0 * np.pi * time / around
    sine, cosine = np.sin(down), np.cos(down)
    out = np.stack([sine * np.cos(east), sine * np.sin(east), cosine], axis=1)
    south = np.stack([cosine * np.cos(east), cosine * np.sin(east), -sine], axis=1)
    along = np.stack([-np.sin(east), np.cos(east), np.zeros(n)], axis=1)
    ahead = south / n + (2.0 / around) * sine[:, None] * along
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    rotation = np.stack([ahead, np.cross(out, ahead), out], axis=2)
    poses = se3.from_parts(rotation, radius * out)
    return se3.between(poses[0], poses)


def _walk(n: int, side: int, turn: float, rng: np.random.Generator) -> tuple[Indices, Indices]:
    """Return the crossings ``(n, 2)`` of a walk and the headings there in quarter turns ``(n,)``.

    The heading is that of the next step.
    """
    ahead = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    crossing, facing = np.zeros((n, 2), dtype=np.intp), np.zeros(n, dtype=np.intp)
    for k in range(1, n):
        crossing[k] = crossing[k - 1] + ahead[facing[k - 1]]
        sides = rng.permutation([1, -1])
        preferred = [*sides, 0] if rng.random() < turn else [0, *sides]
        choices = (facing[k - 1] + np.array(preferred)) % 4
        inside = [np.all((at >= 0) & (at <= side)) for at in crossing[k] + ahead[choices]]
        facing[k] = choices[int(np.argmax(inside))]
    return crossing, facing


def _measured(
    truth: Array, closures: Indices, noise: Noise | None, rng: np.random.Generator
) -> PoseGraph:
    """Measure each step of the path and the pairs ``closures``."""
    noise, group = Noise() if noise is None else noise, group_of(truth)
    steps = np.arange(len(truth) - 1)
    edges = np.concatenate([np.stack([steps, steps + 1], axis=1), closures])
    is_odometry = np.arange(len(edges)) < len(steps)
    named = (("noise.odometry", noise.odometry), ("noise.closure", noise.closure))
    sigma = np.where(is_odometry[:, None], *(_deviations(*each, group) for each in named))
    drawn = noise.scale * sigma * rng.normal(size=sigma.shape)
    true = group.between(truth[edges[:, 0]], truth[edges[:, 1]])
    information = np.eye(group.DOF) / sigma[:, :, None] ** 2
    measurement = group.compose(true, group.exp(drawn))
    return PoseGraph(len(truth), edges, measurement, information, is_odometry)


def _deviations(name: str, sigma: tuple[float, float], group: Group) -> Array:
    """Return one number for each coordinate of the tangent, ``(D,)``."""
    checked = finite(name, sigma, (2,))
    if np.any(checked <= 0.0):
        raise ValueError(f"{name} is {sigma}; give numbers above 0 (scale=0 switches noise off)")
    return np.repeat(checked, [group.DIMENSION, group.DOF - group.DIMENSION])


def near_pairs(positions: Array, reach: float) -> Indices:
    """Return all pairs ``(k, 2)``, i + 1 < j, of ``positions`` ``(n, d)`` within ``reach`` m."""
    pairs = KDTree(positions).query_pairs(reach, output_type="ndarray")
    pairs = pairs[pairs[:, 1] > pairs[:, 0] + 1]
    return np.asarray(pairs[np.lexsort(pairs.T[::-1])], dtype=np.intp)


def _drawn(pairs: Indices, count: int, rng: np.random.Generator) -> Indices:
    """Draw ``count`` of the pairs and keep their order."""
    if not 0 <= count <= len(pairs):
        remedy = "ask for 0 up to that many or make the way longer"
        found = f"{len(pairs)} pairs come near enough to be closed"
        raise ValueError(f"closures is {count}, and {found}; {remedy}")
    chosen = rng.choice(len(pairs), size=count, replace=False, shuffle=False)
    return np.asarray(pairs[np.sort(chosen)], dtype=np.intp)
