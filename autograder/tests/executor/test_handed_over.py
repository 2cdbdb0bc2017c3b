"""A callable that a test hands over runs with arguments that its author provided for."""

import functools
import math
import operator
from typing import Any

import numpy as np
import pytest
from robust_slam_autograder.executor import handed_over
from robust_slam_autograder.protocol import wire
from scipy import special

from ..sessions import started

COLUMN, ROW = np.ones((20_000, 1)), np.ones((1, 20_000))
LARGE = np.zeros(handed_over.MAX_BYTES // 8 + 1)


def rho(u: Any, c: float = 2.0, *rest: object, scale: float = 1.0, **more: object) -> Any:
    return scale * np.minimum(u, c)


class Kernel:
    def rho(self, u: Any) -> Any:
        return u

    def __call__(self, u: Any) -> Any:
        return u


@pytest.mark.parametrize(
    ("function", "args", "kwargs"),
    [
        (np.add, (1.0, 2.0), {"where": np.array([True])}),
        (np.add, (1.0, 2.0), {"out": np.zeros(1)}),
        (np.add, (1.0, 2.0, np.zeros(1)), {}),
        (np.add, (1.0,), {}),
        (np.add, (1.0, "x"), {}),
        (np.add, (1.0, [None]), {}),
        (np.add, (1, 2**70), {}),
        (np.add, (COLUMN, ROW), {}),
        (np.sin, (LARGE,), {}),
        (special.huber, (COLUMN, ROW), {}),
        (functools.partial(np.add, COLUMN), (ROW,), {}),
        (functools.partial(np.add, 1.0), (1.0, np.zeros(1)), {}),
        (functools.partial(np.add, 1.0), (1.0,), {"dtype": "O"}),
        (np.linalg.norm, (1.0,), {"ord": 2}),
        (np.sum, (np.ones(3),), {"out": np.zeros(())}),
        (sorted, ([1, 2],), {"key": abs}),
        (eval, ("1 + 1",), {}),
        (operator.methodcaller("tofile", "x"), ("y",), {}),
        (map, (abs, [1]), {}),
        (rho, (1.0,), {"rest": 1}),
        (rho, (1.0,), {"anything": 1}),
        (rho, (LARGE,), {}),
        (rho, (), {"u": [LARGE[1:], {"more": (LARGE[2:],)}]}),
        (lambda u: u, ("x" * (handed_over.MAX_BYTES + 1),), {}),
        (np.vectorize(math.sin), (1.0,), {"signature": 1}),
        (Kernel().rho, (1.0,), {"self": 1}),
        (Kernel(), (1.0,), {"c": 1}),
    ],
)
def test_what_the_author_did_not_provide_for_is_refused(function, args, kwargs):
    with pytest.raises(TypeError):
        handed_over.check(function, args, kwargs)


@pytest.mark.parametrize(
    ("function", "args", "kwargs"),
    [
        (np.sin, (np.zeros(1_000_000),), {}),
        (np.add, (np.zeros((1000, 1)), [1, 2]), {}),
        (np.matmul, (np.eye(3), np.ones((3, 1))), {}),
        (functools.partial(np.add, 1.0), (np.ones(3),), {}),
        (functools.partial(rho, c=1.0), (np.ones(3),), {"scale": 2.0}),
        (special.huber, (1.0, np.ones(3)), {}),
        (np.linalg.norm, ([1.0, 2.0],), {}),
        (math.hypot, (1, 2), {}),
        (rho, (np.ones(3), 1.0, 2), {"scale": 2.0}),
        (rho, (), {"u": np.ones(3), "c": 1.0}),
        (lambda graph, weights, poses: poses, ({"edges": [(0, 1)]}, None, np.eye(3)), {}),
        (Kernel().rho, (1.0,), {}),
        (Kernel(), (), {"u": 1.0}),
        (np.vectorize(math.sin), (np.ones(3),), {}),
    ],
)
def test_a_plain_call_is_made(function, args, kwargs):
    handed_over.check(function, args, kwargs)
    function(*args, **kwargs)


STUDENT = """
import numpy as np
def f(add):
    said = [add(1.0, 2.0)]
    column = np.ones((20000, 1))
    for args, kwargs in [((1.0, 2.0), {'where': [True]}), ((column, column.T), {})]:
        try:
            said.append(add(*args, **kwargs))
        except Exception as error:
            said.append(str(error))
    return said
"""


def test_a_session_makes_no_other_call():
    with started(STUDENT) as session:
        said = session.bindings()["f"](np.add)
    assert said == [
        3.0,
        "add takes 2 positional arguments and no others here",
        "the result of add would be too large",
    ]


@pytest.mark.parametrize("kind", "beQF")
def test_numbers_count_as_large_as_they_are_widened(kind):
    """An answer of a byte a number would take eight times its message in memory."""
    size = 16 if kind == "F" else 8
    fits, large = (np.zeros(wire.MAX_MESSAGE // size // 2 + n, kind) for n in (-100, 101))
    assert len(wire.decode(wire.encode([fits] * 2, int), int, widen=True)) == 2
    with pytest.raises(wire.WireError, match=r"double precision|is larger"):
        wire.encode([fits, large], int)
