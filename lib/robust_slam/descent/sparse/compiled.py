"""Multifrontal Cholesky factorisation, compiled by numba.

The method is that of ``elimination`` and ``multifrontal``, which are the text to read. Here no
front costs a Python call: small fronts are factorised by plain loops, larger ones by the BLAS
and LAPACK that scipy carries.

A front of k scalar columns and r rows below is stored by columns. Its *panel* ``(k + r, k)``
becomes the factor. Its *update* ``(r, r)`` waits on a stack until the parent takes it.

Source: as ``multifrontal``; Duff and Reid 1983 for the stack, which the postorder allows.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.base import BaseContext
from numba.core.typing import Signature
from numba.extending import get_cython_function_address, intrinsic

from robust_slam._arrays import Array, Indices
from robust_slam.descent.sparse.elimination import Elimination

_FRONT, _MULTIPLICATION, _UPDATE, _STORED = 0.4e-6, 3e-10, 1.5e-9, 1e-9
"""Seconds as in ``elimination``, where a front costs no Python call."""
_PLAIN = 16000
"""Multiplications up to which plain loops are faster than calls of BLAS."""
ROUNDING = {"contract", "reassoc"}
"""Sums may be reordered and fused with products, which changes results by rounding alone."""


class CompiledFronts(NamedTuple):
    """Consecutive fronts as ``elimination.Fronts``, the rows of all in one array.

    Front f has the rows ``rows[begin[f]:begin[f + 1]]``.
    """

    order: Indices
    first: Indices
    begin: Indices
    rows: Indices


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

    def __init__(self, block: int, fronts: CompiledFronts, row: Indices, column: Indices) -> None:
        self.shape = (fronts.order.size, block)
        _, first, begin, rows = fronts
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
        if not _factorise(self.plan, blocks, self._panels, self._stack, _addresses(), x):
            return None
        _back_substitute(self.plan, self._panels, x)
        return _rows(x, right)

    def factorise(self, blocks: Array) -> CompiledFactors | None:
        """Return the factors of ``blocks`` ``(k, b, b)``, or None if not positive definite."""
        self._check(blocks)
        panels, nothing = np.empty(self.plan.panel[-1]), np.empty((0, 0))
        found = _factorise(self.plan, blocks, panels, self._stack, _addresses(), nothing)
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


def find_compiled_fronts(elimination: Elimination, block: int) -> CompiledFronts:
    """Return the fronts of an elimination as ``elimination.find_fronts`` does."""
    factor = elimination.factor
    starts, indices = factor.indptr.astype(np.intp), factor.indices.astype(np.intp)
    postorder, first, begin, rows = _fronts(starts, indices, block)
    return CompiledFronts(elimination.order[postorder], first, begin, rows)


@njit(cache=True)
def _fronts(
    starts: Indices, indices: Indices, block: int
) -> tuple[Indices, Indices, Indices, Indices]:
    """Return the postorder, the first columns, and begin and entries of the rows below."""
    n = starts.size - 1
    parent = np.full(n, -1)
    for v in range(n):
        if starts[v + 1] > starts[v]:
            parent[v] = indices[starts[v] : starts[v + 1]].min()
    postorder = _postorder(parent)
    position = np.empty(n, dtype=np.int64)
    position[postorder] = np.arange(n)
    above, below = np.full(n, n), np.empty(n, dtype=np.int64)
    for k, v in enumerate(postorder):
        below[k] = starts[v + 1] - starts[v]
        if parent[v] >= 0:
            above[k] = position[parent[v]]
    first = _first_columns(above, below, block)
    begin = np.zeros(first.size, dtype=np.int64)
    for f in range(first.size - 1):
        begin[f + 1] = begin[f] + below[first[f + 1] - 1]
    rows = np.empty(begin[-1], dtype=np.int64)
    for f in range(first.size - 1):
        last = postorder[first[f + 1] - 1]
        rows[begin[f] : begin[f + 1]] = np.sort(position[indices[starts[last] : starts[last + 1]]])
    return postorder, first, begin, rows


@njit(cache=True)
def _postorder(parent: Indices) -> Indices:
    """Return the vertices of a forest, children before their parent, subtrees contiguous."""
    n = parent.size
    youngest, elder = np.full(n + 1, -1), np.full(n, -1)
    for v in range(n):
        above = parent[v] if parent[v] >= 0 else n
        elder[v], youngest[above] = youngest[above], v
    order, stack, size, k = np.empty(n, dtype=np.int64), np.empty(n, dtype=np.int64), 0, n
    v = youngest[n]
    while v >= 0 or size > 0:
        if v < 0:
            size -= 1
            v = stack[size]
        k -= 1
        order[k] = v
        if elder[v] >= 0:
            stack[size] = elder[v]
            size += 1
        v = youngest[v]
    return order


@njit(cache=True)
def _first_columns(parent: Indices, below: Indices, block: int) -> Indices:
    """Return the first column of each front, and the number of columns at the end."""
    n = parent.size
    firsts, seconds, size = np.empty(n + 1, dtype=np.int64), np.empty(n), 0
    for column in range(n):
        first, height = column, block * below[column]
        own = _seconds(block, height)
        while size > 0 and first <= parent[first - 1] <= column:
            joint = _seconds(block * (column - firsts[size - 1] + 1), height)
            if joint > own + seconds[size - 1]:
                break
            size -= 1
            first, own = firsts[size], joint
        firsts[size], seconds[size] = first, own
        size += 1
    firsts[size] = n
    return firsts[: size + 1].copy()


@njit(cache=True)
def _seconds(k: int, r: int) -> float:
    """Return the time in s for a front of k columns with r rows below."""
    multiplications = k * (k * k / 3 + r * (k + r))
    return _FRONT + _MULTIPLICATION * multiplications + _UPDATE * r * r + _STORED * k * (k + r)


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
def _factorise(
    plan: Plan, blocks: Array, panels: Array, stack: Array, at: Indices, x: Array
) -> bool:
    """Fill ``panels`` with the factor; return whether the matrix is positive definite.

    Right-hand sides ``x`` ``(c, unknowns)`` are replaced by the y of L y = ``x``; ``at`` are
    the ``_addresses``.
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
        if k * (k + r) * (k + r) <= _PLAIN:
            good = _eliminate(panel, k, r, update)
        else:
            good = _eliminate_by_blas(panel, k, r, update, at)
        if not good:
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


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _eliminate(panel: Array, k: int, r: int, update: Array) -> bool:
    """Factorise the panel and subtract its product from the update, by plain loops."""
    height = k + r
    for j in range(k):
        _subtract(panel[j * height + j : (j + 1) * height], panel, height, j, j)
        pivot = panel[j * height + j]
        if not pivot > 0.0:
            return False
        root = np.sqrt(pivot)
        for i in range(j * height + j, (j + 1) * height):
            panel[i] /= root
    for j in range(r):
        _subtract(update[j * r + j : (j + 1) * r], panel, height, k + j, k)
    return True


