"""Graduated non-convexity: its formulas by law, its schedules by the numbers, its outcomes.

The two data sets are A = (0, 0, 0, 10) and B = (−0.2, 0.1, 0.4, 10), both with c = 2 and
unit deviations, small enough to follow by hand. For A the unweighted mean is 2.5 and the
largest residual 7.5, so μ starts at 4/108.5 (TLS) and 28.125 (GM).
"""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators import graduation as g
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import GncGm, GncTls, gnc, start_mu, strides
from robust_slam.estimators.loop import reweight
from robust_slam.estimators.result import StopReason
from robust_slam.estimators.reweighting import irls
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs.generate import circle, manhattan
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.outliers import add_random_closures
from robust_slam.problems import LocationProblem, PoseGraphProblem, chain

A, B = (0.0, 0.0, 0.0, 10.0), (-0.2, 0.1, 0.4, 10.0)
MUS = (1e-3, 0.05, 0.7, 1.0, 3.0, 200.0)
SURROGATES = {
    "tls": (g.tls_surrogate, g.tls_weight, g.tls_process),
    "gm": (g.gm_surrogate, g.gm_weight, g.gm_process),
}
each_surrogate = pytest.mark.parametrize("kind", SURROGATES)
each_mu = pytest.mark.parametrize("mu", MUS)
U = np.linspace(-12.0, 12.0, 481)


def knees(c, mu):
    return c * np.sqrt(mu / (mu + 1.0)), c * np.sqrt((mu + 1.0) / mu)


@each_surrogate
@each_mu
def test_the_weight_is_influence_over_residual(kind, mu):
    surrogate, weight, _ = SURROGATES[kind]
    u, h = U[np.abs(U) > 0.1], 1e-6
    if kind == "tls":
        away = [np.abs(np.abs(u) - knee) > 10.0 * h for knee in knees(2.0, mu)]
        u = u[np.logical_and(*away)]
    slope = (surrogate(u + h, 2.0, mu) - surrogate(u - h, 2.0, mu)) / (2.0 * h)
    np.testing.assert_allclose(weight(u, 2.0, mu), slope / u, atol=1e-7)


@each_surrogate
@each_mu
def test_the_surrogate_is_the_least_of_weighted_square_and_price(kind, mu):
    """Black–Rangarajan duality: no weight does better than the surrogate's own."""
    surrogate, weight, process = SURROGATES[kind]
    w = np.linspace(0.0, 1.0, 1001)[:, None]
    paid = 0.5 * w * U**2 + process(w, 2.0, mu)
    value = surrogate(U, 2.0, mu)
    assert np.all(paid >= value - 1e-9)
    best = weight(U, 2.0, mu)
    np.testing.assert_allclose(0.5 * best * U**2 + process(best, 2.0, mu), value, atol=1e-11)


@each_surrogate
@each_mu
def test_a_surrogate_is_even_and_a_square_near_0(kind, mu):
    surrogate, weight, process = SURROGATES[kind]
    np.testing.assert_array_equal(surrogate(U, 2.0, mu), surrogate(-U, 2.0, mu))
    assert weight(0.0, 2.0, mu) == 1.0
    assert process(1.0, 2.0, mu) == 0.0
    small = 1e-4 * np.sqrt(mu / (mu + 1.0))
    np.testing.assert_allclose(surrogate(small, 2.0, mu), 0.5 * small**2, rtol=1e-6)


@each_surrogate
@each_mu
def test_surrogate_and_weight_keep_the_shape_that_they_get(kind, mu):
    surrogate, weight, process = SURROGATES[kind]
    for function in (surrogate, weight):
        assert function(3, 2.0, mu).shape == ()
        assert function([1, -2, 3], 2.0, mu).shape == (3,)
        assert function(np.ones((2, 3)), 2.0, mu).shape == (2, 3)
    assert process(np.full((2, 3), 0.5), 2.0, mu).shape == (2, 3)


@each_mu
def test_tls_has_no_jump_at_its_knees(mu):
    for knee, level in zip(knees(2.0, mu), (1.0, 0.0), strict=True):
        sides = np.array([knee * (1.0 - 1e-9), knee * (1.0 + 1e-9)])
        assert np.ptp(g.tls_surrogate(sides, 2.0, mu)) < 1e-7
        np.testing.assert_allclose(g.tls_weight(sides, 2.0, mu), level, atol=1e-5)


