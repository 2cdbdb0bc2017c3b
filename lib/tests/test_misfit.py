"""What neither noise nor outliers explain: steps that slipped, and maps of weak support."""

from dataclasses import replace

import numpy as np
import pytest
from robust_slam.descent import gauss_newton
from robust_slam.graphs import PoseGraph, add_random_closures, ate, manhattan, sphere
from robust_slam.graphs.outliers import add_aliased_closures
from robust_slam.groups import se2
from robust_slam.solver import Support, solve
from robust_slam.solver.misfit import find_misfit

from .worlds import slipped

pytestmark = pytest.mark.long


def moved(graph, edges, sizes, rng):
    """The graph whose ``edges`` measure what is off by so many deviations in each direction."""
    root = np.linalg.cholesky(np.linalg.inv(graph.information[edges]))
    signs = rng.choice([-1.0, 1.0], (len(edges), graph.group.DOF))
    error = (root @ (np.asarray(sizes)[:, None] * signs)[..., None])[..., 0]
    measurement = graph.measurement.copy()
    measurement[edges] = graph.group.compose(measurement[edges], graph.group.exp(error))
    return replace(graph, measurement=measurement)


@pytest.mark.parametrize("make", [manhattan, sphere])
def test_a_step_that_is_off_is_named_and_noise_is_not(make, seed):
    graph, truth = make(100, seed, closures=45)
    every = np.ones(len(graph.edges), dtype=bool)

    def misfit(graph):
        return find_misfit(graph, gauss_newton(graph, truth), every, graph.is_odometry, 3.0, 1e-3)

    assert not misfit(graph)
    found = misfit(moved(graph, [50], [12.0], np.random.default_rng(seed)))
    assert abs(found.step - 50) <= 3
    assert not found.closures.size
    assert misfit(moved(graph, [50], [50.0], np.random.default_rng(seed))).bent


def test_rejected_closures_are_too_many_where_outliers_would_not_come_close(seed):
    rng = np.random.default_rng(seed)
    graph, truth = manhattan(100, rng, closures=60)
    closures = np.flatnonzero(~graph.is_odometry)
    kept = graph.is_odometry | (np.arange(len(graph.edges)) < closures[40])

    def close(sizes):
        wrong = moved(graph, closures[40:], sizes, rng)
        return find_misfit(wrong, truth, kept, graph.is_odometry, 3.4, 1e-3).closures

    np.testing.assert_array_equal(close(rng.uniform(4.0, 15.0, 20)), closures[40:])
    assert not close(rng.uniform(4.0, 190.0, 20)).size


def noisy(seed):
    """A sphere where a tenth of the odometry has five times the noise that it claims."""
    rng = np.random.default_rng(seed)
    graph, truth = sphere(80, rng, closures=45)
    steps = rng.choice(79, 8, replace=False)
    return moved(graph, steps, 5.0 * np.abs(rng.normal(size=8)), rng), truth


def test_a_map_that_noise_does_not_explain_says_why_and_is_doubted_where_it_is_bent():
    answer = solve(noisy(0)[0])
    assert answer.misfit.step is not None
    assert answer.support is Support.UNIQUE
    assert "no pose would be elsewhere by more than closures tolerate" in answer.summary()
    both = replace(answer, misfit=replace(answer.misfit, closures=answer.rejected, bent=True))
    why = "\n".join(both.notes())
    assert "slipped there or nearby, which bends the map" in why
    assert "are closer to the map than outliers would be" in why
    assert "Odometry alone" not in why


@pytest.mark.parametrize("world", [10, 12, 13])
def test_a_map_is_doubted_where_a_few_steps_have_far_more_noise(world):
    graph, truth = noisy(world)
    answer = solve(graph)
    assert ate(answer.poses, truth) < 0.4
    assert answer.support is Support.WEAK


@pytest.mark.parametrize("make", [manhattan, sphere])
def test_slips_are_found_and_the_map_is_right_without_them(make, seed):
    rng = np.random.default_rng(seed)
    graph, truth = make(100, rng, closures=45)
    graph, is_outlier = add_random_closures(graph, 20, rng)
    answer = solve(slipped(graph, (30, 75)))
    assert answer.slips.tolist() == [30, 75]
    assert ate(answer.poses, truth) < 0.4
    assert not np.any(answer.kept & is_outlier)
    assert answer.support is Support.WEAK
    assert "slipped at 2 steps: 30-31, 75-76" in answer.summary()


def test_a_run_of_closures_that_a_slip_cuts_is_no_single_place():
    """Two laps of a square: the robot turns at a corner, as a usual step does, and slips there."""
    rng, sigma = np.random.default_rng(0), np.array([0.02, 0.02, 0.01])
    steps = np.tile([[0.5, 0.0, 0.0]] * 7 + [[0.5, 0.0, np.pi / 2]], (8, 1))
    walked = se2.compose(steps, se2.exp(sigma * rng.normal(size=steps.shape)))
    walked[40] = se2.compose(walked[40], [0.0, 0.0, np.pi / 2])
    back = np.arange(0, 33, 4)
    seen = se2.exp(sigma * rng.normal(size=(back.size, 3)))
    graph = PoseGraph(
        65,
        [[k, k + 1] for k in range(64)] + [[k, k + 32] for k in back],
        np.concatenate([walked, seen]),
        np.diag(sigma**-2.0),
    )
    answer = solve(graph)
    assert answer.slips.tolist() == [40] and np.all(answer.kept[64:])


@pytest.mark.parametrize("origin", [[0.0, 0.0, 0.0], [8.0, 8.0, 1.0]])
def test_a_tracker_that_reports_one_pose_again_and_again_is_named(origin):
    """It may be near the drive, so that the way there and back is no detour."""
    graph, truth = manhattan(100, 0, closures=45)
    told = truth.copy()
    told[60:63] = origin
    measurement = graph.measurement.copy()
    measurement[58:63] = graph.group.between(told[58:63], told[59:64])
    answer = solve(replace(graph, measurement=measurement))
    assert answer.support is Support.WEAK
    assert answer.slips.size or answer.misfit.step in (59, 62)


def test_an_odometry_that_did_not_slip_is_trusted(seed):
    rng = np.random.default_rng(seed)
    graph, _ = add_random_closures(manhattan(100, rng, closures=45)[0], 60, rng)
    answer = solve(graph)
    assert answer.slips.size == 0
    assert answer.support is Support.UNIQUE


def test_closures_of_one_place_are_no_slip():
    """The robot takes one place for another: its five closures agree, as after a slip."""
    rng = np.random.default_rng(0)
    graph, truth = manhattan(100, rng, closures=4)
    graph, _ = add_aliased_closures(graph, 1, rng, size=5, poses=truth)
    answer = solve(graph)
    assert answer.slips.size == 0
