"""Compiled code gives what numpy gives, which is the reference, and is chosen by size."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys

import numpy as np
import pytest
from robust_slam.descent import normal_equations
from robust_slam.descent.damped import levenberg_marquardt
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.descent.sparse import choice
from robust_slam.descent.start import chordal
from robust_slam.descent.undamped import gauss_newton
from robust_slam.estimators import gnc
from robust_slam.graphs import add_random_closures, spanning_tree
from robust_slam.graphs.generate import manhattan, sphere
from robust_slam.graphs.pose_graph import PoseGraph

from tests.lib.descent.sparse.matrices import need_numba
from tests.lib.worlds import assert_same_poses, random_graph

pytestmark = [pytest.mark.long, pytest.mark.rest]


@pytest.fixture(autouse=True)
def solver():
    """Whether QDLDL or SciPy orders the poses is no question here."""


@pytest.fixture
def both():
    """Normal equations of a graph, by numpy and compiled."""
    need_numba()
    return lambda graph: [NormalEquations(graph, compiled=which) for which in (False, True)]


@pytest.fixture
def compiled_from(monkeypatch):
    """Sets the number of edges from which kernels are compiled."""
    return lambda edges: monkeypatch.setenv(choice.COMPILED_FROM, str(edges))


@pytest.mark.parametrize("make", [manhattan, sphere], ids=["plane", "space"])
@pytest.mark.parametrize("descend", [gauss_newton, levenberg_marquardt])
def test_descents_end_in_the_same_minimum(compiled_from, make, descend):
    """Long where Numba compiles the kernels; the next run finds what this one has kept."""
    need_numba()
    graph, _ = make(200, np.random.default_rng(0), closures=100)
    by_numpy = descend(graph, chordal(graph))
    compiled_from(0)
    assert_same_poses(graph.group, descend(graph, chordal(graph)), by_numpy, 1e-6)


@pytest.mark.parametrize("make", [manhattan, sphere], ids=["plane", "space"])
def test_gnc_rejects_the_same_closures_and_keeps_to_the_compiled_way(
    compiled_from, monkeypatch, make
):
    need_numba()
    clean, _ = make(150, np.random.default_rng(1), closures=60)
    graph, _ = add_random_closures(clean, 40, np.random.default_rng(2))
    by_numpy = gnc(graph, 4.0)
    compiled_from(len(graph.edges))
    # With fewer edges the rule alone would choose numpy.
    monkeypatch.setattr(normal_equations, "FULL_SHARE", 0.999)
    compiled = gnc(graph, 4.0)
    np.testing.assert_array_equal(compiled.weights, by_numpy.weights)
    assert_same_poses(graph.group, compiled.x, by_numpy.x, 1e-6)
    equations = NormalEquations(graph)
    assert equations.compiled and equations.restricted(compiled.weights)[0].compiled


def test_compiled_code_is_not_given_too_few_numbers(both, group):
    _, graph = random_graph(0, group)
    compiled = both(graph)[1].pattern
    blocks = np.zeros((compiled.row.size - 1, group.DOF, group.DOF))
    with pytest.raises(ValueError, match="blocks: the shape"):
        compiled.solve(blocks, np.zeros((graph.n, group.DOF)))
    with pytest.raises(ValueError, match="blocks: the shape"):
        compiled.factorise(blocks)


def test_equations_can_be_pickled(both, group):
    poses, graph = random_graph(4, group)
    ones = np.ones(len(graph.edges))
    for each in both(graph):
        again = pickle.loads(pickle.dumps(each))
        steps = (one.step(one.at(poses, ones)) for one in (each, again))
        np.testing.assert_array_equal(*steps)


def test_large_graphs_are_compiled_and_small_ones_are_not(compiled_from, monkeypatch):
    monkeypatch.delenv(choice.COMPILED_FROM, raising=False)
    monkeypatch.setattr(choice, "has_numba", lambda: True)
    chosen = [choice.use_compiled(edges) for edges in (1, choice.LARGE - 1, choice.LARGE)]
    assert chosen == [False, False, True]
    compiled_from(10)
    assert [choice.use_compiled(edges) for edges in (9, 10)] == [False, True]


def test_a_number_of_edges_that_is_none_is_refused(compiled_from):
    compiled_from("always")
    with pytest.raises(ValueError, match="ROBUST_SLAM_COMPILED_FROM is 'always'"):
        choice.use_compiled(1)


def test_without_numba_all_graphs_are_solved_by_numpy(compiled_from, monkeypatch):
    monkeypatch.setattr(choice, "has_numba", lambda: False)
    compiled_from(0)
    _, graph = random_graph(0)
    assert isinstance(graph, PoseGraph) and not NormalEquations(graph).compiled
    gauss_newton(graph, spanning_tree(graph))


SMALL = """
import sys
import numpy as np
import robust_slam as rs
rs.solve(rs.graphs.manhattan(100, np.random.default_rng(0), closures=20)[0])
assert "numba" not in sys.modules
"""


def test_a_small_graph_does_not_load_numba():
    environment = {k: v for k, v in os.environ.items() if k != choice.COMPILED_FROM}
    subprocess.run([sys.executable, "-c", SMALL], check=True, env=environment)