@each_mu
def test_between_the_knees_the_curvature_of_tls_is_minus_mu(mu):
    low, high = knees(2.0, mu)
    u, h = 0.5 * (low + high), 1e-3 * (high - low)
    rise = np.diff(g.tls_surrogate([u - h, u, u + h], 2.0, mu), 2)[0] / h**2
    assert rise == pytest.approx(-mu, rel=1e-5)


def test_the_surrogates_end_at_their_kernels():
    away = U[np.abs(np.abs(U) - 2.0) > 1e-3]
    np.testing.assert_allclose(g.tls_surrogate(away, 2.0, 1e7), kernels.tls(2.0).rho(away))
    np.testing.assert_allclose(g.tls_weight(away, 2.0, 1e7), kernels.tls(2.0).weight(away))
    np.testing.assert_allclose(g.gm_surrogate(U, 2.0, 1.0), kernels.geman_mcclure(2.0).rho(U))
    np.testing.assert_allclose(g.gm_weight(U, 2.0, 1.0), kernels.geman_mcclure(2.0).weight(U))
    np.testing.assert_allclose(g.gm_surrogate(U, 2.0, 1e9), 0.5 * U**2, rtol=1e-6)


@pytest.mark.parametrize("mu", [1e100, 1e200, 1e300])
def test_a_huge_mu_is_the_kernel_and_does_not_overflow(mu):
    u, truncated = np.array([0.0, 0.5, 1.9, 2.1, 1e10, np.inf]), kernels.tls(2.0)
    with np.errstate(all="raise", under="ignore"):
        np.testing.assert_array_equal(g.tls_weight(u, 2.0, mu), truncated.weight(u))
        np.testing.assert_array_equal(g.tls_surrogate(u, 2.0, mu), truncated.rho(u))


def test_the_first_mu_by_hand():
    """With u = 7.5, c = 2: 4/(2·56.25 − 4) = 8/217 and 2·56.25/4 = 28.125."""
    assert start_mu(7.5, 2.0) == pytest.approx(8.0 / 217.0, rel=1e-12)
    assert start_mu(7.5, 2.0, "gm") == pytest.approx(28.125, rel=1e-12)
    assert start_mu(1.0, 2.0, "gm") == 0.5
    assert GncGm(2.0).start(np.array([1.0])) == 1.0


def test_no_mu_rejects_anything_when_twice_the_square_is_within_c():
    """2u² = c² at u = 2, c² = 8; both sides of it differ by one part in 10⁹."""
    c = np.sqrt(8.0)
    assert start_mu(2.0 * (1.0 - 1e-9), c) == np.inf
    assert 1e7 < start_mu(2.0 * (1.0 + 1e-9), c) < np.inf
    assert start_mu(0.0, c) == np.inf


@pytest.mark.parametrize(
    ("u_max", "c"), [(1e200, 1.0), (1.0, 1e-200), (1.0, 1e-320), (np.inf, 1.0)]
)
def test_residuals_beyond_all_measure_still_have_a_first_mu(u_max, c):
    assert 0.0 < start_mu(u_max, c) < 1e-300
    assert 1e300 < start_mu(u_max, c, "gm") < np.inf


def test_a_tiny_scale_is_an_outcome_and_no_error():
    assert gnc(LocationProblem([0.0, 0.1, 0.0, 10.0]), 1e-12).x == 0.0
    assert gnc(LocationProblem(A), 1e-200).stop is StopReason.ALL_REJECTED


@pytest.mark.parametrize("largest", [2.0, 7.5, 1e3])
def test_the_first_mu_puts_the_upper_knee_above_every_residual(largest):
    mu = GncTls(2.0).start(np.array([0.3, largest]))
    assert knees(2.0, mu)[1] ** 2 == pytest.approx(2.0 * largest**2, rel=1e-12)
    assert g.tls_weight(largest, 2.0, mu) > 0.0
    mu = GncGm(2.0).start(np.array([0.3, largest]))
    assert 4.0 / 9.0 <= g.gm_weight(largest, 2.0, mu) <= 1.0


def test_the_first_mus_of_data_a():
    norms = np.array([2.5, 2.5, 2.5, 7.5])
    assert GncTls(2.0).start(norms) == pytest.approx(8.0 / 217.0, rel=1e-12)
    assert GncGm(2.0).start(norms) == pytest.approx(28.125, rel=1e-12)


