"""Poses and pose graphs in both groups, for the laws that hold everywhere."""

import os
from dataclasses import replace
from itertools import accumulate

import numpy as np
import pytest
from robust_slam.descent.normal_equations import NormalEquations
from robust_slam.files import datasets
from robust_slam.graphs import add_random_closures
from robust_slam.graphs.generate import near_pairs
from robust_slam.graphs.pose_graph import PoseGraph, jacobians, with_closures
from robust_slam.groups import se2, se3
from robust_slam.problems import chain

GROUPS = {"SE(2)": se2, "SE(3)": se3}


def leave_out(reason):
    """Skip a test for want of something on this machine; under STRICT=1 fail instead."""
    if os.environ.get("ROBUST_SLAM_STRICT"):
        pytest.fail(f"STRICT: {reason}", pytrace=False)
    pytest.skip(reason)


def refused(*rows):
    """A table of wrong arguments, each with the message that refuses it."""
    return pytest.mark.parametrize(("wrong", "message"), rows)


def chapter_0(**options):
    """Two steps of odometry and two closures, the second an outlier; the odometry is trusted."""
    trusted = {"trusted": [True, True, False, False]}
    z, sigma = [1.0, 1.0, 2.0, 0.0], [0.1, 0.1, 0.05, 0.05]
    return chain(3, [0, 1, 0, 0], [1, 2, 2, 2], z, sigma, **(trusted | options))


def random_twists(group, count, rng, reach=3.0, turn=2.0):
    """Tangent vectors with positions up to ``reach`` and turns up to ``turn`` an axis."""
    size = [reach] * group.DIMENSION + [turn] * (group.DOF - group.DIMENSION)
    return rng.uniform(-1.0, 1.0, size=(count, group.DOF)) * size


def random_poses(group, count, rng, reach=3.0, turn=1.5):
    return group.exp(random_twists(group, count, rng, reach, turn))


def random_information(group, count, rng):
    root = rng.normal(size=(count, group.DOF, group.DOF))
    return root @ np.swapaxes(root, 1, 2) + np.eye(group.DOF)


def walked(group, steps):
    """The poses from the identity on, one step after the other."""
    return np.array(list(accumulate(steps, group.compose, initial=group.identity())))


def shaken(group, poses, size, rng):
    """Poses moved at random on the right, all but pose 0."""
    twists = size * rng.normal(size=(len(poses), group.DOF))
    twists[0] = 0.0
    return group.compose(poses, group.exp(twists))


def measured(group, poses, edges, error, information):
    """The graph that measures the poses with these errors; its first n − 1 edges are odometry."""
    n, edges = len(poses), np.asarray(edges)
    z = group.compose(group.between(*poses[edges.T]), group.exp(error))
    information = np.broadcast_to(information, (len(edges), group.DOF, group.DOF))
    return PoseGraph(n, edges, z, information, np.arange(len(edges)) < n - 1)


def random_graph(seed, group=se2, n=6, m=9, residual=1.0):
    """Poses and a connected graph whose residuals have about the given size."""
    rng = np.random.default_rng(seed)
    poses = random_poses(group, n, rng)
    tree = [(int(rng.integers(k)), k) for k in range(1, n)]
    loops = [tuple(rng.permutation(n)[:2]) for _ in range(m - n + 1)]
    error = residual * rng.uniform(-1.0, 1.0, size=(m, group.DOF))
    information = random_information(group, m, rng)
    return poses, measured(group, poses, tree + loops, error, information)


def about_z(group, angle):
    """Rotations ``(…, d, d)`` by ``angle`` in the plane, or about the z axis."""
    return group.rotation(group.exp(np.multiply.outer(angle, np.eye(group.DOF)[-1])))


def unit_information(group):
    """Information for which κ = τ = 1: in SE(3) κ = 3 / (2 · 3/2)."""
    return np.diag([1.0] * 3 + [2.0] * (group.DOF - 3))


def ring(group, n, seed, noise, chords=0, reach=1.0):
    """A noisy ring of poses that all look the same way; its truth; and the twisted state."""
    rng = np.random.default_rng(seed)
    angle = 2.0 * np.pi * np.arange(n) / n
    place = np.zeros((n, group.DIMENSION))
    place[:, 0], place[:, 1] = reach * np.cos(angle), reach * np.sin(angle)
    truth = group.from_parts(about_z(group, np.zeros(n)), place)
    edges = [(k, (k + 1) % n) for k in range(n)] + [(k, k + 2) for k in range(chords)]
    error = noise * rng.normal(size=(len(edges), group.DOF))
    graph = measured(group, truth, edges, error, unit_information(group))
    return graph, truth, group.from_parts(about_z(group, angle), place)


