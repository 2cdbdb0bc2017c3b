"""Multifrontal Cholesky factorisation, compiled by numba.

The method is that of ``elimination`` and ``multifrontal``, which are the text to read. Here no
front costs a Python call: blocks of columns are factorised by plain loops, and larger products
are numba's ``np.dot``.

A front of k scalar columns and r rows below is stored by columns of the factor, which are rows
here. Its *panel* ``(k, k + r)`` becomes the factor. Its *update* ``(r, r)`` waits on a stack
until the parent takes it.

LAPACK's own dpotrf, dtrsm and dsyrk, called by address, took a quarter to a third less time for
a factorisation of sphere2500 and torus3D; Gauss–Newton is quicker than GTSAM's on all public
graphs without them (``benchmarks.speed``).

Source: as ``multifrontal``; Duff and Reid 1983 for the stack, which the postorder allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from robust_slam._arrays import Array, Indices
from robust_slam.descent.sparse.elimination import Costs, Fronts

COSTS = Costs(front=0.4e-6, multiplication=3e-10, update=1.5e-9, stored=1e-9)
"""Seconds as in ``elimination``, where a front costs no Python call."""
_COLUMNS, _ROWS = 24, 96
"""Columns of a panel, and rows of an update, that are computed at once."""
_PLAIN = 16000
"""Multiplications up to which plain loops are faster than ``np.dot``."""
ROUNDING = {"contract", "reassoc"}
"""Sums may be reordered and fused with products, which changes results by rounding alone."""


class Plan(NamedTuple):
    """Where every number goes.

    Front f holds the columns ``first[f]`` to ``first[f + 1]`` − 1. Its rows below are at
    ``place[begin[f]:begin[f + 1]]`` in its parent's panel, positions in poses. It takes the
    updates of ``children[f]`` fronts and the blocks ``blocks[f]`` to ``blocks[f + 1]`` − 1,
    which are in the columns ``column`` of the matrix and the rows ``target`` of the panel.
    Panel f begins at ``panel[f]``, in scalars.
    """

    block: int
    first: Indices
    begin: Indices
    rows: Indices
    place: Indices
    children: Indices
    blocks: Indices
    column: Indices
    target: Indices
    panel: Indices


class Compiled:
    """Factorises matrices over ``fronts``, ``row`` and ``column`` as in the pattern."""

    def __init__(self, block: int, fronts: Fronts, row: Indices, column: Indices) -> None:
        self.shape = (fronts.order.size, block)
        first, rows = fronts.first, np.concatenate(fronts.rows)
        begin = np.append(0, np.cumsum([below.size for below in fronts.rows]))
        place, children, target = _places(first, begin, rows, row, column)
        height = block * (np.diff(first) + np.diff(begin))
        panel = np.append(0, np.cumsum(height * np.diff(first) * block))
        blocks = column.searchsorted(first)
        self.plan = Plan(block, first, begin, rows, place, children, blocks, column, target, panel)
        self._stack = np.empty(_stack_size(self.plan))
        self._panels: Array | None = None

    def solve(self, blocks: Array, right: Array) -> Array | None:
        """Return the solutions ``(n − 1, b, c)``, or None if not positive definite.

        L y = ``right`` is solved on the way, while each front is still in the processor's
        cache. The memory of the factor is used again by the next solve.
        """
        self._check(blocks)
        if self._panels is None:
            self._panels = np.empty(self.plan.panel[-1])
        x = _columns(right)
        if not _factorise(self.plan, blocks, self._panels, self._stack, x):
            return None
        _back_substitute(self.plan, self._panels, x)
        return _rows(x, right)

    def factorise(self, blocks: Array) -> CompiledFactors | None:
        """Return the factors of ``blocks`` ``(k, b, b)``, or None if not positive definite."""
        self._check(blocks)
        panels, nothing = np.empty(self.plan.panel[-1]), np.empty((0, 0))
        found = _factorise(self.plan, blocks, panels, self._stack, nothing)
        return CompiledFactors(self, panels) if found else None

    def _check(self, blocks: Array) -> None:
        # Compiled code reads what is there, also beyond the end.
        expected = (self.plan.target.size, self.plan.block, self.plan.block)
        if blocks.shape != expected:
            raise ValueError(f"blocks: the shape is {blocks.shape}; give {expected}")


@dataclass(frozen=True, eq=False)
class CompiledFactors:
    """The panels of the factor L, front by front, as ``pattern.Factors``."""

    owner: Compiled
    panels: Array

    @property
    def pivots(self) -> Array:
        """The squared diagonal of L, ``(n − 1, b)``."""
        return _diagonal(self.owner.plan, self.panels).reshape(self.owner.shape) ** 2

    def solve(self, right: Array) -> Array:
        """Return the solutions ``(n − 1, b, c)``."""
        x = _columns(right)
        _forward_substitute(self.owner.plan, self.panels, x)
        _back_substitute(self.owner.plan, self.panels, x)
        return _rows(x, right)


def _columns(right: Array) -> Array:
    """Return right-hand sides ``(n − 1, b, c)`` as ``(c, unknowns)``, a copy."""
    return right.reshape(-1, right.shape[-1]).T.copy()


def _rows(x: Array, right: Array) -> Array:
    """Return solutions ``(c, unknowns)`` in the shape of ``right``."""
    return x.T.copy().reshape(right.shape)


@njit(cache=True)
def _places(
    first: Indices, begin: Indices, rows: Indices, row: Indices, column: Indices
) -> tuple[Indices, Indices, Indices]:
    """Return place, children and target of the plan."""
    count = first.size - 1
    place, target = np.empty(rows.size, dtype=np.int64), np.empty(row.size, dtype=np.int64)
    children, pending = np.zeros(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    local, waiting, block = np.empty(first[-1], dtype=np.int64), 0, 0
    for f in range(count):
        width = first[f + 1] - first[f]
        local[first[f] : first[f + 1]] = np.arange(width)
        local[rows[begin[f] : begin[f + 1]]] = width + np.arange(begin[f + 1] - begin[f])
        while block < row.size and column[block] < first[f + 1]:
            target[block] = local[row[block]]
            block += 1
        while waiting > 0 and rows[begin[pending[waiting - 1]]] < first[f + 1]:
            waiting -= 1
            children[f] += 1
            child = pending[waiting]
            for k in range(begin[child], begin[child + 1]):
                place[k] = local[rows[k]]
        if begin[f + 1] > begin[f]:
            pending[waiting] = f
            waiting += 1
    return place, children, target


@njit(cache=True)
def _stack_size(plan: Plan) -> int:
    """Return how many scalars the updates take at once, with the one being made."""
    pending = np.empty(plan.children.size, dtype=np.int64)
    waiting = size = largest = 0
    for f in range(plan.children.size):
        own = ((plan.begin[f + 1] - plan.begin[f]) * plan.block) ** 2
        largest = max(largest, size + own)
        for _ in range(plan.children[f]):
            waiting -= 1
            size -= pending[waiting]
        if own > 0:
            pending[waiting] = own
            waiting, size = waiting + 1, size + own
    return largest


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _factorise(plan: Plan, blocks: Array, panels: Array, stack: Array, x: Array) -> bool:
    """Fill ``panels`` with the factor; return whether the matrix is positive definite.

    Right-hand sides ``x`` ``(c, unknowns)`` are replaced by the y of L y = ``x``.
    """
    block, top, waiting = plan.block, 0, 0
    work = np.empty(plan.first[-1] * block)
    pending = np.empty(plan.children.size, dtype=np.int64)
    for f in range(plan.children.size):
        k = (plan.first[f + 1] - plan.first[f]) * block
        r = (plan.begin[f + 1] - plan.begin[f]) * block
        panel, update = panels[plan.panel[f] : plan.panel[f + 1]], stack[top : top + r * r]
        panel[:] = 0.0
        update[:] = 0.0
        _take_blocks(plan, f, blocks, panel, k + r)
        base = top
        for _ in range(plan.children[f]):
            waiting -= 1
            child = pending[waiting]
            size = (plan.begin[child + 1] - plan.begin[child]) * block
            base -= size * size
            place = plan.place[plan.begin[child] : plan.begin[child + 1]]
            _extend_add(block, place, stack[base : base + size * size], panel, k, update, r)
        if not _eliminate(panel.reshape(k, k + r), update.reshape(r, r)):
            return False
        _forward(plan, f, panel, x, work)
        if r > 0:
            if base < top:
                for entry in range(r * r):
                    stack[base + entry] = stack[top + entry]
            pending[waiting] = f
            waiting += 1
        top = base + r * r
    return True


@njit(cache=True)
def _take_blocks(plan: Plan, f: int, blocks: Array, panel: Array, height: int) -> None:
    """Copy the matrix's blocks into the panel."""
    block = plan.block
    for q in range(plan.blocks[f], plan.blocks[f + 1]):
        column, row = (plan.column[q] - plan.first[f]) * block, plan.target[q] * block
        for j in range(block):
            at = (column + j) * height + row
            for i in range(block):
                panel[at + i] = blocks[q, i, j]