def assert_schedule(result, rows, atol):
    """Compare (μ, weights…, x) of every solve; the last rows of GM may follow."""
    steps = result.history[1 : len(rows) + 1]
    for step, (mu, *weights, x) in zip(steps, rows, strict=True):
        assert step.mu == pytest.approx(mu, abs=atol)
        np.testing.assert_allclose(step.weights, weights, atol=atol)
        assert step.x == pytest.approx(x, abs=atol)


def test_every_row_of_tls_on_data_a():
    w_in, w_out = (24.0 * np.sqrt(2.0) - 8.0) / 217.0, (8.0 * np.sqrt(2.0) - 8.0) / 217.0
    rows = [
        (8.0 / 217.0, w_in, w_in, w_in, w_out, 20.0 / 23.0 - 15.0 * np.sqrt(2.0) / 46.0),
        (1.4 * 8.0 / 217.0, 1.0, 1.0, 1.0, 0.0, 0.0),
    ]
    result = gnc(LocationProblem(A), 2.0)
    assert len(result.history) == 3
    assert_schedule(result, rows, 1e-12)
    assert result.stop is StopReason.BINARY_WEIGHTS


def test_every_row_of_tls_on_data_a_from_mu_1():
    w_in = 0.8 * np.sqrt(2.0) - 1.0
    rows = [(1.0, w_in, w_in, w_in, 0.0, 0.0), (1.5, 1.0, 1.0, 1.0, 0.0, 0.0)]
    result = gnc(LocationProblem(A), 2.0, factor=1.5, mu0=1.0)
    assert len(result.history) == 3
    assert_schedule(result, rows, 1e-12)


def test_every_row_of_tls_on_data_b():
    rows = [
        (0.037643, 0.104797, 0.122063, 0.144091, 0.015592, 0.529839),
        (0.052700, 0.592749, 1.0, 1.0, 0.0, 0.147122),
        (0.073780, 1.0, 1.0, 1.0, 0.0, 0.1),
    ]
    result = gnc(LocationProblem(B), 2.0)
    assert len(result.history) == 4
    assert_schedule(result, rows, 6e-7)
    rows = [
        (1.0, 0.019253, 0.142799, 0.300426, 0.0, 0.282391),
        (1.5, 1.0, 1.0, 1.0, 0.0, 0.1),
    ]
    assert_schedule(gnc(LocationProblem(B), 2.0, factor=1.5, mu0=1.0), rows, 6e-7)


GM_A = """
28.125000 0.897507 0.444444 1.416797
20.089286 0.951852 0.272174 0.870197
14.349490 0.974127 0.166298 0.538413
10.249636 0.986007 0.098669 0.322797
7.321168 0.992922 0.056747 0.186944
5.229406 0.996667 0.031847 0.105389
3.735290 0.998515 0.017531 0.058183
2.668064 0.999366 0.009497 0.031577
1.905760 0.999738 0.005076 0.016897
1.361257 0.999895 0.002684 0.008939
1.000000 0.999960 0.001484 0.004946
"""


def test_every_row_of_gm_on_data_a():
    table = np.array([line.split() for line in GM_A.strip().splitlines()], dtype=float)
    rows = [(mu, w_in, w_in, w_in, w_out, x) for mu, w_in, w_out, x in table]
    result = gnc(LocationProblem(A), 2.0, "gm")
    assert len(result.history) == len(rows) + 1
    assert_schedule(result, rows, 6e-7)
    assert result.stop is StopReason.CONVERGED


def test_gm_by_hand_with_another_factor():
    x = [step.x for step in gnc(LocationProblem(A), 2.0, "gm", factor=1.5).history[1:]]
    expected = [1.416797, 0.820896, 0.453347, 0.236291, 0.118305, 0.057619, 0.027448]
    np.testing.assert_allclose(x, [*expected, 0.012839, 0.005920, 0.004940], atol=6e-7)


