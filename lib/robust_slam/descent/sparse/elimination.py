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

_FRONT, _MULTIPLICATION, _UPDATE, _STORED = 16e-6, 1e-10, 4e-9, 2e-9
"""Seconds that a front takes, each of its multiplications, each entry that it hands on, and
each that it keeps. What counts are their ratios, which are much the same everywhere."""


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
    row = np.concatenate([np.minimum(*edges.T), each])
    column = np.concatenate([np.maximum(*edges.T), each])
    # The diagonal outweighs its row, so no entry of the factor cancels.
    numbers = np.concatenate([np.full(len(edges), -1.0), np.full(n, 2.0 * len(edges) + 1.0)])
    joined = csc_array((numbers, (row, column)), shape=(n, n))
    factor, _, order = qdldl.Solver(joined, upper=True).factors()
    return Elimination(np.asarray(order, dtype=np.intp), csc_array(factor))


def find_fronts(elimination: Elimination, block: int) -> Fronts:
    """Return the fronts of an elimination, its order changed so that each is in one piece.

    The new order makes the same fill-in. A vertex stands for ``block`` unknowns.
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
    first = _first_columns(parent.tolist(), height[leading], block)
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


def _first_columns(parent: list[int], below: Indices, block: int) -> Indices:
    """Return the first column of each front.

    Every column is joined with the fronts right before it that lead to it, as long as the
    joint front takes less time than both. Its columns are all as long as the longest, so
    it holds some zeros.
    """
    firsts: list[int] = []
    seconds: list[float] = []
    rows = (block * below).tolist()
    for column, height in enumerate(rows):
        first, own = column, _seconds(block, height)
        while firsts and first <= parent[first - 1] <= column:
            joint = _seconds(block * (column - firsts[-1] + 1), height)
            if joint > own + seconds[-1]:
                break
            first, own = firsts.pop(), joint
            seconds.pop()
        firsts.append(first)
        seconds.append(own)
    return np.array(firsts, dtype=np.intp)


def _seconds(k: int, r: int) -> float:
    """Return what a front of k columns with r rows below takes, in seconds."""
    multiplications = k * (k * k / 3 + r * (k + r))
    return _FRONT + _MULTIPLICATION * multiplications + _UPDATE * r * r + _STORED * k * (k + r)