@njit(cache=True)
def _extend_add(
    block: int, place: Indices, source: Array, panel: Array, k: int, update: Array, r: int
) -> None:
    """Add a child's update to the panel and the update of its parent."""
    size, count = place.size * block, place.size
    for b in range(count):
        for j in range(block):
            column = place[b] * block + j
            inside = column < k
            whole = panel if inside else update
            start = column * (k + r) if inside else (column - k) * r - k
            own = (b * block + j) * size
            a = b
            while a < count:
                last = a + 1
                while last < count and place[last] == place[last - 1] + 1:
                    last += 1
                into = start + place[a] * block
                length = (last - a) * block
                target = whole[into : into + length]
                given = source[own + a * block : own + last * block]
                for i in range(length):
                    target[i] += given[i]
                a = last


@njit(cache=True)
def _eliminate(panel: Array, update: Array) -> bool:
    """Factorise the panel ``(k, k + r)`` and subtract its product from the update ``(r, r)``.

    Rows are columns of the factor. Return whether all pivots are positive.
    """
    k, height = panel.shape
    for first in range(0, k, _COLUMNS):
        last = min(first + _COLUMNS, k)
        _subtract(panel[first:last, first:], panel[:first, first:])
        if not _eliminate_few(panel[first:last, first:]):
            return False
    for first in range(k, height, _ROWS):
        last = min(first + _ROWS, height)
        _subtract(update[first - k : last - k, first - k :], panel[:, first:])
    return True


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _subtract(target: Array, factor: Array) -> None:
    """Subtract F[:, :b]ᵀ F from the ``target`` ``(b, c)``, with the ``factor`` F ``(p, c)``."""
    b = len(target)
    if factor.size * b > _PLAIN:
        whole = np.ascontiguousarray(factor)
        target -= np.dot(np.ascontiguousarray(whole[:, :b]).T, whole)
        return
    for j in range(b):
        _subtract_from_row(target[j, j:], factor[:, j:])


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _eliminate_few(panel: Array) -> bool:
    for j in range(len(panel)):
        row = panel[j, j:]
        _subtract_from_row(row, panel[:j, j:])
        if not row[0] > 0.0:
            return False
        root = np.sqrt(row[0])
        for i in range(row.size):
            row[i] /= root
    return True


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _subtract_from_row(row: Array, factor: Array) -> None:
    """Subtract F[:, 0]ᵀ F, three rows of F at once: so the row is read and written less often."""
    size, p = row.size, 0
    while p + 3 <= len(factor):
        a, b, c = factor[p], factor[p + 1], factor[p + 2]
        x, y, z = a[0], b[0], c[0]
        for i in range(size):
            row[i] -= x * a[i] + y * b[i] + z * c[i]
        p += 3
    while p < len(factor):
        a = factor[p]
        x = a[0]
        for i in range(size):
            row[i] -= x * a[i]
        p += 1


