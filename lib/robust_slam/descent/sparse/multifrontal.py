"""Multifrontal Cholesky factorisation, in numpy and BLAS.

A front holds the columns of a few poses with nearly the same remaining neighbours. It is
factorised as a dense matrix. Its Schur complement on the neighbours, the *update matrix*,
is added to the parent front by *extend-add*. It is the faster method where fronts are large:
on graphs in space.

Source: Duff and Reid 1983, "The multifrontal solution of indefinite sparse symmetric
linear equations"; Liu 1992 for update matrices and extend-add.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from robust_slam._arrays import Array, Indices, Mask
from robust_slam.descent.sparse.elimination import Fronts

Region = tuple[slice, slice]
Runs = list[tuple[slice, slice]]
"""Pairs (target, source) of consecutive rows."""
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
    """Top and side of the factor L, front by front."""

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
    places = _Places(fronts)
    targets = _targets(block, places, row, column)
    scalars = (block * places.rows[:, None] + np.arange(block)).ravel()
    bounds = np.stack(
        [
            column.searchsorted(fronts.first),
            block * fronts.first,
            block * np.append(places.begin, places.rows.size),
        ]
    )
    mine, own, below = ([*map(slice, each, each[1:])] for each in bounds.tolist())
    plans = [
        _Plan(columns, scalars[rows], blocks, targets[blocks], [])
        for columns, rows, blocks in zip(own, below, mine, strict=True)
    ]
    for (child, parent), (tops, sides) in _runs(block, places).items():
        square = [((t, t2), (h, h2)) for t, h in sides for t2, h2 in tops]
        plans[parent].children.append(_ExtendAdd(child, _lower(tops), square, _lower(sides)))
    return plans


class _Places:
    """Where poses are in the fronts, by positions in the elimination order."""

    def __init__(self, fronts: Fronts) -> None:
        self.first, self.rows = fronts.first, np.concatenate(fronts.rows)
        self.width = np.diff(self.first)
        self.sizes = np.array([rows.size for rows in fronts.rows])
        self.begin = np.cumsum(self.sizes) - self.sizes
        self.front_of = np.repeat(np.arange(self.width.size), self.width)
        self._names = self._name(np.repeat(np.arange(self.width.size), self.sizes), self.rows)

    def _name(self, front: Indices, row: Indices) -> Indices:
        return np.asarray(front * self.front_of.size + row)

    def find(self, front: Indices, row: Indices) -> tuple[Mask, Indices]:
        """Return whether each ``row`` is a column of its ``front``, and its number there.

        It is the number among the columns, or else among the rows below.
        """
        own = row < self.first[front + 1]
        # All rows below are found by one search in the concatenated rows of all fronts.
        below = self._names.searchsorted(self._name(front, row)) - self.begin[front]
        return own, np.where(own, row - self.first[front], below)


def _targets(block: int, places: _Places, row: Indices, column: Indices) -> Indices:
    """Return the position in its front of each block entry, ``(count, block, block)``."""
    front = places.front_of[column]
    own, place = places.find(front, row)
    width, inside = places.width[front], np.arange(block)
    start = block * np.where(own, place, block * width**2 + place)
    height = block * np.where(own, width, places.sizes[front])
    across = block * (column - places.first[front])[:, None] + inside
    rows = (start[:, None] + inside)[:, :, None]
    target: Indices = rows + (height[:, None] * across)[:, None]
    return target


def _runs(block: int, places: _Places) -> dict[tuple[int, int], tuple[Runs, Runs]]:
    """Return for each child front and its parent the runs of rows that are consecutive there.

    The first runs are among the parent's columns, the others among its rows below.
    """
    child = np.repeat(np.arange(places.sizes.size), places.sizes)
    parent = places.front_of[places.rows[places.begin[child]]]
    own, place = places.find(parent, places.rows)
    # A place in the same part of the same parent is the next number, any other is not.
    number = place + (2 * child + ~own) * (places.front_of.size + 1)
    starts = np.flatnonzero(np.diff(number, prepend=-2) != 1)
    source = starts - places.begin[child[starts]]
    sizes = np.diff(starts, append=child.size)
    names = (child[starts], parent[starts], ~own[starts])
    scalars = (block * place[starts], block * source, block * sizes)
    runs: dict[tuple[int, int], tuple[Runs, Runs]] = {}
    for one, above, part, into, at, size in np.stack([*names, *scalars], axis=1).tolist():
        pair = slice(into, into + size), slice(at, at + size)
        runs.setdefault((one, above), ([], []))[part].append(pair)
    return runs


def _lower(runs: Runs) -> Pieces:
    """Return the pieces on and below the diagonal: each run with itself and earlier runs."""
    return [
        ((target, target2), (source, source2))
        for k, (target, source) in enumerate(runs)
        for target2, source2 in runs[: k + 1]
    ]