GM_B = """
27.565312 0.873700 0.897507 0.919415 0.444444 1.507853
19.689509 0.929852 0.951506 0.969546 0.272494 0.967518
14.063935 0.953245 0.973772 0.988647 0.166561 0.638435
10.045668 0.965908 0.985725 0.997176 0.098826 0.424105
7.175477 0.973401 0.992720 0.999960 0.056829 0.288750
5.125341 0.977098 0.996533 0.998794 0.031887 0.207241
3.660958 0.977729 0.998431 0.994945 0.017549 0.159860
2.614970 0.975691 0.999315 0.989064 0.009505 0.132994
1.867836 0.970965 0.999709 0.981186 0.005080 0.118044
1.334168 0.963143 0.999878 0.970859 0.002685 0.109840
1.000000 0.953674 0.999952 0.959196 0.001543 0.105812
"""


def test_every_row_of_gm_on_data_b():
    table = np.array([line.split() for line in GM_B.strip().splitlines()], dtype=float)
    assert_schedule(gnc(LocationProblem(B), 2.0, "gm"), [tuple(row) for row in table], 6e-7)


@pytest.mark.parametrize(("z", "fixed"), [(A, 0.004937963159), (B, 0.105555126205)])
def test_gm_ends_near_a_minimum_and_irls_goes_on_to_it(z, fixed):
    problem, kernel = LocationProblem(z), kernels.geman_mcclure(2.0)
    result = gnc(problem, 2.0, "gm")
    onward = irls(problem, kernel, result.x)
    assert 1e-6 < abs(result.x - fixed) < 1e-3
    assert result.cost == pytest.approx(kernel.rho(np.array(z) - result.x).sum())
    assert onward.x == pytest.approx(fixed, abs=1e-10)
    assert onward.cost < result.cost


def test_the_data_of_the_irls_chapter_lose_their_outlier():
    z = [0.1, -0.2, 0.15, -0.1, 5.0]
    steps = gnc(LocationProblem(z), 1.0).history[1:]
    np.testing.assert_allclose(
        [step.x for step in steps], [0.117789, 0.007702, -0.0125], atol=6e-7
    )
    assert steps[-1].weights.tolist() == [1.0, 1.0, 1.0, 1.0, 0.0]
    assert gnc(LocationProblem(z, 0.3), 1.0).x == pytest.approx(-0.0125, abs=1e-9)


def test_the_data_of_the_irls_chapter_with_their_own_deviation():
    problem = LocationProblem([0.1, -0.2, 0.15, -0.1, 5.0], 0.3)
    narrow = gnc(problem, 1.0)
    assert narrow.history[1].mu == pytest.approx(0.002806, abs=6e-7)
    assert len(narrow.history) == 19
    wide = [step.x / 0.3 for step in gnc(problem, 3.0).history[1:]]
    np.testing.assert_allclose(wide, [0.392631, 0.072438, -0.023267, -0.041667], atol=6e-7)


def test_a_first_mu_of_1_may_reject_all_where_the_rule_does_not():
    problem = LocationProblem([0.0, 0.0, 10.0])
    assert gnc(problem, 2.0, mu0=1.0).stop is StopReason.ALL_REJECTED
    steps = gnc(problem, 2.0).history[1:]
    np.testing.assert_allclose([step.x for step in steps], [1.017457, 0.0, 0.0], atol=6e-7)


def test_a_first_x_matters_so_by_default_it_is_the_unweighted_solution():
    """From x = 5, the outlier itself, μ = 1 gives the four inliers weight 0 at once."""
    problem = LocationProblem([0.1, -0.2, 0.15, -0.1, 5.0])
    assert gnc(problem, 1.0, x0=5.0, mu0=1.0).x == pytest.approx(5.0)
    assert gnc(problem, 1.0, x0=problem.initial()).x == gnc(problem, 1.0).x


@pytest.mark.parametrize("factor", [1.2, 1.4, 1.5, 2.0])
@pytest.mark.parametrize(("z", "mean"), [(A, 0.0), (B, 0.1)])
def test_the_factor_does_not_matter_where_the_outlier_stands_alone(z, mean, factor):
    assert gnc(LocationProblem(z), 2.0, factor=factor).x == pytest.approx(mean, abs=1e-9)


@pytest.mark.parametrize(("factor", "end"), [(1.2, 0.0), (1.4, 6.0), (1.5, 6.0), (2.0, 6.0)])
def test_with_most_inliers_it_may_still_fail_and_the_factor_decides(factor, end):
    """TLS costs 20 at 6 and 12 at 0 (without the ½), so 0 is the optimum."""
    result = gnc(LocationProblem([0, 0, 0, 0, 6, 6, 30]), 2.0, factor=factor)
    assert result.x == pytest.approx(end, abs=1e-9)
    assert 2.0 * result.cost == pytest.approx(12.0 if end == 0.0 else 20.0)


