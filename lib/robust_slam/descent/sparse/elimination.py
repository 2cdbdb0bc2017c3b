"""The elimination order of the poses of a graph, and its fronts.

Eliminating a pose joins all its remaining neighbours. A good order causes few new joins,
called *fill-in*. Poses that follow one another in the elimination tree, with nearly the same
remaining neighbours, form a *front* (a relaxed supernode): one small dense matrix in place of
many sparse columns.

Source: Davis 2006, "Direct Methods for Sparse Linear Systems", chapters 4 and 7, for the
elimination tree and minimum degree; Ashcraft and Grimes 1989 for fronts with a few zeros.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_array

from robust_slam._arrays import Indices
from robust_slam.descent.sparse.ldl import Solver


class Costs(NamedTuple):
    """Seconds per front, per multiplication, per entry of its update and per stored entry.

    Only their ratios matter, and these are similar on all machines.
    """

    front: float
    multiplication: float
    update: float
    stored: float

    def seconds(self, k: int, r: int) -> float:
        """Return the time in s for a front of k columns with r rows below.

        Its triangle has k³/3 multiplications, which take three times as long as the others.
        """
        work = self.multiplication * (k * (k * k + r * (k + r)))
        return self.front + work + self.update * r * r + self.stored * k * (k + r)


COSTS = Costs(front=22e-6, multiplication=3.5e-11, update=2e-9, stored=3e-9)
"""Those of ``multifrontal``."""


@dataclass(frozen=True, eq=False)
class Elimination:
    """An order of n vertices, ``order`` ``(n,)``, and its fill-in.

    ``factor`` ``(n, n)`` has the pattern of the Cholesky factor, in the elimination order;
    its values have no meaning.
    """

    order: Indices
    factor: csc_array

    @property
    def filled(self) -> Indices:
        """The number of remaining neighbours of each vertex at its elimination, ``(n,)``."""
        return np.diff(self.factor.indptr)

    @property
    def multiplications(self) -> float:
        """The number of block multiplications of a Cholesky factorisation."""
        return float(np.sum((self.filled + 1.0) ** 2)) / 2.0


@dataclass(frozen=True, eq=False)
class Fronts:
    """Consecutive fronts over vertices, indexed by their position in ``order`` ``(n,)``.

    Front f holds the columns ``first[f]`` to ``first[f + 1]`` − 1, and ``rows[f]`` are the
    remaining neighbours, ascending. ``first`` ends with n. Children precede their parent.
    """

    order: Indices
    first: Indices
    rows: tuple[Indices, ...]


def find_elimination(n: int, edges: Indices) -> Elimination:
    """Return an order with little fill-in for ``n`` ≥ 1 vertices and ``edges`` ``(m, 2)``.

    Source: the approximate minimum degree ordering of Amestoy, Davis and Duff 1996, by QDLDL;
    without it minimum degree by SuperLU.
    """
    each = np.arange(n)
    row = np.concatenate([np.minimum(*edges.T), each])
    column = np.concatenate([np.maximum(*edges.T), each])
    # Of a Laplacian no entry of the factor cancels, and on a small diagonal none underflows, so
    # that SuperLU, which leaves zeros out, keeps all of them.
    degree = np.bincount(edges.ravel(), minlength=n)
    numbers = np.concatenate([np.full(len(edges), -1.0), degree + 1e-3])
    joined = csc_array((numbers, (row, column)), shape=(n, n))
    factor, _, order = Solver(joined, upper=True).factors()
    return Elimination(np.asarray(order, dtype=np.intp), csc_array(factor))


def find_fronts(elimination: Elimination, block: int) -> Fronts:
    """Return the fronts of an elimination, reordered so that each front is contiguous.

    The new order has the same fill-in. A vertex stands for ``block`` unknowns, and ``COSTS``
    tell which columns to join.

    Source: Ashcraft and Grimes 1989, relaxed supernodes.
    """
    factor, height = elimination.factor, elimination.filled
    parent = np.full(height.size, -1, dtype=np.intp)
    # The parent in the elimination tree is the first remaining neighbour.
    starts = factor.indptr[:-1][height > 0]
    if starts.size:
        parent[height > 0] = np.minimum.reduceat(factor.indices, starts)
    last = _last_columns(parent.tolist(), (block * height).tolist(), block)
    tops = np.unique(last)
    above = np.where(parent[tops] >= 0, tops.searchsorted(last[parent[tops]]), -1)
    order = _postorder(above)
    front, tops = np.argsort(order)[tops.searchsorted(last)], tops[order]
    sizes = height[tops]
    each = (factor.indices[factor.indptr[top] : factor.indptr[top + 1]] for top in tops.tolist())
    rows = np.concatenate(list(each), dtype=np.intp)
    columns = np.lexsort((_first_use(rows, sizes, last.size), front))
    below = np.split(np.argsort(columns)[rows], np.cumsum(sizes)[:-1])
    first = np.append(0, np.cumsum(np.bincount(front)))
    return Fronts(elimination.order[columns], first, tuple(map(np.sort, below)))


def _first_use(rows: Indices, sizes: Indices, n: int) -> Indices:
    """Return the number of the first front that has each of ``n`` columns as a row, ``(n,)``.

    Any order within a front has the same fill-in. In this one the rows of a front are
    consecutive in its parent, except for a few gaps.

    Source: after Jacquelin, Ng and Peyton 2018, "Fast and effective reordering of columns
    within supernodes using partition refinement", with one key in place of the refinement.
    """
    use = np.full(n, sizes.size)
    np.minimum.at(use, rows, np.repeat(np.arange(sizes.size), sizes))
    return use


def _postorder(parent: Indices) -> Indices:
    """Return the vertices of a forest, children before their parent, subtrees contiguous."""
    children: list[list[int]] = [[] for _ in range(parent.size)]
    roots: list[int] = []
    for vertex, above in enumerate(parent.tolist()):
        (children[above] if above >= 0 else roots).append(vertex)
    backwards, waiting = [], roots
    while waiting:
        vertex = waiting.pop()
        backwards.append(vertex)
        waiting.extend(children[vertex])
    return np.array(backwards[::-1], dtype=np.intp)


def _last_columns(parent: list[int], below: list[int], block: int) -> Indices:
    """Return the last column of the front of each column.

    Every column is merged with child fronts as long as the merged front takes less time than
    both. All its columns are as long as the last, which is the longest, so it stores some zeros.
    """
    children: list[list[int]] = [[] for _ in parent]
    sizes, seconds = [1] * len(parent), [0.0] * len(parent)
    last = list(range(len(parent)))
    for column, height in enumerate(below):
        own, kept, waiting = COSTS.seconds(block, height), [], children[column]
        while waiting:
            child = waiting.pop()
            joint = COSTS.seconds(block * (sizes[column] + sizes[child]), height)
            if joint > own + seconds[child]:
                kept.append(child)
                continue
            own, last[child] = joint, column
            sizes[column] += sizes[child]
            waiting.extend(children[child])
        seconds[column], children[column] = own, kept
        if parent[column] >= 0:
            children[parent[column]].append(column)
    for column in range(len(parent) - 1, -1, -1):
        last[column] = last[last[column]]
    return np.array(last)
