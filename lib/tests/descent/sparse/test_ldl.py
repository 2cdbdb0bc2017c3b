"""SciPy's SuperLU gives what QDLDL gives, and both find an order with all of its fill-in."""

import subprocess
import sys

import numpy as np
import pytest
import robust_slam as rs
from robust_slam.descent.sparse import elimination, ldl, simplicial
from robust_slam.descent.sparse.elimination import find_elimination
from scipy.sparse import csc_array, triu

from .matrices import dense, edge_blocks, random_edges


@pytest.mark.parametrize("seed", range(3))
def test_the_factors_are_those_of_the_matrix_in_their_order(solver, seed):
    rng = np.random.default_rng(seed)
    edges = random_edges(30, 40, rng)
    matrix = dense(30, edges, edge_blocks(len(edges), 2, rng)) + np.eye(60)
    below, diagonal, order = solver(csc_array(triu(matrix)), upper=True).factors()
    unit = below.toarray() + np.eye(60)
    product = unit @ np.diag(diagonal) @ unit.T
    np.testing.assert_allclose(product, matrix[np.ix_(order, order)], rtol=1e-10, atol=1e-9)
    np.testing.assert_array_equal(unit, np.tril(unit))


def test_superlu_refuses_a_diagonal_of_zeros():
    with pytest.raises(RuntimeError, match="pivot"):
        ldl.SuperLU(csc_array(np.array([[0.0, 1.0], [0.0, 0.0]])))


def test_gnc_on_a_graph_in_the_plane_is_the_same_with_both(solver, monkeypatch):
    clean = rs.graphs.manhattan(100, np.random.default_rng(2), closures=60)[0]
    graph, _ = rs.graphs.add_random_closures(clean, 30, np.random.default_rng(3))
    found = rs.solve(graph)
    for module in (elimination, simplicial):
        monkeypatch.setattr(module, "Solver", ldl.Solver)
    expected = rs.solve(graph)
    np.testing.assert_array_equal(found.kept, expected.kept)
    np.testing.assert_allclose(found.poses, expected.poses, rtol=1e-9, atol=1e-9)


def test_where_qdldl_is_missing_scipy_takes_its_place():
    code = (
        "import sys; sys.modules['qdldl'] = None\n"
        "from robust_slam.descent.sparse import ldl, simplicial\n"
        "assert simplicial.Solver is ldl.Solver is ldl.SuperLU"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


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


def test_a_long_drive_with_short_loops_loses_no_fill_in_to_underflow():
    rng = np.random.default_rng(0)
    n, first = 3000, rng.integers(0, 2940, 100)
    drive = np.stack([np.arange(n - 1), np.arange(1, n)], axis=1)
    loops = np.stack([first, first + rng.integers(2, 60, first.size)], axis=1)
    edges = np.concatenate([drive, loops])
    found = find_elimination(n, edges)
    expected = fill(n, edges, found.order)
    np.testing.assert_array_equal(found.filled, [len(later) for later in expected])