@pytest.mark.parametrize(("factor", "end"), [(1.2, 0.0), (1.4, 7.0), (1.5, 7.0), (2.0, 7.0)])
def test_the_failure_is_not_a_matter_of_one_number(factor, end):
    result = gnc(LocationProblem([0, 0, 0, 0, 7, 7, 34]), 2.0, factor=factor)
    assert result.x == pytest.approx(end, abs=1e-9)


def test_outliers_that_agree_win_and_that_is_the_optimum():
    result = gnc(LocationProblem([0, 0, 10, 10, 10]), 2.0)
    assert result.x == pytest.approx(10.0)
    assert 2.0 * result.cost == pytest.approx(8.0)


def test_scattered_outliers_lose_though_they_are_the_most():
    assert gnc(LocationProblem([0, 0, 0, 20, -35, 50, -60]), 2.0).x == pytest.approx(0.0)


def test_one_against_one_has_no_answer():
    result = gnc(LocationProblem([0.0, 10.0]), 2.0)
    assert result.stop is StopReason.ALL_REJECTED
    assert result.x == pytest.approx(5.0)
    assert result.weights.tolist() == [0.0, 0.0]
    assert result.history[1].mu == pytest.approx(2.0 / 23.0, rel=1e-12)
    weights = [step.weights for step in result.history[1:]]
    expected = [0.036019, 0.026077, 0.008219, 0.0]
    np.testing.assert_allclose(weights, np.transpose([expected, expected]), atol=6e-7)
    assert result.history[-1].mu == pytest.approx(2.0 / 23.0 * 1.4**3, rel=1e-12)


def test_the_lie_of_the_first_chapter_is_rejected_and_the_length_is_2():
    graph = chain(
        3, [0, 1, 0, 0], [1, 2, 2, 2], [1.0, 1.0, 2.0, 0.0], [0.1, 0.1, 0.05, 0.05],
        trusted=[True, True, False, False],
    )  # fmt: skip
    result = gnc(graph, 3.0)
    assert result.history[1].mu == pytest.approx(0.0101364386, rel=1e-8)
    np.testing.assert_allclose(result.history[1].weights[2:], [0.005991, 0.004199], atol=6e-7)
    assert result.history[1].x[2] == pytest.approx(1.937885, abs=6e-7)
    assert result.x[2] == pytest.approx(2.0, abs=1e-12)
    assert result.weights.tolist() == [1.0, 1.0, 1.0, 0.0]


def test_the_lie_of_the_first_chapter_with_nothing_trusted():
    graph = chain(3, [0, 1, 0, 0], [1, 2, 2, 2], [1.0, 1.0, 2.0, 0.0], [0.1, 0.1, 0.05, 0.05])
    first, last = (gnc(graph, 3.0).history[k] for k in (1, -1))
    np.testing.assert_allclose(first.weights, [0.054371, 0.054371, 0.005991, 0.004199], atol=6e-7)
    assert first.x[2] == pytest.approx(1.505623, abs=6e-7)
    assert last.x[2] == pytest.approx(2.0, abs=1e-12)


def test_trusted_measurements_have_no_say_in_mu_and_keep_their_weight():
    graph = chain(2, [0, 0, 0], [1, 1, 1], [1.0, 1.1, 1000.0], trusted=[False, False, True])
    result = gnc(graph, 1.0)
    doubted = np.abs(result.history[0].x[1] - np.array([1.0, 1.1]))
    excess = 2.0 * doubted.max() ** 2 - 1.0
    assert result.history[1].mu == pytest.approx(1.0 / excess, rel=1e-12)
    assert all(step.weights[2] == 1.0 for step in result.history)


def test_small_residuals_leave_nothing_to_reject():
    result = gnc(LocationProblem([0.0, 0.1, 0.2]), 2.0)
    assert result.stop is StopReason.NOTHING_TO_REJECT
    assert len(result.history) == 1
    assert result.x == pytest.approx(0.1)


@each_surrogate
def test_with_every_measurement_trusted_there_is_nothing_to_reject(kind):
    problem = LocationProblem([0.0, 9.0], trusted=[True, True])
    assert gnc(problem, 1.0, kind).stop is StopReason.NOTHING_TO_REJECT


