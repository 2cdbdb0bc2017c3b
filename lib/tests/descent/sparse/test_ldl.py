"""SciPy's SuperLU gives what QDLDL gives."""

import subprocess
import sys

import numpy as np
import pytest
import robust_slam as rs
from robust_slam.descent.sparse import elimination, ldl, simplicial
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


def test_a_negative_pivot_is_kept_and_not_moved(solver):
    matrix = csc_array(np.array([[2.0, 5.0], [0.0, 2.0]]))
    _, diagonal, _ = solver(matrix, upper=True).factors()
    np.testing.assert_allclose(np.sort(diagonal), [-10.5, 2.0])


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