@njit(cache=True, error_model="numpy", fastmath=ROUNDING)
def _subtract(column: Array, panel: Array, height: int, row: int, count: int) -> None:
    """Subtract Σ L[row, p] L[row:, p] over the first ``count`` columns p of the panel."""
    size, p = column.size, 0
    while p + 3 <= count:
        at = p * height + row
        a, b, c = (
            panel[at : at + size],
            panel[at + height : at + height + size],
            panel[at + 2 * height : at + 2 * height + size],
        )
        x, y, z = a[0], b[0], c[0]
        for i in range(size):
            column[i] -= x * a[i] + y * b[i] + z * c[i]
        p += 3
    while p < count:
        a = panel[p * height + row : p * height + row + size]
        x = a[0]
        for i in range(size):
            column[i] -= x * a[i]
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


def _addresses() -> Indices:
    """Return where dpotrf, dtrsm and dsyrk are in memory, ``(3,)``."""
    names = ("lapack", "dpotrf"), ("blas", "dtrsm"), ("blas", "dsyrk")
    return np.array([get_cython_function_address(f"scipy.linalg.cython_{m}", f) for m, f in names])


@intrinsic
def _call(
    typing_context: BaseContext, address: types.Type, pointers: types.Type
) -> tuple[Signature, object]:
    """Call the C function at ``address`` with a tuple of ``pointers``.

    The address is an argument because compiled code that is kept on disk cannot hold it.
    """

    def generate(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, values: list[ir.Value]
    ) -> ir.Value:
        pointer, count = ir.IntType(8).as_pointer(), len(signature.args[1])
        function = ir.FunctionType(ir.VoidType(), [pointer] * count)
        target = builder.inttoptr(values[0], function.as_pointer())
        taken = [builder.extract_value(values[1], k) for k in range(count)]
        builder.call(target, [builder.inttoptr(value, pointer) for value in taken])
        return context.get_dummy_value()

    return types.void(address, pointers), generate


@njit(cache=True)
def _eliminate_by_blas(panel: Array, k: int, r: int, update: Array, at: Indices) -> bool:
    """Factorise a panel ``(k + r, k)`` and subtract its product from the update ``(r, r)``.

    Both are stored by columns; ``at`` are the ``_addresses``. Return whether all pivots are
    positive.
    """
    integers, numbers = np.array([k, r, k + r, 0], dtype=np.int32), np.array([1.0, -1.0])
    letters = np.frombuffer(b"LRTN", dtype=np.uint8)
    n, one = integers.ctypes.data, numbers.ctypes.data
    m, height, failed, minus = n + 4, n + 8, n + 12, one + 8
    lower = letters.ctypes.data
    right, transposed, plain = lower + 1, lower + 2, lower + 3
    top, side, rest = panel.ctypes.data, panel.ctypes.data + 8 * k, update.ctypes.data
    _call(at[0], (lower, n, top, height, failed))
    if integers[3] != 0:
        return False
    if r > 0:
        _call(at[1], (right, lower, transposed, plain, m, n, one, top, height, side, height))
        _call(at[2], (lower, plain, m, n, minus, side, height, one, rest, m))
    return True