def test_running_out_of_iterations_is_told():
    result = gnc(LocationProblem(B), 2.0, max_iterations=1)
    assert result.stop is StopReason.ITERATION_LIMIT
    assert len(result.history) == 2


@each_surrogate
@pytest.mark.parametrize("size", [1e-150, 1e-6, 1e6, 1e100])
def test_sizes_far_from_1_make_no_nan(kind, size):
    result = gnc(LocationProblem(size * np.array(A)), 2.0 * size, kind)
    np.testing.assert_allclose(result.x / size, gnc(LocationProblem(A), 2.0, kind).x, atol=1e-9)
    far = gnc(LocationProblem([0.0, 0.1, 0.2, 1e9]), 1.0, kind)
    assert np.isfinite(far.x)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("steps", [1, 5, 100])
def test_on_a_pose_graph_every_lie_is_rejected(seed, steps):
    rng = np.random.default_rng(seed)
    graph, truth = manhattan(80, rng, closures=40)
    spoiled, is_lie = add_random_closures(graph, 15, rng, poses=truth)
    problem = PoseGraphProblem(spoiled, steps=steps)
    result = gnc(problem, chi_square_threshold(0.99, 3))
    assert result.stop is StopReason.BINARY_WEIGHTS
    assert not np.any(result.weights[is_lie])
    assert np.mean(result.weights[~is_lie]) > 0.95
    again = PoseGraphProblem(spoiled).solve(result.weights, result.x)
    at_rest, norms = problem.residual_norms(again), problem.residual_norms(result.x)
    np.testing.assert_allclose(norms, at_rest, atol=1e-6)


class Crawling(LocationProblem):
    """A location whose solve goes only a part of the way to the weighted mean."""

    def __init__(self, z, part):
        super().__init__(z)
        self.part = part

    def initial(self):
        return super().solve(np.ones_like(self.z), 0.0)

    def solve(self, weights, x):
        return x + self.part * (super().solve(weights, x) - x)


def test_a_solve_that_goes_half_the_way_is_brought_to_rest():
    result = gnc(Crawling(B, 0.5), 2.0)
    assert result.stop is StopReason.BINARY_WEIGHTS
    assert result.x == pytest.approx(0.1, abs=1e-8)
    before, last = result.history[-2:]
    assert abs(before.x - 0.1) > 1e-3
    assert last.weights.tolist() == before.weights.tolist() == [1.0, 1.0, 1.0, 0.0]
    assert last.mu == before.mu
    assert last.cost == pytest.approx(kernels.tls(2.0).rho(np.array(B) - result.x).sum())


def test_a_solve_that_flutters_where_no_cost_is_left_to_lower_is_at_rest():
    """Around the mean, as far to one side as to the other: the cost is the same."""

    class Fluttering(LocationProblem):
        side = 1.0

        def solve(self, weights, x):
            self.side = -self.side
            return super().solve(weights, x) + 1e-6 * self.side

    result = gnc(Fluttering(B), 2.0)
    assert result.stop is StopReason.BINARY_WEIGHTS
    assert result.x == pytest.approx(0.1, abs=1e-5)


def test_an_exact_solve_is_repeated_once_and_no_more():
    """One solve for the mean, one for each of two μ, one to see that it is at rest."""

    class Counting(LocationProblem):
        solves = 0

        def solve(self, weights, x):
            self.solves += 1
            return super().solve(weights, x)

    problem = Counting(A)
    gnc(problem, 2.0)
    assert problem.solves == 4


@each_surrogate
def test_a_solve_that_does_not_come_to_rest_is_told(kind):
    """The start is the mean, 1, so nine are within c = 2 and nothing else is in doubt."""
    result = gnc(Crawling([0.0] * 9 + [10.0], 1e-3), 2.0, kind)
    assert result.stop is StopReason.ITERATION_LIMIT
    assert result.x == result.history[-1].x
    assert len(result.history) < 1000


def test_gm_on_a_pose_graph_ends_near_the_map_without_lies():
    rng = np.random.default_rng(5)
    graph, truth = circle(40, rng, laps=2, closures=12)
    spoiled, is_lie = add_random_closures(graph, 5, rng, poses=truth)
    result = gnc(PoseGraphProblem(spoiled, steps=1), chi_square_threshold(0.99, 3), "gm")
    assert result.stop is StopReason.CONVERGED
    assert result.weights[is_lie].max() < 0.01
    assert ate(result.x, PoseGraphProblem(graph).initial()) < 0.1


