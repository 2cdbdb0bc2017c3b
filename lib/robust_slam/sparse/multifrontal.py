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
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from robust_slam._arrays import Array, Indices
from robust_slam.sparse.elimination import Fronts

_RUNS = 24
"""An update of up to so many runs of neighbouring rows is added run by run."""

Place = tuple[slice, slice] | tuple[NDArray[np.intp], ...]
"""Where a piece of a matrix is, by slices or by ``np.ix_``."""


@dataclass(frozen=True, eq=False)
class _Plan:
    """What to do with a front of k scalar columns, from ``own.start`` on, and r rows below.

    ``top`` and ``side`` say where its two dense parts lie in the memory of all fronts: the
    triangle of its own columns ``(k, k)``, and the rows below it ``(r, k)``. ``updates``
    lists the fronts that hand something to this one, each with triples (part, there,
    here): the piece ``here`` of what is given is added at ``there`` of the top (0), the
    side (1) or this front's own update (2).
    """

    own: slice
    rows: Indices
    top: slice
    side: slice
    updates: list[tuple[int, list[tuple[int, Place, Place]]]]

    def parts(self, memory: Array) -> tuple[Array, Array]:
        """Return top and side in ``memory``, column after column, as BLAS wants them."""
        k, r = self.own.stop - self.own.start, self.rows.size
        top = memory[self.top].reshape((k, k), order="F")
        return top, memory[self.side].reshape((r, k), order="F")


class Multifrontal:
    """Factorises matrices over ``fronts``, ``row`` and ``column`` as in the pattern."""

    def __init__(self, block: int, fronts: Fronts, row: Indices, column: Indices) -> None:
        self.shape = (fronts.order.size, block)
        self.plans = _plans(block, fronts)
        self._target = _targets(block, fronts, self.plans, row, column)

    def factorise(self, blocks: Array, check: bool) -> MultifrontalFactors | None:
        """Return the factors, or None if the matrix is not positive definite.

        That is noticed in any case, so ``check`` changes nothing.
        """
        memory = np.zeros(self.plans[-1].side.stop)
        memory[self._target] = blocks
        given: dict[int, Array] = {}
        for number, plan in enumerate(self.plans):
            top, side = plan.parts(memory)
            update = np.zeros((plan.rows.size, plan.rows.size), order="F")
            parts = (top, side, update)
            for child, pieces in plan.updates:
                taken = given.pop(child)
                for part, there, here in pieces:
                    parts[part][there] += taken[here]
            _, failed = dpotrf(top, lower=1, overwrite_a=1, clean=0)
            if failed:
                return None
            if plan.rows.size:
                dtrsm(1.0, top, side, side=1, lower=1, trans_a=1, overwrite_b=1)
                given[number] = dsyrk(-1.0, side, beta=1.0, c=update, lower=1, overwrite_c=1)
        return MultifrontalFactors(self, memory)


@dataclass(frozen=True, eq=False)
class MultifrontalFactors:
    """The factor L of all fronts, as ``pattern.Factors``."""

    owner: Multifrontal
    memory: Array

    @property
    def pivots(self) -> Array:
        """The squared diagonal of L, ``(n − 1, b)``."""
        tops = [plan.parts(self.memory)[0] for plan in self.owner.plans]
        return (np.concatenate([np.diagonal(top) for top in tops]) ** 2).reshape(self.owner.shape)

    def solve(self, right: Array) -> Array:
        """Return the solutions ``(n − 1, b, c)``: forwards L y = ``right``, back Lᵀ x = y."""
        x = right.reshape(-1, right.shape[-1]).copy()
        steps = [(plan.own, plan.rows, *plan.parts(self.memory)) for plan in self.owner.plans]
        for own, rows, top, side in steps:
            x[own] = dtrsm(1.0, top, x[own], lower=1)
            x[rows] -= side @ x[own]
        for own, rows, top, side in reversed(steps):
            x[own] = dtrsm(1.0, top, x[own] - side.T @ x[rows], lower=1, trans_a=1)
        return x.reshape(right.shape)


