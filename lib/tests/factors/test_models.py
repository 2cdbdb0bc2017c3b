"""Every kind of factor has the residual and the derivatives that it claims, and GTSAM's."""

import numpy as np
import pytest
from robust_slam.factors.equations import FactorEquations
from robust_slam.factors.models import POINT, RANGE, RELATIVE

from ..descent.sparse.matrices import as_dense
from ..worlds import random_poses, slopes
from .made import Twin, everything


@pytest.mark.parametrize("model", [RELATIVE, POINT, RANGE], ids=["relative", "point", "range"])
def test_the_derivatives_are_those_of_the_residual(model, group, seed):
    rng = np.random.default_rng(seed)
    a, b, z = random_poses(group, 1, rng), random_poses(group, 1, rng), random_poses(group, 1, rng)
    z = {RELATIVE: z, POINT: group.translation(z), RANGE: np.ones((1, 1))}[model]
    by_a, by_b = model.jacobians(group, a, b, z)

    def moved(pose, delta):
        return group.compose(pose, group.exp(delta))

    expected = slopes(lambda e: model.residual(group, moved(a, e), b, z)[0], group.DOF)
    np.testing.assert_allclose(by_a[0], expected, atol=1e-8)
    expected = slopes(lambda e: model.residual(group, a, moved(b, e), z)[0], group.DOF)
    np.testing.assert_allclose(by_b[0], expected, atol=1e-8)


def test_a_range_of_nothing_has_a_derivative(group):
    pose = group.identity()[None]
    by_a, by_b = RANGE.jacobians(group, pose, pose, np.ones((1, 1)))
    assert np.linalg.norm(by_a) == np.linalg.norm(by_b) == 1.0


def test_each_factor_has_the_error_of_its_twin_in_gtsam(gtsam, group, seed):
    graph, x = everything(group, seed)
    twin = Twin(gtsam, graph)
    values = twin.values(x)
    theirs = [twin.factors.at(k).error(values) for k in range(twin.factors.size())]
    ours = FactorEquations(graph).norms(x)
    np.testing.assert_allclose(0.5 * ours**2, theirs, rtol=1e-9)


def test_the_normal_equations_are_those_of_gtsam(gtsam, group, seed):
    graph, x = everything(group, seed)
    twin, equations = Twin(gtsam, graph), FactorEquations(graph)
    weights = np.random.default_rng(seed).uniform(size=len(graph.ends))
    hessian, gradient = equations.system(x, weights)
    theirs, downhill = weighted(twin, x, weights)
    np.testing.assert_allclose(gradient[1:], -downhill, atol=1e-9 * np.abs(downhill).max())
    ours = as_dense(equations.pattern, hessian)
    np.testing.assert_allclose(ours, theirs, atol=1e-9 * np.abs(theirs).max())


def weighted(twin, x, weights):
    """GTSAM's Σ w Jᵀ J ``(N D, N D)`` and −Σ w Jᵀ r ``(N, D)`` in our order of coordinates."""
    group, nodes = twin.graph.group, twin.graph.nodes
    size, d = group.DOF, group.DIMENSION
    matrix, right = np.zeros((nodes * size, nodes * size)), np.zeros(nodes * size)
    order = np.arange(size) if twin.plane else np.array([3, 4, 5, 0, 1, 2])
    values = twin.values(x)
    for k, weight in enumerate(weights):
        factor = twin.factors.at(k)
        jacobian, b = factor.linearize(values).jacobian()
        keys = list(factor.keys())
        columns = [node * size + (order if twin.is_pose(node) else np.arange(d)) for node in keys]
        at = np.concatenate(columns)
        matrix[np.ix_(at, at)] += weight * jacobian.T @ jacobian
        right[at] += weight * jacobian.T @ b
    return matrix, right.reshape(nodes, size)
