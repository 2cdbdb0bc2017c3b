"""Graduated non-convexity: its formulas by law, its schedules by the numbers, its outcomes.

The two data sets are A = (0, 0, 0, 10) and B = (−0.2, 0.1, 0.4, 10), both with c = 2 and
unit deviations, small enough to follow by hand. For A the unweighted mean is 2.5 and the
largest residual 7.5, so μ starts at 4/108.5 (TLS).
"""

from unittest.mock import patch

import numpy as np
import pytest
from robust_slam.estimators import StopReason, chi_square_threshold, irls, kernels
from robust_slam.estimators import graduation as g
from robust_slam.estimators.graduation import GncGm, GncTls, gnc, start_mu
from robust_slam.graphs import circle, manhattan
from robust_slam.problems import LocationProblem, PoseGraphProblem

from ..worlds import refused, with_outliers

A, B = (0.0, 0.0, 0.0, 10.0), (-0.2, 0.1, 0.4, 10.0)
SURROGATES = {
    "tls": (g.tls_surrogate, g.tls_weight, g.tls_process),
    "gm": (g.gm_surrogate, g.gm_weight, g.gm_process),
}
U = np.linspace(-12.0, 12.0, 481)


@pytest.fixture(params=SURROGATES)
def kind(request):
    return request.param


@pytest.fixture(params=[1e-3, 0.05, 0.7, 1.0, 3.0, 200.0])
def mu(request):
    return request.param


def test_the_weight_is_influence_over_residual(kind, mu):
    surrogate, weight, _ = SURROGATES[kind]
    u, h = U[np.abs(U) > 0.1], 1e-6
    if kind == "tls":
        knees = 2.0 * np.sqrt([[mu / (mu + 1.0)], [(mu + 1.0) / mu]])
        u = u[np.all(np.abs(np.abs(u) - knees) > 10.0 * h, axis=0)]
    slope = (surrogate(u + h, 2.0, mu) - surrogate(u - h, 2.0, mu)) / (2.0 * h)
    np.testing.assert_allclose(weight(u, 2.0, mu), slope / u, atol=1e-7)


def test_the_surrogate_is_the_least_of_weighted_square_and_price(kind, mu):
    """Black–Rangarajan duality: no weight does better than the surrogate's own."""
    surrogate, weight, process = SURROGATES[kind]
    w = np.linspace(0.0, 1.0, 1001)[:, None]
    value, best = surrogate(U, 2.0, mu), weight(U, 2.0, mu)
    assert np.all(0.5 * w * U**2 + process(w, 2.0, mu) >= value - 1e-9)
    np.testing.assert_allclose(0.5 * best * U**2 + process(best, 2.0, mu), value, atol=1e-11)


@pytest.mark.parametrize("mu", [1e100, 1e200, 1e300])
def test_a_huge_mu_is_the_kernel_and_does_not_overflow(mu):
    u, truncated = np.array([0.0, 0.5, 1.9, 2.1, 1e10, np.inf]), kernels.tls(2.0)
    with np.errstate(all="raise", under="ignore"):
        np.testing.assert_array_equal(g.tls_weight(u, 2.0, mu), truncated.weight(u))
        np.testing.assert_array_equal(g.tls_surrogate(u, 2.0, mu), truncated.rho(u))


def test_no_mu_rejects_anything_within_c_and_that_of_geman_mcclure_starts_at_1_at_least():
    """2u² = c² at u = 2, c² = 8; both sides of it differ by one part in 10⁹."""
    c = np.sqrt(8.0)
    assert start_mu(2.0 * (1.0 - 1e-9), c) == np.inf
    assert 1e7 < start_mu(2.0 * (1.0 + 1e-9), c) < np.inf
    assert start_mu(0.0, c) == np.inf
    assert start_mu(1.0, 2.0, "gm") == 0.5
    assert GncGm(2.0).start(np.array([1.0])) == 1.0


@pytest.mark.parametrize(
    ("u_max", "c"), [(1e200, 1.0), (1.0, 1e-200), (1.0, 1e-320), (np.inf, 1.0)]
)
def test_residuals_beyond_all_measure_still_have_a_first_mu(u_max, c):
    assert 0.0 < start_mu(u_max, c) < 1e-300
    assert 1e300 < start_mu(u_max, c, "gm") < np.inf


