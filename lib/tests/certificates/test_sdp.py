"""The relaxation and its certificate: exact values, laws, and what they do not prove."""

import sys
from functools import cache

import cvxpy
import numpy as np
import pytest
from robust_slam.certificates import sdp
from robust_slam.certificates.sdp import connection_matrix, dense_certificate, is_tight, solve_sdp
from scipy.spatial.transform import Rotation

from ..worlds import refused

SIX = np.array([[0, 1], [1, 2], [2, 3], [3, 4], [4, 5], [5, 0], [0, 3], [1, 4]])


@pytest.fixture(params=[2, 3])
def d(request):
    return request.param


def turns(d, rng, count, size):
    """Rotations by about ``size`` rad, in space about random axes."""
    if d == 3:
        return Rotation.from_rotvec(size * rng.normal(size=(count, 3))).as_matrix()
    return about_z(2, size * rng.normal(size=count))


def about_z(d, angle):
    return Rotation.from_rotvec(np.outer(angle, [0, 0, 1])).as_matrix()[:, :d, :d]


def six_poses(d, seed, noise):
    """True rotations ``(6, d, d)``, noisy ones between them, and the matrix Q."""
    rng = np.random.default_rng(seed)
    truth, error = turns(d, rng, 6, 2.0), turns(d, rng, len(SIX), noise)
    measured = np.swapaxes(truth[SIX[:, 0]], 1, 2) @ truth[SIX[:, 1]] @ error
    return truth, measured, connection_matrix(6, SIX, measured)


@cache
def solved(d, seed, noise):
    """The matrix Q of six poses, its relaxed solution, and that rounded to rotations."""
    _, _, Q = six_poses(d, seed, noise)
    solution = solve_sdp(Q, d)
    return Q, solution, sdp.round_solution(solution.Z, d)


def cycle(d, n, alpha):
    """Q of n poses in a ring, each said to be turned by alpha (rad) against the one before."""
    edges = [[k, (k + 1) % n] for k in range(n)]
    return connection_matrix(n, edges, about_z(d, np.full(n, alpha)))


def row(blocks):
    return np.concatenate(list(blocks), axis=1)


