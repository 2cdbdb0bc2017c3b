"""The polish: derivatives that are derivatives, quadratic convergence, no step upwards."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from robust_slam.certificates import chordal
from robust_slam.certificates.chordal import ChordalProblem
from robust_slam.certificates.newton import descend, polish
from robust_slam.certificates.tangent import stationarity
from robust_slam.descent.undamped import gauss_newton
from robust_slam.errors import NotConverged
from robust_slam.graphs import se2

from tests.lib.worlds import (
    measured,
    random_information,
    refused,
    shaken,
    walked,
)


def loops(group, seed, n=12, noise=0.1):
    """A noisy ring with chords, edges of unequal information, and its true poses."""
    rng = np.random.default_rng(seed)
    steps = 0.4 * rng.normal(size=(n, group.DOF)) + np.eye(group.DOF)[0]
    truth = walked(group, group.exp(steps[1:]))
    edges = [(k, (k + far) % n) for far in (1, 4) for k in range(n)]
    information = random_information(group, len(edges), rng) + 4.0 * np.eye(group.DOF)
    error = noise * rng.normal(size=(len(edges), group.DOF))
    return measured(group, truth, edges, error, information), truth


def test_the_convergence_is_quadratic(group, seed):
    graph, truth = loops(group, seed, noise=0.03)
    problem = ChordalProblem.of(graph)
    optimum = polish(graph, gauss_newton(graph, truth))
    start = chordal.pose_blocks(shaken(group, optimum, 1e-2, np.random.default_rng(0)))
    sizes = [point.stationarity for point in descend(problem, start).history]
    assert sizes[0] > 1e-4
    for before, after in pairwise(sizes):
        assert after <= 100.0 * before**2 + 1e-14


def test_stationarity_has_no_unit_and_does_not_know_where_the_map_lies(group):
    graph, truth = loops(group, 7)
    problem = ChordalProblem.of(graph)
    expected = stationarity(problem, chordal.pose_blocks(truth))
    motion = group.exp(np.full(group.DOF, 1.5))
    moved = chordal.pose_blocks(group.compose(motion, truth))
    assert stationarity(problem, moved) == pytest.approx(expected, rel=1e-9)
    heavier = ChordalProblem.of(graph, np.full(len(graph.edges), 7.0))
    blocks = chordal.pose_blocks(truth)
    assert stationarity(heavier, blocks) == pytest.approx(expected, rel=1e-9)
    in_cm = 100.0
    d = group.DIMENSION
    measured, precision = problem.measured.copy(), problem.precision.copy()
    measured[:, :d, d] *= in_cm
    precision[:, d] /= in_cm**2
    blocks[..., d] *= in_cm
    smaller = ChordalProblem(problem.n, d, problem.edges, measured, precision)
    assert stationarity(smaller, blocks) == pytest.approx(expected, rel=1e-9)


@refused(
    ({"poses": np.zeros((11, 3))}, "poses: the shape"),
    ({"weights": 2.0 - np.arange(24)}, "weights: edge 3 weighs less than 0"),
    ({"tol": -1.0}, "tol is -1"),
    ({"max_iterations": 0}, "max_iterations is 0"),
)
def test_bad_input_is_refused_by_name(wrong, message):
    graph, truth = loops(se2, 8)
    with pytest.raises(ValueError, match=message):
        polish(**({"graph": graph, "poses": truth} | wrong))


def test_too_few_steps_are_an_error(group):
    graph, truth = loops(group, 8)
    far = shaken(group, truth, 1.0, np.random.default_rng(0))
    with pytest.raises(NotConverged, match=r"after 1 steps .* start from better poses"):
        polish(graph, far, max_iterations=1)