@njit(cache=True)
def _diagonal(plan: Plan, panels: Array) -> Array:
    diagonal, at = np.empty(plan.first[-1] * plan.block), 0
    for f in range(plan.children.size):
        k = (plan.first[f + 1] - plan.first[f]) * plan.block
        height = k + (plan.begin[f + 1] - plan.begin[f]) * plan.block
        for j in range(k):
            diagonal[at] = panels[plan.panel[f] + j * (height + 1)]
            at += 1
    return diagonal


@njit(cache=True)
def _forward_substitute(plan: Plan, panels: Array, x: Array) -> None:
    """Replace ``x`` ``(c, unknowns)`` by the solution y of L y = ``x``."""
    work = np.empty(x.shape[1])
    for f in range(plan.children.size):
        _forward(plan, f, panels[plan.panel[f] : plan.panel[f + 1]], x, work)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _forward(plan: Plan, f: int, panel: Array, x: Array, work: Array) -> None:
    """Eliminate the columns of a front from the right-hand sides ``x`` ``(c, unknowns)``."""
    for one in x:
        k, height = _gather(plan, f, one, work)
        for j in range(k):
            column, own = panel[j * height : (j + 1) * height], work[:height]
            own[j] /= column[j]
            y = own[j]
            for i in range(j + 1, height):
                own[i] -= y * column[i]
        _scatter(plan, f, one, work, k)


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _back_substitute(plan: Plan, panels: Array, x: Array) -> None:
    """Replace the y in ``x`` ``(c, unknowns)`` by the solution of Lᵀ x = y."""
    work = np.empty(x.shape[1])
    for f in range(plan.children.size - 1, -1, -1):
        panel, start = panels[plan.panel[f] : plan.panel[f + 1]], plan.first[f] * plan.block
        for one in x:
            k, height = _gather(plan, f, one, work)
            for j in range(k - 1, -1, -1):
                column, own, y = panel[j * height : (j + 1) * height], work[:height], 0.0
                for i in range(j + 1, height):
                    y += column[i] * own[i]
                own[j] = (own[j] - y) / column[j]
            one[start : start + k] = work[:k]


@njit(cache=True)
def _gather(plan: Plan, f: int, x: Array, work: Array) -> tuple[int, int]:
    """Copy the unknowns of a front to ``work``; return how many are its own, and how many."""
    block, start, after = plan.block, plan.first[f] * plan.block, plan.first[f + 1] * plan.block
    at = after - start
    work[:at] = x[start:after]
    for row in plan.rows[plan.begin[f] : plan.begin[f + 1]]:
        for i in range(block):
            work[at + i] = x[row * block + i]
        at += block
    return after - start, at


@njit(cache=True)
def _scatter(plan: Plan, f: int, x: Array, work: Array, k: int) -> None:
    """Copy them back."""
    block, at = plan.block, k
    x[plan.first[f] * block : plan.first[f] * block + k] = work[:k]
    for row in plan.rows[plan.begin[f] : plan.begin[f + 1]]:
        for i in range(block):
            x[row * block + i] = work[at + i]
        at += block