def chain_with_closures(group, seed, n=12, closures=10, noise=0.0, odometry=True):
    """Poses, the first not at the identity, and a chain over them with closures both ways."""
    rng = np.random.default_rng(seed)
    poses = random_poses(group, n, rng, reach=5.0)
    edges = [(k, k + 1) for k in range(n - 1)]
    edges += [tuple(rng.permutation(n)[:2]) for _ in range(closures)]
    error = noise * random_twists(group, len(edges), rng, 1.7, 0.35)
    place, turn = rng.uniform(1.0, 50.0, size=(2, len(edges)))
    entries = np.repeat([place, turn], [group.DIMENSION, group.DOF - group.DIMENSION], axis=0)
    graph = measured(group, poses, edges, error, entries.T[:, None] * np.eye(group.DOF))
    return poses, replace(graph, is_odometry=graph.is_odometry & odometry)


def curving_walk(group, seed, n=16, closures=8, outliers=3):
    """A walk with closures, the last of which say "the same place"; and its true poses."""
    rng = np.random.default_rng(seed)
    sigma = np.where(np.arange(group.DOF) < group.DIMENSION, 0.05, 0.02)
    ahead = np.eye(group.DOF)[0]
    truth = walked(group, group.exp(ahead + 0.3 * rng.normal(size=(n - 1, group.DOF))))
    pairs = np.array([(i, j) for i in range(n) for j in range(i + 3, n)])
    pairs = pairs[rng.choice(len(pairs), closures + outliers, replace=False)]
    edges = [*((k, k + 1) for k in range(n - 1)), *pairs[:closures]]
    noise = sigma * rng.normal(size=(len(edges) + outliers, group.DOF))
    inliers = measured(group, truth, edges, noise[outliers:], np.diag(sigma**-2))
    same = group.exp(noise[:outliers])
    return with_closures(inliers, pairs[closures:], same, inliers.information[0]), truth


def reweighted(graph, weights):
    """The graph with the information of each edge multiplied by its weight."""
    return replace(graph, information=weights[:, None, None] * graph.information)


def with_outliers(make, n, seed, count, **options):
    """A generated graph with wrong closures, which they are, the true poses, the graph before."""
    rng = np.random.default_rng(seed)
    clean, truth = make(n, rng, **options)
    graph, is_outlier = add_random_closures(clean, count, rng, poses=truth)
    return graph, is_outlier, truth, clean


def slipped(graph, steps, metres=3.0, radians=0.6):
    """The graph where the odometry at ``steps`` is off, though it claims what it did."""
    group, measurement, at = graph.group, graph.measurement.copy(), list(steps)
    error = np.zeros(group.DOF)
    error[[0, -1]] = metres, radians
    measurement[at] = group.compose(measurement[at], group.exp(error))
    return replace(graph, measurement=measurement)


def public_graph(name, load=datasets.load):
    """A public graph, or no test where its file is not on this machine."""
    try:
        return load(name)
    except datasets.DatasetMissing as missing:
        leave_out(str(missing))


def perturbed(group, poses, k, delta):
    """Poses with number ``k`` moved on the right by Exp(delta)."""
    moved = poses.copy()
    moved[k] = group.compose(poses[k], group.exp(delta))
    return moved


def slopes(function, size, h=1e-6):
    """The derivatives of a function at 0, one column for each of ``size`` unknowns."""
    return np.stack([(function(h * e) - function(-h * e)) / (2 * h) for e in np.eye(size)], -1)


def dense_jacobian(graph, poses):
    """The derivatives of all residuals by all poses, ``(m, DOF, n, DOF)``."""
    m, dof = len(graph.edges), graph.group.DOF
    rows = np.zeros((m, dof, graph.n, dof))
    for pose, block in zip(graph.edges.T, jacobians(graph, poses), strict=True):
        rows[np.arange(m), :, pose] += block
    return rows


