"""A drive through a park with trees and GPS, some of whose measurements are wrong.

It is modelled on the data set Victoria Park: a car with odometry sees the trunks of trees, and
takes one for another now and then. Here it has GPS too, and buildings reflect some of its signals.

Source: derived here; Guivant and Nebot 2001 for the drive in Victoria Park, Sydney.
"""

import numpy as np

from robust_slam._arrays import Array, Indices, Mask, times
from robust_slam.factors.factor_graph import FactorGraph, Factors
from robust_slam.graphs.generate import Noise, manhattan
from robust_slam.groups import se2

_BLOCK, _REACH = 10.0, 12.0
_ODOMETRY = Noise(odometry=(0.1, 0.01))
_TREE, _FIX = 0.2, 1.0
_ALIKE = 3
"""A tree is taken for one of so many that are nearest to it."""
_REFLECTED = (10.0, 40.0)
"""A reflected signal is off by a distance between these (m)."""
_FRAME = np.array([100.0, 50.0, 0.7])
"""The first pose in the frame of the GPS, which is not that of the car."""


def park(
    n: int,
    rng: int | np.random.Generator,
    *,
    trees: int = 40,
    every: int = 5,
    wrong_trees: float = 0.1,
    wrong_fixes: float = 0.2,
) -> tuple[FactorGraph, Array, Mask]:
    """Return a drive of ``n`` poses among trees, its true map, and which factors are wrong.

    The map is ``(n + l, 3)`` for the l of all ``trees`` that are seen, the mask ``(m,)``. The car
    drives 10 m a pose along the paths of ``manhattan``, and sees each tree within 12 m as a point,
    within 0.2 m an axis. The share ``wrong_trees`` of the sightings is attributed to another tree
    nearby. In ``every`` fifth pose, by default, it has a GPS fix within 1 m an axis, and the share
    ``wrong_fixes`` of them is off by 10 to 40 m.

    Raises:
        ValueError: there are fewer than 3 poses or 4 trees, ``every`` is below 1, a share is
            outside [0, 1], or no tree is seen.

    >>> graph, truth, is_wrong = park(100, 0)
    >>> graph, int(is_wrong.sum())
    (<FactorGraph: 100 poses in SE(2), 40 landmarks, 99 edges, 20 positions, 408 points>, 45)
    """
    rng = np.random.default_rng(rng)
    if trees <= _ALIKE or every < 1:
        raise ValueError(f"trees is {trees} and every {every}; give at least {_ALIKE + 1} and 1")
    if not (0.0 <= wrong_trees <= 1.0 and 0.0 <= wrong_fixes <= 1.0):
        raise ValueError("wrong_trees and wrong_fixes are shares; give numbers from 0 to 1")
    drive, way = manhattan(n, rng, block=_BLOCK, closures=0, noise=_ODOMETRY)
    low, high = way[:, :2].min(axis=0) - _REACH / 2, way[:, :2].max(axis=0) + _REACH / 2
    place = rng.uniform(low, high, (trees, 2))
    pose, tree, seen, wrong_tree = _sightings(way, place, wrong_trees, rng)
    known, landmark = np.unique(tree, return_inverse=True)
    truth = se2.compose(_FRAME, np.concatenate([way, np.pad(place[known], ((0, 0), (0, 1)))]))
    truth[n:, 2] = 0.0
    at = np.arange(0, n, every)
    fix = truth[at, :2] + _FIX * rng.normal(size=(at.size, 2))
    wrong_fix = rng.permutation(at.size) < round(wrong_fixes * at.size)
    angle, off = rng.uniform([0.0, _REFLECTED[0]], [2.0 * np.pi, _REFLECTED[1]], (at.size, 2)).T
    fix[wrong_fix] += (off * np.array([np.cos(angle), np.sin(angle)])).T[wrong_fix]
    graph = FactorGraph(
        relative=drive,
        landmarks=known.size,
        positions=Factors(at, fix, np.eye(2) / _FIX**2),
        points=Factors(np.stack([pose, n + landmark], axis=1), seen, np.eye(2) / _TREE**2),
    )
    right = np.zeros(len(drive.edges), dtype=np.bool_)
    return graph, truth, np.concatenate([right, wrong_fix, wrong_tree])


def _sightings(
    way: Array, place: Array, wrong: float, rng: np.random.Generator
) -> tuple[Indices, Indices, Array, Mask]:
    """Return pose, tree and measured point of each sighting, and which name a ``wrong`` tree."""
    apart = place - way[:, None, :2]
    pose, tree = np.nonzero(np.linalg.norm(apart, axis=2) < _REACH)
    if not pose.size:
        raise ValueError(f"trees: none of the {len(place)} is within {_REACH} m; plant more")
    turn = np.swapaxes(se2.rotation(way[pose]), 1, 2)
    seen = times(turn, apart[pose, tree])
    seen += _TREE * rng.normal(size=seen.shape)
    between = np.linalg.norm(place[:, None] - place, axis=2)
    nearest = np.argsort(between, axis=1)[:, 1 : _ALIKE + 1]
    is_wrong = rng.permutation(pose.size) < round(wrong * pose.size)
    other = nearest[tree, rng.integers(_ALIKE, size=pose.size)]
    return pose, np.where(is_wrong, other, tree), seen, is_wrong
