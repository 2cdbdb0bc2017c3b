"""Pose graphs whose truth is known: a circle, a walk through a town of square blocks.

Measurements are z = x_i⁻¹ ∘ x_j ∘ Exp(η) with Gaussian η, so that at the truth the
whitened residuals are exactly standard normal. The truth starts at [0, 0, 0].

Source: derived here, where no other is named.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from robust_slam import se2
from robust_slam._arrays import Array, Indices, finite, positive
from robust_slam.pose_graph import PoseGraph


@dataclass(frozen=True)
class Noise:
    """Standard deviations of the measurements: (forward, sideways, turn) in m, m, rad.

    ``scale`` multiplies the noise that is drawn but not the information that is claimed;
    0 gives exact measurements.
    """

    odometry: tuple[float, float, float] = (0.05, 0.05, 0.02)
    closure: tuple[float, float, float] = (0.05, 0.05, 0.02)
    scale: float = 1.0


def circle(
    n: int,
    rng: np.random.Generator,
    *,
    radius: float = 5.0,
    laps: int = 1,
    closures: int = 1,
    noise: Noise | None = None,
) -> tuple[PoseGraph, Array]:
    """Return a drive of ``laps`` anticlockwise rounds by ``n`` poses, and the truth ``(n, 3)``.

    ``radius`` is in m. The ``closures`` are drawn from all pairs that stand no further
    apart than neighbours on the way do; in one round only the last pose and pose 0 do.

    Raises:
        ValueError: an argument is out of range, or there are fewer such pairs.
    """
    if n < 3 or laps < 1:
        raise ValueError(f"n is {n} and laps {laps}; give at least 3 poses and 1 lap")
    turn = 2.0 * np.pi * laps * np.arange(n) / n
    radius = positive("radius", radius)
    truth = np.stack(
        [radius * np.sin(turn), radius * (1.0 - np.cos(turn)), se2.wrap(turn)], axis=1
    )
    reach = 2.0 * radius * np.sin(np.pi * laps / n)
    return _measured(truth, reach, closures, noise, rng), truth


def manhattan(
    n: int,
    rng: np.random.Generator,
    *,
    block: float = 1.0,
    side: int | None = None,
    turn: float = 0.3,
    closures: int | None = None,
    noise: Noise | None = None,
) -> tuple[PoseGraph, Array]:
    """Return a walk of ``n`` poses through a town of square blocks, and the truth ``(n, 3)``.

    The town has ``side`` by ``side`` blocks of ``block`` m, by default about √n/2 a side;
    the walk starts at a corner. Each step leads one block ahead, and at each crossing the
    robot turns left or right with probability ``turn``, or where the street ends. The
    ``closures``, by default n/5, are drawn from all pairs no further apart than one block
    that are not neighbours on the way.

    Raises:
        ValueError: an argument is out of range, or there are fewer such pairs.

    Source: the setting of Olson, Leonard and Teller 2006.
    """
    if n < 3:
        raise ValueError(f"n is {n}; give at least 3 poses")
    if not 0.0 <= turn <= 1.0:
        raise ValueError(f"turn is {turn}; give a probability from 0 to 1")
    side = max(1, round(np.sqrt(n) / 2.0)) if side is None else side
    if side < 1:
        raise ValueError(f"side is {side}; give at least 1 block")
    block = positive("block", block)
    crossing, facing = _walk(n, side, turn, rng)
    truth = np.concatenate([block * crossing, se2.wrap(facing * np.pi / 2)[:, None]], axis=1)
    wanted = n // 5 if closures is None else closures
    return _measured(truth, block, wanted, noise, rng), truth


def _walk(n: int, side: int, turn: float, rng: np.random.Generator) -> tuple[Indices, Indices]:
    """Return the crossings ``(n, 2)`` of a walk and the quarter turns faced at each, ``(n,)``.

    The robot already faces where its next step leads.
    """
    ahead = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    crossing, facing = np.zeros((n, 2), dtype=np.intp), np.zeros(n, dtype=np.intp)
    for k in range(1, n):
        crossing[k] = crossing[k - 1] + ahead[facing[k - 1]]
        sides = rng.permutation([1, -1])
        wishes = [*sides, 0] if rng.random() < turn else [0, *sides]
        choices = (facing[k - 1] + np.array(wishes)) % 4
        inside = [np.all((at >= 0) & (at <= side)) for at in crossing[k] + ahead[choices]]
        facing[k] = choices[int(np.argmax(inside))]
    return crossing, facing


def dead_reckoning(graph: PoseGraph) -> Array:
    """Return the poses that follow from the odometry alone, pose 0 the identity.

    They are ``(n, 3)`` in SE(2) and ``(n, 3, 4)`` in SE(3).

    Raises:
        ValueError: no odometry edge (k, k + 1) leads to some pose k + 1.

    Source: Hillis and Steele 1986, sums of a chain in log n rounds.
    """
    i, j = graph.edges.T
    steps = np.flatnonzero(graph.is_odometry & (j == i + 1))
    edge = np.full(graph.n, -1, dtype=np.intp)
    edge[j[steps[::-1]]] = steps[::-1]
    if np.any(edge[1:] < 0):
        missing = 1 + int(np.argmax(edge[1:] < 0))
        raise ValueError(
            f"graph: no odometry edge leads from pose {missing - 1} to pose {missing}; "
            "mark it in is_odometry or give first poses"
        )
    group = graph.group
    poses = np.concatenate([group.identity()[None], graph.measurement[edge[1:]]])
    # Chains of 1, 2, 4, … steps: each round composes every chain with the one before it.
    reach = 1
    while reach < graph.n:
        poses[reach:] = group.compose(poses[:-reach], poses[reach:])
        reach *= 2
    return poses


def _measured(
    truth: Array, reach: float, closures: int, noise: Noise | None, rng: np.random.Generator
) -> PoseGraph:
    """Measure each step of the way and ``closures`` pairs within ``reach``."""
    noise = Noise() if noise is None else noise
    steps = np.arange(len(truth) - 1)
    odometry = np.stack([steps, steps + 1], axis=1)
    edges = np.concatenate([odometry, _revisits(truth, reach, closures, rng)])
    is_odometry = np.arange(len(edges)) < len(odometry)
    sigma = np.where(
        is_odometry[:, None],
        _deviations("noise.odometry", noise.odometry),
        _deviations("noise.closure", noise.closure),
    )
    drawn = noise.scale * sigma * rng.normal(size=sigma.shape)
    true = se2.between(truth[edges[:, 0]], truth[edges[:, 1]])
    return PoseGraph(
        n=len(truth),
        edges=edges,
        measurement=se2.compose(true, se2.exp(drawn)),
        information=np.eye(3) / sigma[:, :, None] ** 2,
        is_odometry=is_odometry,
    )


def _deviations(name: str, sigma: tuple[float, float, float]) -> Array:
    checked = finite(name, sigma, (3,))
    if np.any(checked <= 0.0):
        raise ValueError(f"{name} is {sigma}; give numbers above 0 (scale=0 switches noise off)")
    return checked


def _revisits(truth: Array, reach: float, count: int, rng: np.random.Generator) -> Indices:
    """Draw ``count`` pairs (i, j), i + 1 < j, that stand within ``reach`` of each other."""
    pairs = KDTree(truth[:, :2]).query_pairs(reach * (1.0 + 1e-9), output_type="ndarray")
    pairs = pairs[pairs[:, 1] > pairs[:, 0] + 1]
    if not 0 <= count <= len(pairs):
        raise ValueError(
            f"closures is {count}, and {len(pairs)} pairs come near enough to be closed; "
            "ask for 0 up to that many or make the way longer"
        )
    pairs = pairs[np.lexsort(pairs.T[::-1])]
    chosen = rng.choice(len(pairs), size=count, replace=False, shuffle=False)
    return np.asarray(pairs[np.sort(chosen)], dtype=np.intp)