def gradient(graph, poses, weights=None):
    """The gradient of the cost that Gauss–Newton takes, ``(n − 1, DOF)``."""
    weights = np.ones(len(graph.edges)) if weights is None else weights
    equations = NormalEquations(graph)
    return equations.at(poses, weights).system[1][1:]


def cost_never_rises(result, tolerance=1e-10):
    """Whether no step of a history costs more than the one before, up to rounding."""
    costs = np.array([step.cost for step in result.history])
    return np.all(np.diff(costs) <= tolerance * (1.0 + np.abs(costs[:-1])))


def assert_same_poses(group, a, b, atol=1e-9):
    np.testing.assert_allclose(group.translation(a), group.translation(b), atol=atol)
    np.testing.assert_allclose(group.rotation(a), group.rotation(b), atol=atol)


def assert_rotations(matrices):
    unit = np.swapaxes(matrices, -1, -2) @ matrices
    d = matrices.shape[-1]
    np.testing.assert_allclose(unit, np.broadcast_to(np.eye(d), unit.shape), atol=1e-12)
    if matrices.shape[-2] == d:
        np.testing.assert_allclose(np.linalg.det(matrices), 1.0, atol=1e-12)


def turned(graph, chosen):
    """The same graph, its ``chosen`` edges written from j to i."""
    group, edges, z = graph.group, graph.edges.copy(), graph.measurement.copy()
    onto = np.linalg.inv(group.adjoint(z[chosen]))
    information = graph.information.copy()
    moved = np.swapaxes(onto, 1, 2) @ information[chosen] @ onto
    information[chosen] = 0.5 * (moved + np.swapaxes(moved, 1, 2))
    edges[chosen], z[chosen] = edges[chosen][:, ::-1], group.inverse(z[chosen])
    return PoseGraph(graph.n, edges, z, information, graph.is_odometry)


def renumbered(graph, first):
    """The same graph with pose ``first`` as pose 0, as a FIX line makes it, and the numbers."""
    number = np.arange(graph.n) + (np.arange(graph.n) < first)
    number[first] = 0
    edges = number[graph.edges]
    made = PoseGraph(graph.n, edges, graph.measurement, graph.information, graph.is_odometry)
    return made, number


AHEAD = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


def building(n, rng, closures=None, deviation=(0.001, 0.003)):
    """A drive through corridors of 6 m whose edges know much across, little along, as lasers do.

    Across a corridor positions deviate by up to 30 times ``deviation`` (m, rad), along it by up to
    30 times that, and rotations by up to 30 times the second.
    """
    side, at, facing, left = 6.0 * max(1, round(np.sqrt(n / 150.0))), np.zeros(2), 0, 6.0
    truth = np.zeros((n, 3))
    for k in range(1, n):
        if left == 0.0:
            turns = (facing + np.array([*rng.permutation([0, 1, 3]), 2])) % 4
            ends = at + 6.0 * AHEAD[turns]
            facing = turns[np.argmax(np.all((ends > -0.1) & (ends < side + 0.1), axis=1))]
        at, left = at + 0.5 * AHEAD[facing], (left or 6.0) - 0.5
        truth[k] = [*at, se2.wrap(facing * np.pi / 2.0)]
    pairs = rng.permutation(near_pairs(truth[:, :2], 1.0))[: closures or n // 15]
    edges = np.concatenate([np.stack([np.arange(n - 1), np.arange(1, n)], axis=1), pairs])
    odometry = np.arange(len(edges)) < n - 1
    across, longer, turned = 30.0 ** rng.random((3, len(edges)))
    root = np.zeros((len(edges), 3, 3))
    tilt = np.pad(0.2 * rng.normal(size=(len(edges), 1)), ((0, 0), (2, 0)))
    root[:, :2, :2], root[:, 2, 2] = se2.rotation(tilt), 1.0
    sigma = np.column_stack([across * longer, across, turned]) * [deviation[0], *deviation]
    root *= np.where(odometry, 1.0, 3.0)[:, None, None] * sigma[:, None, :]
    drawn = (root @ rng.normal(size=(len(edges), 3, 1)))[..., 0]
    true = se2.between(truth[edges[:, 0]], truth[edges[:, 1]])
    information = np.linalg.inv(root @ np.swapaxes(root, 1, 2))
    information = 0.5 * (information + np.swapaxes(information, 1, 2))
    return PoseGraph(n, edges, se2.compose(true, se2.exp(drawn)), information, odometry), truth
