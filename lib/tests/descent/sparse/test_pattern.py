"""Both factorisations of a sparse matrix against dense linear algebra."""

import pickle

import numpy as np
import pytest
from robust_slam.descent.sparse.pattern import find_pattern

from .matrices import METHODS, as_dense, dense, edge_blocks, pattern_by, random_edges

pytestmark = [pytest.mark.long, pytest.mark.rest]

sizes = pytest.mark.parametrize(
    ("n", "more", "block"),
    [(2, 0, 3), (2, 3, 1), (9, 0, 2), (40, 15, 3), (60, 150, 6), (35, 200, 4)],
)


@pytest.fixture(params=METHODS)
def method(request):
    return request.param


@pytest.fixture
def case(method, monkeypatch):
    def make(n, more, block, seed=0):
        rng = np.random.default_rng(seed)
        edges = random_edges(n, more, rng)
        blocks = edge_blocks(len(edges), block, rng)
        return pattern_by(method, n, edges, block, monkeypatch), edges, blocks, rng

    return make


@sizes
def test_the_edges_add_up_and_only_joined_poses_have_blocks_each_once(case, n, more, block):
    pattern, edges, blocks, _ = case(n, more, block)
    full = dense(n, edges, blocks)[block:, block:]
    np.testing.assert_allclose(as_dense(pattern, pattern.sum_edges(blocks)), full, atol=1e-12)
    ends = np.sort(edges[np.all(edges > 0, axis=1)], axis=1)
    joined = {tuple(edge) for edge in ends.tolist()} | {(k, k) for k in range(1, n)}
    pairs = np.sort(np.stack([pattern.order[pattern.row], pattern.order[pattern.column]], 1), 1)
    assert sorted(map(tuple, pairs.tolist())) == sorted(joined)
    assert sorted(pattern.order.tolist()) == list(range(1, n))
    assert np.all(pattern.row >= pattern.column)


@sizes
@pytest.mark.parametrize("columns", [(), (3,)])
def test_the_solution_is_the_dense_one_and_zero_at_pose_0(case, n, more, block, columns):
    pattern, edges, blocks, rng = case(n, more, block)
    right = rng.normal(size=(n, block, *columns))
    x = pattern.factorise(pattern.sum_edges(blocks)).solve(right)
    full = dense(n, edges, blocks)[block:, block:]
    expected = np.linalg.solve(full, right[1:].reshape((n - 1) * block, -1))
    np.testing.assert_allclose(x[1:].reshape(expected.shape), expected, rtol=1e-7, atol=1e-9)
    np.testing.assert_array_equal(x[0], np.zeros((block, *columns)))
    at_once = pattern.solve(pattern.sum_edges(blocks), right)
    np.testing.assert_allclose(at_once, x, rtol=1e-9, atol=1e-12)


def test_a_shift_is_added_to_the_diagonal(case):
    pattern, edges, blocks, rng = case(30, 40, 3)
    shift, right = rng.uniform(0.0, 5.0, (30, 3)), rng.normal(size=(30, 3))
    total = pattern.sum_edges(blocks)
    before = total.copy()
    x = pattern.factorise(total, shift).solve(right)
    np.testing.assert_allclose(pattern.solve(total, right, shift), x, rtol=1e-9, atol=1e-12)
    full = dense(30, edges, blocks)[3:, 3:] + np.diag(shift[1:].ravel())
    np.testing.assert_allclose(x[1:].ravel(), np.linalg.solve(full, right[1:].ravel()), rtol=1e-7)
    np.testing.assert_array_equal(total, before)
    diagonal = np.diag(full) - shift[1:].ravel()
    np.testing.assert_allclose(pattern.diagonal(total)[1:].ravel(), diagonal)


@pytest.mark.parametrize("seed", range(4))
def test_a_matrix_that_is_not_positive_definite_has_no_factors(case, seed):
    pattern, edges, blocks, _ = case(30, 25, 3, seed)
    lowest = np.linalg.eigvalsh(dense(30, edges, blocks)[3:, 3:])[0]
    total, ones = pattern.sum_edges(blocks), np.ones((30, 3))
    assert pattern.factorise(total, -(1.0 - 1e-6) * lowest * ones) is not None
    assert pattern.factorise(total, -(1.0 + 1e-6) * lowest * ones) is None
    assert pattern.factorise(0.0 * total) is None
    assert pattern.solve(0.0 * total, ones) is None


def test_factors_are_their_own_or_are_stale(case, method):
    pattern, _, blocks, rng = case(20, 20, 3)
    right, total = rng.normal(size=(20, 3)), pattern.sum_edges(blocks)
    first = pattern.factorise(total)
    x = first.solve(right)
    second = pattern.factorise(2.0 * total)
    np.testing.assert_allclose(second.solve(right), 0.5 * x, rtol=1e-9)
    if method == "simplicial":
        with pytest.raises(RuntimeError, match="stale"):
            first.solve(right)
    else:
        np.testing.assert_array_equal(first.solve(right), x)


def test_a_pickled_pattern_gives_the_same_and_a_singular_matrix_after_a_good_one_is_noticed(case):
    pattern, _, blocks, rng = case(20, 20, 3)
    total, right = pattern.sum_edges(blocks), rng.normal(size=(20, 3))
    expected = pattern.solve(total, right)
    again = pickle.loads(pickle.dumps(pattern)).solve(total, right)
    np.testing.assert_array_equal(again, expected)
    singular = total.copy()
    singular[(pattern.row == 7) | (pattern.column == 7)] = 0.0
    assert pattern.solve(singular, right) is None
    assert pattern.factorise(singular) is None


def test_long_columns_get_fronts_and_short_ones_do_not():
    chain = np.stack([np.arange(200), np.arange(1, 201)], axis=1)
    everyone = np.array([(i, j) for j in range(60) for i in range(j)])
    names = [
        type(find_pattern(n, edges, 3).method).__name__
        for n, edges in ((201, chain), (60, everyone))
    ]
    assert names == ["Simplicial", "Multifrontal"]
