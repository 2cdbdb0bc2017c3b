"""In which order the poses of a graph are eliminated, and which dense work that makes.

To eliminate a pose joins all its neighbours that are still there. A good order makes few
such joins, the *fill-in*. Poses that are eliminated one after the other and leave nearly
the same neighbours behind form a *front*: one small dense matrix in place of many sparse
columns.

Source: Davis 2006, "Direct Methods for Sparse Linear Systems", chapters 4 and 7, for the
elimination tree and minimum degree; Ashcraft and Grimes 1989 for fronts with a few zeros.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import qdldl
from scipy.sparse import csc_array

from robust_slam._arrays import Indices

_ZEROS = ((4, 1.0), (16, 0.8), (48, 0.1))
"""Up to this many poses wide, a front may hold this share of zeros; wider ones hold less."""
_ZEROS_BEYOND = 0.05


@dataclass(frozen=True, eq=False)
class Elimination:
    """An order of n vertices, ``order`` ``(n,)``, and the fill-in that it makes.

    ``factor`` ``(n, n)`` has an entry wherever a vertex, by its place in the order, is
    joined to a later one when it goes; the numbers in it mean nothing.
    """

    order: Indices
    factor: csc_array

    @property
    def filled(self) -> Indices:
        """How many later vertices each one is joined to when it goes, ``(n,)``."""
        return np.diff(self.factor.indptr)

    @property
    def multiplications(self) -> float:
        """How many multiplications of blocks a Cholesky factorisation takes."""
        return float(np.sum((self.filled + 1.0) ** 2)) / 2.0


@dataclass(frozen=True, eq=False)
class Fronts:
    """Fronts, one after the other, over vertices called by their place in ``order`` ``(n,)``.

    Front f holds the columns ``first[f]`` to ``first[f + 1]`` − 1 and leaves the vertices
    ``rows[f]``, ascending, behind. ``first`` ends with n. A front stands behind all that
    lead to it.
    """

    order: Indices
    first: Indices
    rows: tuple[Indices, ...]


def find_elimination(n: int, edges: Indices) -> Elimination:
    """Return an order of little fill-in for ``n`` ≥ 1 vertices joined by ``edges`` ``(m, 2)``.

    Source: the approximate minimum degree of Amestoy, Davis and Duff 1996, by QDLDL.
    """
    each = np.arange(n)
    row = np.concatenate([edges.min(axis=1), each])
    column = np.concatenate([edges.max(axis=1), each])
    # The diagonal outweighs its row, so no entry of the factor cancels.
    numbers = np.concatenate([np.full(len(edges), -1.0), np.full(n, 2.0 * len(edges) + 1.0)])
    joined = csc_array((numbers, (row, column)), shape=(n, n))
    factor, _, order = qdldl.Solver(joined, upper=True).factors()
    return Elimination(np.asarray(order, dtype=np.intp), csc_array(factor))


def find_fronts(elimination: Elimination) -> Fronts:
    """Return the fronts of an elimination, its order changed so that each is in one piece.

    The new order makes the same fill-in.
    """
    factor, height = elimination.factor, elimination.filled
    parent = np.full(height.size, -1, dtype=np.intp)
    # A vertex leads to the first of those that it leaves behind.
    starts = factor.indptr[:-1][height > 0]
    if starts.size:
        parent[height > 0] = np.minimum.reduceat(factor.indices, starts)
    leading = _leading_first(parent)
    place = np.argsort(leading)
    parent = np.where(parent >= 0, place[parent], -1)[leading]
    first = _first_columns(parent.tolist(), height[leading].tolist())
    last = leading[np.append(first[1:], height.size) - 1]
    rows = (factor.indices[factor.indptr[v] : factor.indptr[v + 1]] for v in last.tolist())
    return Fronts(
        elimination.order[leading],
        np.append(first, height.size),
        tuple(np.sort(place[below]) for below in rows),
    )


def _leading_first(parent: Indices) -> Indices:
    """Return the vertices of a forest so that all that lead to a vertex stand before it."""
    leading: list[list[int]] = [[] for _ in range(parent.size)]
    roots: list[int] = []
    for vertex, above in enumerate(parent.tolist()):
        (leading[above] if above >= 0 else roots).append(vertex)
    backwards, waiting = [], roots
    while waiting:
        vertex = waiting.pop()
        backwards.append(vertex)
        waiting.extend(leading[vertex])
    return np.array(backwards[::-1], dtype=np.intp)


def _first_columns(parent: list[int], below: list[int]) -> Indices:
    """Return the first column of each front.

    Every column is joined with the fronts right before it that lead to it, where that
    pays. Their rows are then as long as its own, and some entries are zeros.
    """
    firsts: list[int] = []
    zeros: list[int] = []
    for column, height in enumerate(below):
        first, empty = column, 0
        while firsts and first <= parent[first - 1] <= column:
            width = column - firsts[-1] + 1
            longer = column - first + 1 + height - below[first - 1]
            joint = empty + zeros[-1] + (first - firsts[-1]) * longer
            if joint and not _pays(joint, width, height):
                break
            first, empty = firsts.pop(), joint
            zeros.pop()
        firsts.append(first)
        zeros.append(empty)
    return np.array(firsts, dtype=np.intp)


def _pays(zeros: int, width: int, below: int) -> bool:
    """Tell whether so many zeros cost less than one more front."""
    allowed = next((share for most, share in _ZEROS if width <= most), _ZEROS_BEYOND)
    return zeros <= allowed * width * ((width + 1) / 2 + below)
