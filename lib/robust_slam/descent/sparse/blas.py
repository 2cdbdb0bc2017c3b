"""The dense factorisation of a front by the BLAS and LAPACK that scipy carries.

Compiled code that is kept on disk cannot hold the address of a function. So the addresses
are looked up once per process and passed as arguments.

Source: Duff and Reid 1983, the partial factorisation of a front.
"""

from __future__ import annotations

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core.base import BaseContext
from numba.core.typing import Signature
from numba.extending import get_cython_function_address, intrinsic

from robust_slam._arrays import Array, Indices


def addresses() -> Indices:
    """Return where dpotrf, dtrsm and dsyrk are in memory, ``(3,)``."""
    names = ("lapack", "dpotrf"), ("blas", "dtrsm"), ("blas", "dsyrk")
    return np.array([get_cython_function_address(f"scipy.linalg.cython_{m}", f) for m, f in names])


@intrinsic
def _call(
    typing_context: BaseContext, address: types.Type, pointers: types.Type
) -> tuple[Signature, object]:
    """Call the C function at ``address`` with a tuple of ``pointers``."""

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
def eliminate_by_blas(panel: Array, k: int, r: int, update: Array, at: Indices) -> bool:
    """Factorise a panel ``(k + r, k)`` and subtract its product from the update ``(r, r)``.

    Both are stored by columns; ``at`` are the ``addresses``. Return whether all pivots are
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
