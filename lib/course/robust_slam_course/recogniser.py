"""A town whose closures come from descriptors: a place recogniser confuses look-alike corners.

The outliers are not drawn: they are what a bag of words takes for the same place. Each crossing
shows words of a vocabulary; some crossings share the style of others, and so most of their
words. At each pose the robot sees a part of the words of its crossing, and takes the most similar
earlier view for the same place if it is similar enough. It then measures its pose beside the
corner that it takes for the one it sees, so matches of one pair of corners agree with each other.

Source: Cummins and Newman 2008 for places as words that are seen with some probability and for
perceptual aliasing; the town is derived here.
"""

from typing import NamedTuple

import numpy as np
from robust_slam._arrays import Array, Indices, Mask
from robust_slam.graphs import Noise, PoseGraph, manhattan
from robust_slam.graphs.pose_graph import select, with_closures
from robust_slam.groups import se2

VOCABULARY, SHOWN = 600, 30
"""Words in all, and of one crossing."""
STYLES, SHARED = 4, 0.85
"""Looks that several crossings have, and the share of their words that is the same."""
SEEN, STRAY = 0.75, 4
"""The share of a crossing's words that a view contains, and how many others."""
SIMILAR = 0.5
"""Two views match if their cosine is at least this."""
APART = 10
"""A view is compared with those at least so many steps earlier."""


class Recognised(NamedTuple):
    """A town whose closures a place recogniser chose.

    ``is_false`` ``(m,)`` masks its false matches, ``truth`` ``(n, 3)`` has the true poses, and
    ``scores`` ``(k,)`` the similarity of the two views of each closure, in the order of the graph.
    """

    graph: PoseGraph
    is_false: Mask
    truth: Array
    scores: Array


def recognised(
    poses: int, percent: int, noise: Noise, rng: int | np.random.Generator
) -> Recognised:
    """Return a town of so many ``poses``, of whose crossings ``percent`` look like others."""
    rng = np.random.default_rng(rng)
    drive, truth = manhattan(poses, rng, closures=0, noise=noise)
    drive = select(drive, drive.is_odometry)
    crossing = np.unique(truth[:, :2].round().astype(int), axis=0, return_inverse=True)[1].ravel()
    views = _views(crossing, percent, rng)
    pairs = _matched(views)
    relative = np.zeros((len(pairs), 3))
    relative[:, 2] = se2.wrap(truth[pairs[:, 1], 2] - truth[pairs[:, 0], 2])
    sigma = np.repeat(noise.closure, [2, 1])
    measurement = se2.compose(relative, se2.exp(sigma * rng.normal(size=relative.shape)))
    information = np.broadcast_to(np.diag(sigma**-2.0), (len(pairs), 3, 3))
    graph = with_closures(drive, pairs, measurement, information)
    is_false = crossing[pairs[:, 0]] != crossing[pairs[:, 1]]
    scores = np.einsum("ka,ka->k", *views[pairs.T])
    is_false = np.concatenate([np.zeros(len(drive.edges), dtype=bool), is_false])
    return Recognised(graph, is_false, truth, scores)


def _views(crossing: Indices, percent: int, rng: np.random.Generator) -> Array:
    """Return the words ``(n, VOCABULARY)`` of each view, as vectors of length 1."""
    count = int(crossing.max()) + 1
    words = np.stack([rng.choice(VOCABULARY, SHOWN, replace=False) for _ in range(count)])
    styles = np.stack([rng.choice(VOCABULARY, SHOWN, replace=False) for _ in range(STYLES)])
    alike = rng.choice(count, size=round(count * percent / 100), replace=False)
    same = round(SHARED * SHOWN)
    words[alike, :same] = styles[np.arange(alike.size) % STYLES, :same]
    views = np.zeros((crossing.size, VOCABULARY))
    for view, place in zip(views, crossing, strict=True):
        view[words[place][rng.random(SHOWN) < SEEN]] = 1.0
        view[rng.choice(VOCABULARY, STRAY, replace=False)] = 1.0
    return np.asarray(views / np.linalg.norm(views, axis=1, keepdims=True))


def _matched(views: Array) -> Indices:
    """Return the pairs ``(k, 2)`` of a view and the most similar one before it."""
    # Equal ones differ in their last digits, by machine; the earliest view is to be the best.
    similarity = np.tril(np.round(views @ views.T, 9), -APART)
    best = np.argmax(similarity, axis=1)
    found = np.flatnonzero(similarity[np.arange(len(views)), best] >= SIMILAR)
    return np.stack([best[found], found], axis=1)