def blocks(R):
    return np.stack(np.split(R, R.shape[1] // len(R), axis=1))


def cost(Q, R):
    return float(np.trace(R @ Q @ R.T))


def test_the_connection_matrix_holds_the_cost_of_any_matrices(d, seed):
    rng = np.random.default_rng(seed)
    edges = np.array([[0, 1], [2, 1], [0, 1], [3, 0], [2, 3]])
    measured, kappa = turns(d, rng, 5, 1.0), rng.uniform(0.0, 9.0, 5)
    Q = connection_matrix(4, edges, measured, kappa)
    X = rng.normal(size=(4, d, d))
    errors = X[edges[:, 1]] - X[edges[:, 0]] @ measured
    expected = np.sum(kappa[:, None, None] * errors**2)
    assert cost(Q, row(X)) == pytest.approx(expected, rel=1e-12)
    np.testing.assert_array_equal(Q, Q.T)


@pytest.mark.parametrize("alpha", [0.3, -0.7, 0.95])
def test_a_three_cycle_has_its_exact_cost_and_the_eigenvalues_of_its_certificate(d, alpha):
    # Each of the three edges keeps the error alpha, and ‖I − R(α)‖²_F = 4 (1 − cos α).
    Q, R = cycle(d, 3, alpha), row([np.eye(d)] * 3)
    solution = solve_sdp(Q, d)
    assert solution.value == pytest.approx(12.0 * (1.0 - np.cos(alpha)), rel=1e-6)
    assert solution.rank == d
    assert is_tight(solution.Z, Q, R)
    # As complex numbers Q is 2 − e^{iα} shift − its adjoint, Λ = 2 − 2 cos α, and the
    # waves e^{2πik/3} are eigenvectors. About the axis, in space, no rotation shows and S
    # is the Laplacian of the ring: 0, 3, 3.
    waves = 2.0 * np.cos(alpha) - 2.0 * np.cos(alpha + 2.0 * np.pi * np.arange(3) / 3.0)
    expected = np.concatenate([waves, waves, [0.0, 3.0, 3.0] if d == 3 else []])
    np.testing.assert_allclose(dense_certificate(Q, R)[1], np.sort(expected), atol=1e-12)


def test_at_a_tight_optimum_the_certificate_has_d_zeros_and_no_negative(d, seed):
    Q, solution, R = solved(d, seed, 0.2)
    S, eigenvalues = dense_certificate(Q, R)
    np.testing.assert_allclose(S @ R.T, 0.0, atol=1e-4)
    assert eigenvalues[0] > -1e-6
    assert np.sum(eigenvalues < 1e-4) == d
    assert cost(Q, R) == pytest.approx(solution.value, rel=1e-6)
    assert is_tight(solution.Z, Q, R)
    assert sdp.suboptimality(Q, R) < 1e-5


@pytest.mark.parametrize(("d", "noise", "seed"), [(2, 1.2, 3), (3, 1.0, 1)])
def test_large_noise_leaves_a_gap_and_a_higher_rank(d, noise, seed):
    Q, solution, R = solved(d, seed, noise)
    assert solution.rank > d
    assert not is_tight(solution.Z, Q, R)
    gap = cost(Q, R) - solution.value
    assert 0.01 < gap <= sdp.suboptimality(Q, R)
    assert dense_certificate(Q, R)[1][0] < -0.01


def test_two_equally_good_answers_raise_the_rank_although_the_value_is_attained():
    # With alpha = π/3 the ring is half a turn short or half a turn long: all equal to I,
    # or each turned by 2π/3 more, costs 12 (1 − cos π/3) = 6.
    Q = cycle(2, 3, np.pi / 3.0)
    solution = solve_sdp(Q, 2)
    for turn in (0.0, 2.0 * np.pi / 3.0):
        R = row(about_z(2, turn * np.arange(3)))
        assert cost(Q, R) == pytest.approx(6.0, rel=1e-12)
        assert sdp.suboptimality(Q, R) < 1e-12
        assert not is_tight(solution.Z, Q, R)
    assert solution.value == pytest.approx(6.0, rel=1e-6)
    assert solution.rank == 4


def test_a_twisted_five_cycle_is_stationary_and_refused(d):
    Q, R = cycle(d, 5, 0.0), row(about_z(d, 2.0 * np.pi * np.arange(5) / 5.0))
    S, eigenvalues = dense_certificate(Q, R)
    np.testing.assert_allclose(S @ R.T, 0.0, atol=1e-12)
    # Λ = 2 − 2 cos 72°, and S − Q moves the 0 of Q there.
    assert eigenvalues[0] == pytest.approx(2.0 * np.cos(2.0 * np.pi / 5.0) - 2.0, rel=1e-9)
    assert not is_tight(solve_sdp(Q, d).Z, Q, R)
    # The least cost is 0, and in the plane the bound is exactly the gap.
    gap = 5.0 * d * (2.0 - 2.0 * np.cos(2.0 * np.pi / 5.0))
    assert sdp.suboptimality(Q, R) == pytest.approx(gap, rel=1e-12)
    assert cost(Q, R) == pytest.approx(10.0 * gap / (5.0 * d), rel=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_the_bound_is_never_negative_though_rounding_may_lift_the_lowest_eigenvalue(d, seed):
    truth, _, Q = six_poses(d, seed, 0.0)
    assert 0.0 <= sdp.suboptimality(Q, row(truth)) < 1e-12


def test_the_multipliers_are_symmetric_and_block_diagonal(d, seed):
    _, _, Q = six_poses(d, seed, 0.3)
    S, _ = dense_certificate(Q, row(turns(d, np.random.default_rng(seed), 6, 2.0)))
    outside = np.kron(np.eye(6), np.ones((d, d))) == 0.0
    np.testing.assert_array_equal((Q - S)[outside], 0.0)
    np.testing.assert_allclose(S, S.T, atol=1e-15)


@pytest.mark.parametrize("mirrored", [[0, 1], [0, 1, 2], [3], [1, 2, 3, 4]])
def test_rounding_keeps_what_most_blocks_say_when_some_are_mirrored(d, seed, mirrored):
    proper = turns(d, np.random.default_rng(seed), 5, 2.0)
    mixed = proper.copy()
    mixed[mirrored, 0] *= -1.0
    found = blocks(sdp.round_solution(row(mixed).T @ row(mixed), d))
    np.testing.assert_allclose(found[0], np.eye(d), atol=1e-12)
    np.testing.assert_allclose(np.linalg.det(found), 1.0, atol=1e-12)
    others = np.setdiff1d(np.arange(5), mirrored)
    most = np.array(max(mirrored, others, key=len))
    there = np.swapaxes(mixed[most[:1]], 1, 2) @ mixed[most]
    here = np.swapaxes(found[most[:1]], 1, 2) @ found[most]
    np.testing.assert_allclose(here, there, atol=1e-9)


def test_a_rank_is_relative_to_the_largest_eigenvalue():
    for scale in (1e-9, 1.0, 1e9):
        assert sdp.numerical_rank(scale * np.diag([1.0, 2.0, 1e-4, 1e-6])) == 3
        assert sdp.numerical_rank(scale * np.diag([1.0, 2.0, 1e-4, 1e-6]), tol=1e-3) == 2
    assert sdp.numerical_rank(np.zeros((3, 3))) == 0


def test_the_unit_of_the_precisions_does_not_matter(d):
    _, measured, _ = six_poses(d, 5, 0.3)
    _, reference, _ = solved(d, 5, 0.3)
    for kappa in (1e-6, 1e6):
        scaled = connection_matrix(6, SIX, measured, kappa)
        solution = solve_sdp(scaled, d)
        assert solution.value == pytest.approx(kappa * reference.value, rel=1e-6)
        assert solution.rank == d
        assert is_tight(solution.Z, scaled, sdp.round_solution(solution.Z, d))


def test_a_solver_that_fails_is_reported_and_without_cvxpy_the_fix_is_named(monkeypatch):
    def give_up(self, **options):
        raise cvxpy.SolverError("no progress")

    monkeypatch.setattr(cvxpy.Problem, "status", property(lambda self: "user_limit"))
    with pytest.raises(sdp.SdpFailed, match="CLARABEL says 'user_limit'"):
        solve_sdp(cycle(2, 3, 0.3), 2)
    monkeypatch.setattr(cvxpy.Problem, "solve", give_up)
    with pytest.raises(sdp.SdpFailed, match="CLARABEL gives up on Q: no progress"):
        solve_sdp(cycle(2, 3, 0.3), 2)
    monkeypatch.setitem(sys.modules, "cvxpy", None)
    with pytest.raises(ImportError, match="pip install cvxpy clarabel"):
        solve_sdp(cycle(2, 3, 0.3), 2)


@refused(
    ({"edges": [[0, 2]]}, r"edge 0 is \[0, 2\]; poses are 0 to 1"),
    ({"rotations": [np.eye(2)] * 2}, "rotations: the shape"),
    ({"rotations": [np.eye(4)]}, "rotations: the shape"),
    ({"rotations": [np.ones((2, 3))]}, "rotations: the shape"),
    ({"rotations": [np.diag([1.0, -1.0])]}, "rotations: block 0 is not a rotation matrix"),
    ({"kappa": [-1.0]}, "kappa: edge 0 has less than 0"),
    ({"kappa": [1.0, 1.0]}, "kappa: the shape"),
)
def test_measurements_that_are_none_are_refused_by_name(wrong, message):
    arguments = {"n": 2, "edges": [[0, 1]], "rotations": [np.eye(2)], "kappa": 1.0}
    with pytest.raises(ValueError, match=message):
        connection_matrix(**(arguments | wrong))


@refused(
    ((solve_sdp, np.eye(4)[:3], 2), "Q: the shape"),
    ((solve_sdp, np.triu(np.ones((4, 4))), 2), "Q is not symmetric"),
    ((solve_sdp, np.eye(4), 3), "Q: 4 rows are not blocks of d = 3"),
    ((solve_sdp, np.eye(4), 1), "Q: 4 rows are not blocks of d = 1"),
    ((solve_sdp, np.empty((0, 0)), 2), "Q: the shape"),
    ((solve_sdp, np.eye(sdp.SIZE_LIMIT + 2), 2), r"62 rows .* robust_slam\.certificate"),
    (
        (is_tight, np.eye(6), np.eye(4), row([np.eye(2)] * 2)),
        r"Z: the shape is \(6, 6\), and that of Q \(4, 4\)",
    ),
)
def test_a_matrix_of_another_size_or_kind_is_refused_by_name(wrong, message):
    function, *given = wrong
    with pytest.raises(ValueError, match=message):
        function(*given)


@refused(
    (np.eye(2)[None], "R: the shape"),
    (np.ones((2, 3)), "R: the shape"),
    (np.eye(4), "R: the shape"),
    (np.ones((2, 4)), "R: block 0 is not a rotation matrix"),
    (row([np.eye(2), np.diag([1.0, -1.0])]), "R: block 1 is not a rotation matrix"),
    (row([np.eye(2)] * 3), "R: 6 columns do not fit the 4 rows of Q"),
    (row([np.eye(3)] * 2), "Q: 4 rows"),
)
def test_rotations_that_are_none_are_refused_by_name(wrong, message):
    for function in (dense_certificate, sdp.suboptimality):
        with pytest.raises(ValueError, match=message):
            function(np.eye(4), wrong)