def _plans(block: int, fronts: Fronts) -> list[_Plan]:
    plans: list[_Plan] = []
    end = 0
    inside = np.arange(block)
    for (first, after), rows in zip(pairwise(block * fronts.first), fronts.rows, strict=True):
        k, below = int(after - first), (rows[:, None] * block + inside).ravel()
        top, side = slice(end, end + k * k), slice(end + k * k, end + k * (k + below.size))
        end = side.stop
        plans.append(_Plan(slice(int(first), int(after)), below, top, side, []))
    front_of = np.repeat(np.arange(len(plans)), np.diff(fronts.first))
    for number, rows in enumerate(fronts.rows):
        if rows.size:
            parent = plans[front_of[rows[0]]]
            parent.updates.append((number, _pieces(plans[number].rows, parent)))
    return plans


def _pieces(rows: Indices, parent: _Plan) -> list[tuple[int, Place, Place]]:
    """Return how an update over ``rows`` is added to the three parts of ``parent``."""
    split = int(rows.searchsorted(parent.own.stop))
    inside = rows[:split] - parent.own.start
    below = parent.rows.searchsorted(rows[split:])
    tops, sides = _runs(inside, 0), _runs(below, split)
    if len(tops) + len(sides) > _RUNS:
        here, after = slice(0, split), slice(split, None)
        return [
            (0, np.ix_(inside, inside), (here, here)),
            (1, np.ix_(below, inside), (after, here)),
            (2, np.ix_(below, below), (after, after)),
        ]
    # Only the lower triangles count: a run meets itself and those before it.
    triangle = [(down, right) for k, down in enumerate(tops) for right in tops[: k + 1]]
    square = [(down, right) for down in sides for right in tops]
    lower = [(down, right) for k, down in enumerate(sides) for right in sides[: k + 1]]
    return [
        (part, (down[0], right[0]), (down[1], right[1]))
        for part, pairs in enumerate((triangle, square, lower))
        for down, right in pairs
    ]


def _runs(places: Indices, offset: int) -> list[tuple[slice, slice]]:
    """Return the slices that make up ``places``, and where they stand, from ``offset`` on."""
    if not places.size:
        return []
    cuts = (places[1:] - places[:-1] != 1).nonzero()[0] + 1
    starts = [0, *cuts.tolist()]
    return [
        (slice(place, place + b - a), slice(offset + a, offset + b))
        for place, a, b in zip(
            places[starts].tolist(), starts, [*starts[1:], places.size], strict=True
        )
    ]


def _targets(
    block: int, fronts: Fronts, plans: list[_Plan], row: Indices, column: Indices
) -> Indices:
    """Return where in the memory the entries of the blocks go, ``(k, block, block)``."""
    n = fronts.order.size
    front_of = np.repeat(np.arange(len(plans)), np.diff(fronts.first))[column]
    first, after = fronts.first[front_of], fronts.first[front_of + 1]
    own = row < after
    # Rows below a front are looked up in the rows of all fronts, one after the other.
    counts = np.array([rows.size for rows in fronts.rows])
    names = np.concatenate(fronts.rows) + n * np.repeat(np.arange(len(plans)), counts)
    before = np.concatenate([[0], np.cumsum(counts)])[front_of]
    down = np.where(own, row - first, np.searchsorted(names, n * front_of + row) - before)
    top, side = np.array([(plan.top.start, plan.side.start) for plan in plans]).T
    start = np.where(own, top[front_of], side[front_of]) + block * down
    height = block * np.where(own, after - first, counts[front_of])
    inside = np.arange(block)
    across = block * (column - first)[:, None] + inside
    there: Indices = (start[:, None] + inside)[:, :, None] + (height[:, None] * across)[:, None]
    return there
