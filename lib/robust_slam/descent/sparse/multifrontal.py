"""A sparse Cholesky factorisation of dense fronts, in numpy and BLAS.

A front holds the columns of a few poses that leave nearly the same neighbours behind. It
is factorised as a dense matrix. What it takes from its neighbours, its *update*, is handed
to the front in which the first of them is eliminated. It is the quicker method where
fronts are large: on graphs in space.

Source: Duff and Reid 1983, "The multifrontal solution of indefinite sparse symmetric
linear equations"; Liu 1992 for updates.
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
"""An update of up to so many runs of neighbouring rows is added run by run."""

Place = tuple[slice, slice] | tuple[NDArray[np.intp], ...]
"""Where a piece of a matrix is, by slices or by ``np.ix_``."""
Pieces = list[tuple[Place, Place]]
"""Pairs (there, here): the piece ``here`` of an update is added ``there``."""


@dataclass(frozen=True, eq=False)
class _Gift:
    """How the update of the front ``child`` is added to the three parts of its parent."""

    child: int
    top: Pieces
    side: Pieces
    update: Pieces


@dataclass(frozen=True, eq=False)
class _Plan:
    """What to do with a front of k scalar columns, ``own``, and r scalar ``rows`` below.

    The front is the triangle of its own columns, the *top* ``(k, k)``, and the *side*
    ``(r, k)``. ``blocks`` are the blocks of the matrix that belong to it, and ``target``
    says where their entries go, the top first, column after column.
    """

    own: slice
    rows: Indices
    blocks: slice
    target: Indices
    gifts: list[_Gift]

    def parts(self, blocks: Array) -> tuple[Array, Array]:
        """Return top and side with the numbers of the matrix, by columns as BLAS wants them."""
        k, r = self.own.stop - self.own.start, self.rows.size
        room = np.zeros(k * (k + r))
        room[self.target] = blocks[self.blocks]
        return room[: k * k].reshape((k, k), order="F"), room[k * k :].reshape((r, k), order="F")


class Multifrontal:
    """Factorises matrices over ``fronts``, ``row`` and ``column`` as in the pattern."""

    def __init__(self, block: int, fronts: Fronts, row: Indices, column: Indices) -> None:
        self.shape = (fronts.order.size, block)
        self.plans = _plans(block, fronts, row, column)

    def solve(self, blocks: Array, right: Array) -> Array | None:
        """Return the solutions ``(n − 1, b, c)``, or None where there are no factors."""
        x = right.reshape(-1, right.shape[-1]).copy()
        factors = self.factorise(blocks, forwards=x)
        return None if factors is None else factors.backwards(x).reshape(right.shape)

    def factorise(
        self, blocks: Array, forwards: Array | None = None
    ) -> MultifrontalFactors | None:
        """Return the factors L, or None if the matrix is not positive definite.

        Right-hand sides ``forwards`` ``(unknowns, c)`` become the y of L y = ``forwards`` on
        the way, while each front is still in the processor's cache.
        """
        factors: list[tuple[Array, Array]] = []
        updates: dict[int, Array] = {}
        for number, plan in enumerate(self.plans):
            top, side = plan.parts(blocks)
            given = [(gift, updates.pop(gift.child)) for gift in plan.gifts]
            for gift, update in given:
                _add(top, gift.top, update)
                _add(side, gift.side, update)
            _, failed = dpotrf(top, lower=1, overwrite_a=1, clean=0)
            if failed:
                return None
            r = plan.rows.size
            if r:
                dtrsm(1.0, top, side, side=1, lower=1, trans_a=1, overwrite_b=1)
                own = np.empty((r, r), order="F")
                updates[number] = dsyrk(-1.0, side, beta=0.0, c=own, lower=1, overwrite_c=1)
                for gift, update in given:
                    _add(updates[number], gift.update, update)
            if forwards is not None:
                _forwards(plan, top, side, forwards)
            factors.append((top, side))
        return MultifrontalFactors(self, factors)


def _add(whole: Array, pieces: Pieces, update: Array) -> None:
    for there, here in pieces:
        whole[there] += update[here]


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
        """Return the solutions ``(n − 1, b, c)``: forwards L y = ``right``, back Lᵀ x = y."""
        x = right.reshape(-1, right.shape[-1]).copy()
        for plan, (top, side) in zip(self.owner.plans, self.fronts, strict=True):
            _forwards(plan, top, side, x)
        return self.backwards(x).reshape(right.shape)

    def backwards(self, x: Array) -> Array:
        """Return the x of Lᵀ x = y; y ``(unknowns, c)`` is given as ``x`` and replaced."""
        for plan, (top, side) in zip(
            reversed(self.owner.plans), reversed(self.fronts), strict=True
        ):
            y = x[plan.own] - side.T @ x[plan.rows]
            x[plan.own] = dtrsm(1.0, top, y, lower=1, trans_a=1)
        return x


def _forwards(plan: _Plan, top: Array, side: Array, x: Array) -> None:
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
            gift = _gift(number, rows, columns, fronts.rows[parent], block)
            plans[parent].gifts.append(gift)
    return plans


def _targets(block: int, fronts: Fronts, row: Indices, column: Indices) -> Indices:
    """Return where in its front each entry of the blocks goes, ``(count, block, block)``."""
    n, count = fronts.order.size, len(fronts.rows)
    front_of = np.repeat(np.arange(count), np.diff(fronts.first))[column]
    first, after = fronts.first[front_of], fronts.first[front_of + 1]
    own, width = row < after, after - first
    # Rows below a front are looked up in the rows of all fronts, one after the other.
    sizes = np.array([rows.size for rows in fronts.rows])
    names = np.concatenate(fronts.rows) + n * np.repeat(np.arange(count), sizes)
    before = np.concatenate([[0], np.cumsum(sizes)])[front_of]
    below = names.searchsorted(n * front_of + row) - before
    start = block * np.where(own, row - first, block * width**2 + below)
    height = block * np.where(own, width, sizes[front_of])
    inside = np.arange(block)
    across = block * (column - first)[:, None] + inside
    there: Indices = (start[:, None] + inside)[:, :, None] + (height[:, None] * across)[:, None]
    return there


def _gift(child: int, rows: Indices, own: slice, below: Indices, block: int) -> _Gift:
    """Return how an update over ``rows`` is added to a front ``own`` with rows ``below``.

    All are counted in poses.
    """
    split = int(rows.searchsorted(own.stop))
    inside, beyond = rows[:split] - own.start, below.searchsorted(rows[split:])
    tops, sides = _runs(inside, 0, block), _runs(beyond, split, block)
    if len(tops) + len(sides) <= _RUNS:
        square: Pieces = [((t, t2), (h, h2)) for t, h in sides for t2, h2 in tops]
        return _Gift(child, _lower(tops), square, _lower(sides))
    into, down = (
        (places[:, None] * block + np.arange(block)).ravel() for places in (inside, beyond)
    )
    here, after = slice(0, split * block), slice(split * block, None)
    return _Gift(
        child,
        [(np.ix_(into, into), (here, here))],
        [(np.ix_(down, into), (after, here))],
        [(np.ix_(down, down), (after, after))],
    )


def _scalars(places: Indices, block: int) -> Indices:
    return (places[:, None] * block + np.arange(block)).ravel()


def _lower(runs: list[tuple[slice, slice]]) -> Pieces:
    """Return the pieces on and below the diagonal: a run meets itself and those before it."""
    return [
        ((there, there2), (here, here2))
        for k, (there, here) in enumerate(runs)
        for there2, here2 in runs[: k + 1]
    ]


def _runs(places: Indices, offset: int, block: int) -> list[tuple[slice, slice]]:
    """Return the slices that make up ``places``, and where they stand, from ``offset`` on.

    Places and offset are counted in poses, the slices in scalars.
    """
    if not places.size:
        return []
    cuts = (places[1:] - places[:-1] != 1).nonzero()[0] + 1
    starts = [0, *cuts.tolist()]
    ends = [*starts[1:], places.size]
    there = places[starts].tolist()
    return [
        (
            slice(block * t, block * (t + b - a)),
            slice(block * (offset + a), block * (offset + b)),
        )
        for t, a, b in zip(there, starts, ends, strict=True)
    ]