def test_the_rule_and_the_function_say_the_same():
    rule, problem = GncTls(2.0), LocationProblem(B)
    assert reweight(problem, rule, tol=1e-9, max_iterations=50).x == gnc(problem, 2.0).x


@pytest.mark.parametrize(
    ("most", "count"), [(0.0, 3), (0.05, 3), (0.051, 2), (0.1, 2), (0.101, 1), (9.0, 1)]
)
def test_mu_takes_two_factors_where_little_moves_and_three_where_less_does(most, count):
    moved = np.full(200, most)
    assert strides(moved) == count
    moved[0] = 1e6  # one in two hundred may do what it likes
    assert strides(moved) == count
    moved[:3] = 1e6
    assert strides(moved) == 1


def test_with_nothing_to_doubt_nothing_moves():
    assert strides(np.empty(0)) == 3


def test_an_adaptive_mu_moves_on_by_two_factors_until_a_weight_is_one_and_then_by_strides():
    rule = GncTls(2.0, factor=1.5, adaptive=True)
    assert rule.next(0.1, np.array([0.5, 0.0]), np.array([9.0, 9.0])) == pytest.approx(0.225)
    assert rule.next(0.1, np.array([1.0, 0.0]), np.array([9.0, 9.0])) == pytest.approx(0.15)
    assert rule.next(0.1, np.array([1.0, 0.0]), np.array([0.0, 0.0])) == pytest.approx(0.3375)
    down = GncGm(2.0, factor=1.5, adaptive=True)
    assert down.next(9.0, np.array([0.5]), np.array([0.0])) == pytest.approx(9.0 / 1.5**3)
    assert down.next(2.0, np.array([0.5]), np.array([0.0])) == 1.0


@pytest.mark.parametrize("kind", ["tls", "gm"])
def test_an_adaptive_schedule_ends_where_the_fixed_one_does_with_fewer_solves(kind):
    rng = np.random.default_rng(5)
    graph, truth = circle(40, rng, laps=2, closures=12)
    spoiled, is_lie = add_random_closures(graph, 5, rng, poses=truth)
    problem, c = PoseGraphProblem(spoiled, steps=1), chi_square_threshold(0.99, 3)
    fixed, adaptive = (
        gnc(problem, c, kind, problem.guess, adaptive=adaptive) for adaptive in (False, True)
    )
    assert np.array_equal(adaptive.weights > 0.5, fixed.weights > 0.5)
    assert adaptive.weights[is_lie].max() < 0.01
    assert len(adaptive.history) < len(fixed.history)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"c": 0.0}, r"c is 0\.0"),
        ({"c": -1.0}, r"c is -1\.0"),
        ({"c": np.inf}, "c is inf"),
        ({"c": 1.0, "factor": 1.0}, r"factor is 1\.0; μ has to move on"),
        ({"c": 1.0, "factor": np.nan}, "factor is nan"),
        ({"c": 1.0, "mu0": 0.0}, r"mu0 is 0\.0"),
        ({"c": 1.0, "kind": "huber"}, "kind is 'huber'; give one of 'tls', 'gm'"),
        ({"c": 1.0, "max_iterations": 0}, "max_iterations is 0"),
    ],
)
def test_bad_arguments_are_refused_by_name(arguments, told):
    with pytest.raises(ValueError, match=told):
        gnc(LocationProblem(A), **arguments)


def test_a_first_mu_of_nonsense_is_refused_by_name():
    for u_max in (-1.0, np.nan):
        with pytest.raises(ValueError, match="u_max is"):
            start_mu(u_max, 1.0)
    with pytest.raises(ValueError, match="c is 0"):
        start_mu(1.0, 0.0)
    with pytest.raises(ValueError, match="kind is 'TLS'"):
        start_mu(1.0, 1.0, "TLS")


@each_surrogate
def test_bad_scales_are_refused_by_every_formula(kind):
    for function in SURROGATES[kind]:
        for c, mu, told in ((0.0, 1.0, "c is 0"), (1.0, -1.0, "mu is -1"), (1.0, np.inf, "mu is")):
            with pytest.raises(ValueError, match=told):
                function(1.0, c, mu)