ROOT_2 = np.sqrt(2.0)
W_IN, W_OUT = (24.0 * ROOT_2 - 8.0) / 217.0, (8.0 * ROOT_2 - 8.0) / 217.0
GM_B = [
    (27.565312, 0.873700, 0.897507, 0.919415, 0.444444, 1.507853),
    (19.689509, 0.929852, 0.951506, 0.969546, 0.272494, 0.967518),
    (14.063935, 0.953245, 0.973772, 0.988647, 0.166561, 0.638435),
    (10.045668, 0.965908, 0.985725, 0.997176, 0.098826, 0.424105),
    (7.175477, 0.973401, 0.992720, 0.999960, 0.056829, 0.288750),
    (5.125341, 0.977098, 0.996533, 0.998794, 0.031887, 0.207241),
    (3.660958, 0.977729, 0.998431, 0.994945, 0.017549, 0.159860),
    (2.614970, 0.975691, 0.999315, 0.989064, 0.009505, 0.132994),
    (1.867836, 0.970965, 0.999709, 0.981186, 0.005080, 0.118044),
    (1.334168, 0.963143, 0.999878, 0.970859, 0.002685, 0.109840),
    (1.000000, 0.953674, 0.999952, 0.959196, 0.001543, 0.105812),
]

SCHEDULES = {
    "TLS, A": (
        *(A, {}, StopReason.BINARY_WEIGHTS, 1e-12),
        [
            (8.0 / 217.0, W_IN, W_IN, W_IN, W_OUT, 20.0 / 23.0 - 15.0 * ROOT_2 / 46.0),
            (1.4 * 8.0 / 217.0, 1.0, 1.0, 1.0, 0.0, 0.0),
        ],
    ),
    "TLS, B, from μ = 1": (
        *(B, {"factor": 1.5, "mu0": 1.0}, StopReason.BINARY_WEIGHTS, 6e-7),
        [(1.0, 0.019253, 0.142799, 0.300426, 0.0, 0.282391), (1.5, 1.0, 1.0, 1.0, 0.0, 0.1)],
    ),
    "GM, B": (B, {"kind": "gm"}, StopReason.CONVERGED, 6e-7, GM_B),
}


@pytest.mark.parametrize(
    ("z", "options", "stop", "atol", "rows"), SCHEDULES.values(), ids=SCHEDULES
)
def test_every_row_of_a_schedule_by_hand(z, options, stop, atol, rows):
    result = gnc(LocationProblem(z), 2.0, **options)
    found = [(step.mu, *step.weights, step.x) for step in result.history[1:]]
    np.testing.assert_allclose(found, rows, atol=atol, rtol=1e-6)
    assert result.stop is stop


@pytest.mark.parametrize(("z", "fixed"), [(A, 0.004937963159), (B, 0.105555126205)])
def test_gm_ends_near_a_minimum_and_irls_goes_on_to_it(z, fixed):
    problem, kernel = LocationProblem(z), kernels.geman_mcclure(2.0)
    result = gnc(problem, 2.0, "gm")
    onward = irls(problem, kernel, result.x)
    assert 1e-6 < abs(result.x - fixed) < 1e-3
    assert result.cost == pytest.approx(kernel.rho(np.array(z) - result.x).sum())
    assert onward.x == pytest.approx(fixed, abs=1e-10)
    assert onward.cost < result.cost


OUTCOMES = {
    "outliers that agree win": ([0, 0, 10, 10, 10], 2.0, {}, StopReason.BINARY_WEIGHTS, 10.0),
    "more outliers, scattered": (
        *([0, 0, 0, 20, -35, 50, -60], 2.0, {}, StopReason.BINARY_WEIGHTS, 0.0),
    ),
    "one against one": ([0.0, 10.0], 2.0, {}, StopReason.ALL_REJECTED, 5.0),
    "μ from the rule": ([0.0, 0.0, 10.0], 2.0, {}, StopReason.BINARY_WEIGHTS, 0.0),
    "μ from 1": ([0.0, 0.0, 10.0], 2.0, {"mu0": 1.0}, StopReason.ALL_REJECTED, 10.0 / 3.0),
    "small residuals": ([0.0, 0.1, 0.2], 2.0, {}, StopReason.NOTHING_TO_REJECT, 0.1),
    "a small scale": ([0.0, 0.1, 0.0, 10.0], 1e-12, {}, StopReason.BINARY_WEIGHTS, 0.0),
    "a tiny scale": (A, 1e-200, {}, StopReason.ALL_REJECTED, 2.5),
    "one iteration": (B, 2.0, {"max_iterations": 1}, StopReason.ITERATION_LIMIT, 0.529839),
}


@pytest.mark.parametrize(("z", "c", "options", "stop", "x"), OUTCOMES.values(), ids=OUTCOMES)
def test_where_it_ends_and_why(z, c, options, stop, x):
    result = gnc(LocationProblem(z), c, **options)
    assert result.stop is stop
    assert result.x == pytest.approx(x, abs=6e-7)
    assert result.cost == pytest.approx(kernels.tls(c).rho(np.array(z) - result.x).sum())
    if stop is StopReason.ALL_REJECTED:
        assert not np.any(result.weights)


def test_with_every_measurement_trusted_there_is_nothing_to_reject(kind):
    problem = LocationProblem([0.0, 9.0], trusted=[True, True])
    assert gnc(problem, 1.0, kind).stop is StopReason.NOTHING_TO_REJECT


