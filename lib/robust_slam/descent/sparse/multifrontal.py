"""Multifrontal Cholesky factorisation, in numpy and BLAS.

A front holds the columns of a few poses with nearly the same remaining neighbours. It is
factorised as a dense matrix. Its Schur complement on the neighbours, the *update matrix*,
is added to the parent front by *extend-add*. It is the faster method where fronts are large:
on graphs in space.

Source: Duff and Reid 1983, "The multifrontal solution of indefinite sparse symmetric
linear equations"; Liu 1992, "The multifrontal method for sparse matrix solution: theory
and practice", for update matrices and extend-add.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from robust_slam._arrays import Array, Indices
from robust_slam.descent.sparse.elimination import Fronts

_RUNS = 24
"""An update with at most this many runs of consecutive rows is added run by run."""

Region = tuple[slice, slice] | tuple[NDArray[np.intp], ...]
"""A part of a matrix, by slices or by ``np.ix_``."""
Pieces = list[tuple[Region, Region]]
"""Pairs (target, source): the part ``source`` of an update is added to ``target``."""


@dataclass(frozen=True, eq=False)
class _ExtendAdd:
    """How the update of the front ``child`` is added to the three parts of its parent."""

    child: int
    top: Pieces
    side: Pieces
    update: Pieces


@dataclass(frozen=True, eq=False)
class _Plan:
    """The assembly of a front of k scalar columns, ``own``, and r scalar ``rows`` below.

    The front is the triangle of its own columns, the *top* ``(k, k)``, and the *side*
    ``(r, k)``. ``blocks`` are the blocks of the matrix that belong to it, and ``target``
    the positions of their entries, the top first, column after column.
    """

    own: slice
    rows: Indices
    blocks: slice
    target: Indices
    children: list[_ExtendAdd]

    def parts(self, blocks: Array) -> tuple[Array, Array]:
        """Return top and side with the entries of the matrix, stored by columns for BLAS."""
        k, r = self.own.stop - self.own.start, self.rows.size
        front = np.zeros(k * (k + r))
        front[self.target] = blocks[self.blocks]
        top, side = front[: k * k], front[k * k :]
        return top.reshape((k, k), order="F"), side.reshape((r, k), order="F")


class Multifrontal:
    """Factorises matrices over ``fronts``, ``row`` and ``column`` as in the pattern."""

    def __init__(self, block: int, fronts: Fronts, row: Indices, column: Indices) -> None:
        self.shape = (fronts.order.size, block)
        self.plans = _plans(block, fronts, row, column)

    def solve(self, blocks: Array, right: Array) -> Array | None:
        """Return the solutions ``(n − 1, b, c)``, or None if not positive definite."""
        x = right.reshape(-1, right.shape[-1]).copy()
        factors = self.factorise(blocks, forward=x)
        return None if factors is None else factors.back_substitute(x).reshape(right.shape)

    # The upper triangle of an update is never set; it is added up, but not used.
    @np.errstate(over="ignore", invalid="ignore")
    def factorise(self, blocks: Array, forward: Array | None = None) -> MultifrontalFactors | None:
        """Return the factors L of ``blocks`` ``(k, b, b)``, or None if not positive definite.

        Right-hand sides ``forward`` ``(unknowns, c)`` are replaced by the y of L y =
        ``forward`` on the way, while each front is still in the processor's cache.
        """
        factors: list[tuple[Array, Array]] = []
        updates: dict[int, Array] = {}
        for number, plan in enumerate(self.plans):
            top, side = plan.parts(blocks)
            received = [(extend, updates.pop(extend.child)) for extend in plan.children]
            for extend, update in received:
                _add(top, extend.top, update)
                _add(side, extend.side, update)
            _, failed = dpotrf(top, lower=1, overwrite_a=1, clean=0)
            if failed:
                return None
            r = plan.rows.size
            if r:
                dtrsm(1.0, top, side, side=1, lower=1, trans_a=1, overwrite_b=1)
                own = np.empty((r, r), order="F")
                updates[number] = dsyrk(-1.0, side, beta=0.0, c=own, lower=1, overwrite_c=1)
                for extend, update in received:
                    _add(updates[number], extend.update, update)
            if forward is not None:
                _forward_substitute(plan, top, side, forward)
            factors.append((top, side))
        return MultifrontalFactors(self, factors)


def _add(whole: Array, pieces: Pieces, update: Array) -> None:
    for target, source in pieces:
        whole[target] += update[source]


@dataclass(frozen=True, eq=False)
class MultifrontalFactors:
    """Top and side of the factor L, front by front, as ``pattern.Factors``."""

    owner: Multifrontal
    fronts: list[tuple[Array, Array]]

    @property
    def pivots(self) -> Array:
        """The squared diagonal of L, ``(n − 1, b)``."""
        diagonal = np.concatenate([np.diagonal(top) for top, _ in self.fronts])
        return (diagonal**2).reshape(self.owner.shape)

    def solve(self, right: Array) -> Array:
        """Return the solutions ``(n − 1, b, c)`` of L y = ``right`` and then Lᵀ x = y."""
        x = right.reshape(-1, right.shape[-1]).copy()
        for plan, (top, side) in zip(self.owner.plans, self.fronts, strict=True):
            _forward_substitute(plan, top, side, x)
        return self.back_substitute(x).reshape(right.shape)

    def back_substitute(self, x: Array) -> Array:
        """Return the solution of Lᵀ x = y; y ``(unknowns, c)`` is passed as ``x`` and replaced."""
        for plan, (top, side) in zip(
            reversed(self.owner.plans), reversed(self.fronts), strict=True
        ):
            y = x[plan.own] - side.T @ x[plan.rows]
            x[plan.own] = dtrsm(1.0, top, y, lower=1, trans_a=1)
        return x


def _forward_substitute(plan: _Plan, top: Array, side: Array, x: Array) -> None:
    x[plan.own] = y = dtrsm(1.0, top, x[plan.own], lower=1)
    x[plan.rows] -= side @ y


def _plans(block: int, fronts: Fronts, row: Indices, column: Indices) -> list[_Plan]:
    bounds = column.searchsorted(fronts.first).tolist()
    firsts = fronts.first.tolist()
    targets = _targets(block, fronts, row, column)
    plans = []
    for number, rows in enumerate(fronts.rows):
        own = slice(block * firsts[number], block * firsts[number + 1])
        mine = slice(bounds[number], bounds[number + 1])
        plans.append(_Plan(own, _scalars(rows, block), mine, targets[mine], []))
    front_of = np.repeat(np.arange(len(plans)), np.diff(fronts.first))
    for number, rows in enumerate(fronts.rows):
        if rows.size:
            parent = int(front_of[rows[0]])
            columns = slice(firsts[parent], firsts[parent + 1])
            extend = _extend_add(number, rows, columns, fronts.rows[parent], block)
            plans[parent].children.append(extend)
    return plans


def _targets(block: int, fronts: Fronts, row: Indices, column: Indices) -> Indices:
    """Return the position in its front of each block entry, ``(count, block, block)``."""
    n, count = fronts.order.size, len(fronts.rows)
    front_of = np.repeat(np.arange(count), np.diff(fronts.first))[column]
    first, after = fronts.first[front_of], fronts.first[front_of + 1]
    own, width = row < after, after - first
    # Rows below a front are found by one search in the concatenated rows of all fronts.
    sizes = np.array([rows.size for rows in fronts.rows])
    names = np.concatenate(fronts.rows) + n * np.repeat(np.arange(count), sizes)
    before = np.concatenate([[0], np.cumsum(sizes)])[front_of]
    below = names.searchsorted(n * front_of + row) - before
    start = block * np.where(own, row - first, block * width**2 + below)
    height = block * np.where(own, width, sizes[front_of])
    inside = np.arange(block)
    across = block * (column - first)[:, None] + inside
    rows = (start[:, None] + inside)[:, :, None]
    target: Indices = rows + (height[:, None] * across)[:, None]
    return target


def _extend_add(child: int, rows: Indices, own: slice, below: Indices, block: int) -> _ExtendAdd:
    """Return how an update over ``rows`` is added to a front ``own`` with rows ``below``.

    All three are in poses, not in scalars.
    """
    split = int(rows.searchsorted(own.stop))
    inside, beyond = rows[:split] - own.start, below.searchsorted(rows[split:])
    tops, sides = _runs(inside, 0, block), _runs(beyond, split, block)
    if len(tops) + len(sides) <= _RUNS:
        square: Pieces = [((t, t2), (h, h2)) for t, h in sides for t2, h2 in tops]
        return _ExtendAdd(child, _lower(tops), square, _lower(sides))
    into, down = _scalars(inside, block), _scalars(beyond, block)
    first, last = slice(0, split * block), slice(split * block, None)
    return _ExtendAdd(
        child,
        [(np.ix_(into, into), (first, first))],
        [(np.ix_(down, into), (last, first))],
        [(np.ix_(down, down), (last, last))],
    )


def _scalars(positions: Indices, block: int) -> Indices:
    return (positions[:, None] * block + np.arange(block)).ravel()


def _lower(runs: list[tuple[slice, slice]]) -> Pieces:
    """Return the pieces on and below the diagonal: each run with itself and earlier runs."""
    return [
        ((target, target2), (source, source2))
        for k, (target, source) in enumerate(runs)
        for target2, source2 in runs[: k + 1]
    ]


def _runs(positions: Indices, offset: int, block: int) -> list[tuple[slice, slice]]:
    """Return the runs of consecutive ``positions`` as pairs (target, source) of slices.

    The source slices begin at ``offset``. Positions and offset are in poses, slices in
    scalars.
    """
    if not positions.size:
        return []
    cuts = (positions[1:] - positions[:-1] != 1).nonzero()[0] + 1
    starts = [0, *cuts.tolist()]
    ends = [*starts[1:], positions.size]
    targets = positions[starts].tolist()
    return [
        (
            slice(block * t, block * (t + b - a)),
            slice(block * (offset + a), block * (offset + b)),
        )
        for t, a, b in zip(targets, starts, ends, strict=True)
    ]
