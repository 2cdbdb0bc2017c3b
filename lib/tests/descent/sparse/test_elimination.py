"""The order of elimination, its fill-in and its fronts."""

import numpy as np
import pytest
from robust_slam.descent.sparse import elimination
from robust_slam.descent.sparse.elimination import find_elimination, find_fronts

from .matrices import random_edges


def fill(n, edges, order):
    """Which places each place is joined to later, by playing the elimination."""
    place = np.argsort(order)
    joined = [set() for _ in range(n)]
    for i, j in place[edges].tolist():
        joined[min(i, j)].add(max(i, j))
    for k in range(n):
        if joined[k]:
            first = min(joined[k])
            joined[first] |= joined[k] - {first}
    return joined


@pytest.mark.parametrize("seed", range(5))
def test_the_factor_has_the_fill_in_of_the_order(seed):
    rng = np.random.default_rng(seed)
    edges = random_edges(40, 30, rng)
    elimination = find_elimination(40, edges)
    expected = fill(40, edges, elimination.order)
    factor = elimination.factor.toarray() != 0.0
    for k, later in enumerate(expected):
        assert set(np.flatnonzero(factor[:, k]).tolist()) == later
    np.testing.assert_array_equal(elimination.filled, [len(later) for later in expected])


def test_a_long_drive_with_short_loops_loses_no_fill_in_to_underflow():
    rng = np.random.default_rng(0)
    n, first = 3000, rng.integers(0, 2940, 100)
    drive = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    loops = np.stack([first, first + rng.integers(2, 60, first.size)], axis=1)
    edges = np.concatenate([drive, loops])
    elimination = find_elimination(n, edges)
    expected = fill(n, edges, elimination.order)
    np.testing.assert_array_equal(elimination.filled, [len(later) for later in expected])


@pytest.mark.parametrize("front", [elimination.COSTS.front, 0.0])
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("n", "more"), [(1, 0), (2, 0), (40, 0), (40, 60), (25, 300)])
def test_fronts_cover_all_columns_and_hold_what_is_filled_in(front, seed, n, more, monkeypatch):
    monkeypatch.setattr(elimination, "COSTS", elimination.COSTS._replace(front=front))
    edges = random_edges(n, more, np.random.default_rng(seed)) if n > 1 else np.empty((0, 2), int)
    fronts = find_fronts(find_elimination(n, edges), 3)
    assert sorted(fronts.order.tolist()) == list(range(n))
    assert fronts.first[0] == 0 and fronts.first[-1] == n and np.all(np.diff(fronts.first) > 0)
    expected = fill(n, edges, fronts.order)
    for first, after, rows in zip(fronts.first, fronts.first[1:], fronts.rows, strict=False):
        held = set(range(first, after)) | set(rows.tolist())
        assert set().union(*expected[first:after]) <= held
        assert rows.tolist() == sorted(expected[after - 1])


@pytest.mark.parametrize("seed", range(3))
def test_columns_of_a_front_are_in_the_order_of_their_first_use_as_rows(seed):
    edges = random_edges(300, 60, np.random.default_rng(seed))
    fronts = find_fronts(find_elimination(300, edges), 6)
    assert len(fronts.rows) > 3
    use = np.full(300, len(fronts.rows))
    for number, rows in reversed(list(enumerate(fronts.rows))):
        use[rows] = number
    for first, after in zip(fronts.first, fronts.first[1:], strict=False):
        assert np.all(np.diff(use[first:after]) >= 0)


def test_few_multiplications_for_a_chain_and_many_for_a_clique():
    chain = np.stack([np.arange(49), np.arange(1, 50)], axis=1)
    clique = np.array([(i, j) for j in range(50) for i in range(j)])
    # A chain: 49 columns with one entry below; a clique: 49, 48, … below.
    assert find_elimination(50, chain).multiplications == (49 * 4 + 1) / 2
    assert find_elimination(50, clique).multiplications == np.sum(np.arange(1, 51) ** 2) / 2