@pytest.mark.parametrize("size", [1e-150, 1e-6, 1e6, 1e100])
def test_sizes_far_from_1_make_no_nan(kind, size):
    result = gnc(LocationProblem(size * np.array(A)), 2.0 * size, kind)
    np.testing.assert_allclose(result.x / size, gnc(LocationProblem(A), 2.0, kind).x, atol=1e-9)
    assert np.isfinite(gnc(LocationProblem([0.0, 0.1, 0.2, 1e9]), 1.0, kind).x)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("steps", [1, 5, 100])
def test_on_a_pose_graph_every_outlier_is_rejected(seed, steps):
    graph, is_outlier, *_ = with_outliers(manhattan, 80, seed, 15, closures=40)
    problem = PoseGraphProblem(graph, steps=steps)
    result = gnc(problem, chi_square_threshold(0.99, 3))
    assert result.stop is StopReason.BINARY_WEIGHTS
    assert not np.any(result.weights[is_outlier])
    assert np.mean(result.weights[~is_outlier]) > 0.95
    again = PoseGraphProblem(graph).solve(result.weights, result.x)
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
    with patch.object(
        LocationProblem, "solve", autospec=True, side_effect=LocationProblem.solve
    ) as solve:
        gnc(LocationProblem(A), 2.0)
    assert solve.call_count == 4


def test_a_solve_that_does_not_come_to_rest_ends_at_a_limit(kind):
    """The start is the mean, 1, so nine are within c = 2 and nothing else is in doubt."""
    result = gnc(Crawling([0.0] * 9 + [10.0], 1e-3), 2.0, kind)
    assert result.stop is StopReason.ITERATION_LIMIT
    assert result.x == result.history[-1].x
    assert len(result.history) < 1000


@pytest.fixture
def laps():
    return with_outliers(circle, 40, 5, 5, laps=2, closures=12)


def test_an_adaptive_schedule_ends_where_the_fixed_one_does_with_fewer_solves(laps, kind):
    graph, is_outlier, *_ = laps
    problem, c = PoseGraphProblem(graph, steps=1), chi_square_threshold(0.99, 3)
    fixed, adaptive = (gnc(problem, c, kind, problem.guess, adaptive=a) for a in (False, True))
    assert np.array_equal(adaptive.weights > 0.5, fixed.weights > 0.5)
    assert adaptive.weights[is_outlier].max() < 0.01
    assert len(adaptive.history) < len(fixed.history)


def test_an_adaptive_mu_moves_on_by_two_factors_until_a_weight_is_one_and_then_by_strides():
    rule = GncTls(2.0, factor=1.5, adaptive=True)
    assert rule.next(0.1, np.array([0.5, 0.0]), np.array([9.0, 9.0])) == pytest.approx(0.225)
    assert rule.next(0.1, np.array([1.0, 0.0]), np.array([9.0, 9.0])) == pytest.approx(0.15)
    assert rule.next(0.1, np.array([1.0, 0.0]), np.array([0.0, 0.0])) == pytest.approx(0.3375)
    down = GncGm(2.0, factor=1.5, adaptive=True)
    assert down.next(9.0, np.array([0.5]), np.array([0.0])) == pytest.approx(9.0 / 1.5**3)
    assert down.next(2.0, np.array([0.5]), np.array([0.0])) == 1.0


@refused(
    (lambda: gnc(LocationProblem(A), 0.0), r"c is 0\.0"),
    (lambda: gnc(LocationProblem(A), 1.0, factor=1.0), r"factor is 1\.0; μ has to move on"),
    (lambda: gnc(LocationProblem(A), 1.0, mu0=0.0), r"mu0 is 0\.0"),
    (lambda: gnc(LocationProblem(A), 1.0, "huber"), "kind is 'huber'; give one of 'tls', 'gm'"),
    (lambda: gnc(LocationProblem(A), 1.0, max_iterations=0), "max_iterations is 0"),
    (lambda: start_mu(-1.0, 1.0), "u_max is"),
    (lambda: start_mu(np.nan, 1.0), "u_max is"),
    (lambda: start_mu(1.0, 0.0), "c is 0"),
    (lambda: start_mu(1.0, 1.0, "TLS"), "kind is 'TLS'"),
)
def test_bad_arguments_are_refused_by_name(wrong, message):
    with pytest.raises(ValueError, match=message):
        wrong()


@refused(((0.0, 1.0), "c is 0"), ((1.0, -1.0), "mu is -1"), ((1.0, np.inf), "mu is"))
def test_bad_scales_are_refused_by_every_formula(kind, wrong, message):
    for function in SURROGATES[kind]:
        with pytest.raises(ValueError, match=message):
            function(1.0, *wrong)
