"""The closures that join sessions: one for each pair of sessions along a tree.

Where the odometry has gaps, closures alone join its parts. A tree over the sessions takes
those pairs on which most closures agree, and of each pair the closure that agrees best with
the others.

Source: Mangelson et al. 2018 for the sets of consistent closures between two robots; the
choice of a tree is derived here.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import minimum_spanning_tree

from robust_slam._arrays import Indices, Mask
from robust_slam.consistency.pairwise import total_distances
from robust_slam.graphs.odometry import sessions
from robust_slam.graphs.pose_graph import PoseGraph

_COMPARED = 100
"""So many closures of a pair are enough to find one in their middle."""


@dataclass(frozen=True, eq=False, repr=False)
class Bridges:
    """The closures that join sessions.

    ``edges`` ``(s − 1,)`` are edges of the graph for its s sessions, and ``support``
    ``(s − 1,)`` the number of kept closures that join the same two sessions.
    """

    edges: Indices
    support: Indices

    def __repr__(self) -> str:
        return f"<Bridges: {self.edges.size:,} closures>"


def find_bridges(graph: PoseGraph, kept: Mask) -> Bridges:
    """Return the bridges between the sessions of ``graph``, from the ``kept`` edges ``(m,)``."""
    session = sessions(graph)
    closures = np.flatnonzero(kept & ~graph.is_odometry)
    joined = np.sort(session[graph.edges[closures]], axis=1)
    between = joined[:, 0] != joined[:, 1]
    closures, joined = closures[between], joined[between]
    if not closures.size:
        return Bridges(closures, closures)
    pairs, label, count = np.unique(joined, axis=0, return_inverse=True, return_counts=True)
    chosen = _tree(pairs, count)
    samples = []
    for own in (closures[label == number] for number in chosen):
        spread = np.unique(np.linspace(0, own.size - 1, _COMPARED).astype(np.intp))
        samples.append(own[spread])
    sampled = np.isin(np.arange(len(graph.edges)), np.concatenate(samples))
    totals = total_distances(graph, sampled)
    edges = [sample[np.argmin(totals[sample])] for sample in samples]
    return Bridges(np.array(edges, dtype=np.intp), count[chosen])


def _tree(pairs: Indices, count: Indices) -> Indices:
    """Return the numbers of the ``pairs`` ``(k, 2)`` of sessions that form the tree."""
    size = int(pairs.max()) + 1
    # Most closures first, ties by the order of the pairs; entries of 0 would count as absent.
    rank = np.empty(count.size)
    rank[np.lexsort((np.arange(count.size), -count))] = np.arange(1, count.size + 1)
    tree = minimum_spanning_tree(coo_array((rank, pairs.T), shape=(size, size)).tocsr())
    return np.flatnonzero(np.isin(rank, tree.data))
