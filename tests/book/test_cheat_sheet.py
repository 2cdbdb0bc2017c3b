"""The cheat sheet has a row for every topic of the lessons, and its formulas are right."""

from __future__ import annotations

import re

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import start_mu, tls_process
from robust_slam.estimators.switches import dcs_switch
from robust_slam.graphs import se2, se3
from scipy.linalg import expm, solve_continuous_are
from scipy.ndimage import gaussian_filter, gaussian_laplace

from tests.book.prose import CHAPTERS, DECIMAL

PAGE = (CHAPTERS / "cheat-sheet.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (L\d+) \| (.+?)<br>(.+) \|$", PAGE, re.M)
XI = np.array([0.3, -0.2, 0.5, 0.4, -0.1, 0.2])  # positions first, then angles
K = np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
ONE = np.eye(1)


def cross(v: np.ndarray) -> np.ndarray:
    return np.cross(np.eye(3), v)


def two_views() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The second camera's rotation and translation, and points in both frames (n, 3)."""
    pose = se3.exp([0.6, 0.0, 0.8, 0.1, 0.2, -0.1])
    first = np.random.default_rng(0).uniform([-2, -2, 4], [2, 2, 9], (8, 3))
    return pose[:, :3], pose[:, 3], first, first @ pose[:, :3].T + pose[:, 3]


def test_every_lesson_has_a_row() -> None:
    assert {lesson for lesson, *_ in ROWS} == {f"L{number}" for number in range(1, 14)}
    assert "## Robust SLAM: L14" in PAGE


@pytest.mark.parametrize(
    ("lesson", "topics"),
    [
        ("L1", "SO(3) SE(3)"),
        ("L2", "Exp Log BCH Retraction"),
        ("L3", "PID LQR Riccati attitude"),
        ("L4", "snap QP flatness"),
        ("L5", "Pinhole"),
        ("L6", "Harris SIFT KLT"),
        ("L7", "Epipolar Eight-point Triangulation"),
        ("L8", "RANSAC front-end"),
        ("L9", "Gauss–Newton LM"),
        ("L10", "manifolds"),
        ("L11", "Preintegration fusion"),
        ("L12", "TF-IDF Vocabulary RANSAC positive"),
        ("L13", "Factor Cholesky iSAM2 Schur"),
    ],
)
def test_every_topic_of_the_lessons_stands_in_its_row(lesson: str, topics: str) -> None:
    said = " ".join(idea for number, idea, _ in ROWS if number == lesson)
    assert not [topic for topic in topics.split() if topic not in said]


def test_the_topics_of_robust_slam_lead_to_their_chapters() -> None:
    rows = PAGE.partition("## Robust SLAM: L14")[2]
    for topic in ("M-estimator", "IRLS", "GNC", "Switchable", "SE-Sync"):
        assert re.search(rf"^\| .*{topic}.*<br>.* \| \[\d\]\(\d\d-", rows, re.M), topic


def test_the_decimals_are_those_that_are_checked_here() -> None:
    assert set(DECIMAL.findall(PAGE)) == {"0.5", "0.01", "0.9", "0.476", "1.4"}


def test_l1_a_pose_is_the_exponential_of_a_twist() -> None:
    hat = np.zeros((4, 4))
    hat[:3, :3], hat[:3, 3] = cross(XI[3:]), XI[:3]
    np.testing.assert_allclose(expm(hat)[:3], se3.exp(XI))
    turn = se3.exp(XI)[:, :3]
    np.testing.assert_allclose(turn.T @ turn, np.eye(3), atol=1e-12)
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_l2_what_bch_leaves_is_of_third_order() -> None:
    def left(h: float) -> float:
        a, b = h * np.array([0.5, 0.2, 0.3]), h * np.array([-0.1, 0.4, 0.6])
        bracket = np.array([b[2] * a[1] - a[2] * b[1], a[2] * b[0] - b[2] * a[0], 0.0])
        both = se2.log(se2.compose(se2.exp(a), se2.exp(b)))
        return float(np.linalg.norm(both - (a + b + bracket / 2)))

    assert 7 < left(0.1) / left(0.05) < 9
    np.testing.assert_allclose(se3.log(se3.exp(XI)), XI)


@pytest.mark.parametrize(("integral", "error"), [(0.0, 0.25), (3.0, 0.0)])
def test_l3_the_integral_of_pid_removes_a_constant_error(integral: float, error: float) -> None:
    """A mass pushed by the disturbance 2 and held at 0 with k_P = 8."""
    x = v = total = 0.0
    for _ in range(200_000):
        total += -x * 1e-3
        v += (8.0 * -x + integral * total + 4.0 * -v + 2.0) * 1e-3
        x += v * 1e-3
    assert x == pytest.approx(error, abs=1e-6)


@pytest.mark.parametrize(("a", "q", "p"), [(0.0, 1.0, 1.0), (1.0, 3.0, 3.0)])
def test_l3_riccati_has_a_zero_on_its_left(a: float, q: float, p: float) -> None:
    assert solve_continuous_are(a * ONE, ONE, q * ONE, ONE)[0, 0] == pytest.approx(p)
    assert 2 * a * p - p**2 + q == 0
    assert a == 0 or a - p == -2


def test_l3_the_attitude_error_about_one_axis_is_the_sine() -> None:
    turned = se3.exp([0, 0, 0, 0, 0, 0.3])[:, :3]
    assert (turned - turned.T)[1, 0] / 2 == pytest.approx(np.sin(0.3))


def test_l4_minimum_snap_has_degree_seven() -> None:
    """Between rests at 0 and 1; the eighth derivative is 0 (Euler–Lagrange)."""
    snap = np.polynomial.Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
    ends = [[snap.deriv(k)(end) if k else snap(end) for k in range(4)] for end in (0, 1)]
    np.testing.assert_allclose(ends, [[0, 0, 0, 0], [1, 0, 0, 0]], atol=1e-12)
    assert not np.any(snap.deriv(8).coef)


def test_l5_the_pixel_by_hand() -> None:
    seen = K @ [1, 0.5, 5]
    np.testing.assert_allclose(seen, [2100, 1450, 5])
    np.testing.assert_allclose(seen / 5, [420, 290, 1])
    np.testing.assert_allclose(K @ [2, 1, 10] / 10, [420, 290, 1])


@pytest.mark.parametrize(("a", "b", "sign"), [(4, 4, 1), (4, 0, -1)])
def test_l6_harris_is_positive_at_corners_and_negative_on_edges(a, b, sign) -> None:
    m = np.diag([a, b])
    assert np.sign(np.linalg.det(m) - 0.05 * np.trace(m) ** 2) == sign


def test_l6_a_difference_of_gaussians_is_nearly_a_laplacian() -> None:
    image = np.random.default_rng(0).normal(size=(80, 80))
    image, sigma, k = gaussian_filter(image, 3.0), 2.0, 1.02
    there = gaussian_filter(image, k * sigma) - gaussian_filter(image, sigma)
    here = (k - 1) * sigma**2 * gaussian_laplace(image, sigma)
    assert np.linalg.norm(there - here) < 0.03 * np.linalg.norm(here)
    assert "4\\cdot4\\cdot8 = 128" in PAGE and 4 * 4 * 8 == 128


def test_l6_klt_finds_the_shift() -> None:
    x = np.indices((7, 7)).reshape(2, -1).T - 3
    shift = np.array([0.3, -0.2])
    change = np.sum((x - shift) ** 2, axis=1) - np.sum(x**2, axis=1)
    np.testing.assert_allclose(np.linalg.solve(4 * x.T @ x, -(2 * x).T @ change), shift)


def test_l7_eight_matches_give_the_essential_matrix() -> None:
    rotation, t, one, two = two_views()
    essential = cross(t) @ rotation
    x1, x2 = one / one[:, 2:], two / two[:, 2:]
    assert np.max(np.abs(np.sum(x2 @ essential * x1, axis=1))) < 1e-12
    rows = np.stack([np.kron(b, a) for a, b in zip(x1, x2, strict=True)])
    found = np.linalg.svd(rows)[2][-1].reshape(3, 3)
    found *= np.sign(np.sum(found * essential))
    np.testing.assert_allclose(found, essential / np.linalg.norm(essential), atol=1e-8)
    size = np.linalg.norm(t)
    np.testing.assert_allclose(np.linalg.svd(essential)[1], [size, size, 0], atol=1e-12)


def test_l7_two_views_triangulate_a_point() -> None:
    rotation, t, one, _ = two_views()
    equations = []
    for camera in (np.eye(3, 4), np.column_stack([rotation, t])):
        p = K @ camera
        u, v, depth = p @ [*one[0], 1.0]
        equations += [u / depth * p[2] - p[0], v / depth * p[2] - p[1]]
    point = np.linalg.svd(equations)[2][-1]
    np.testing.assert_allclose(point[:3] / point[3], one[0])


def test_l9_and_l13_the_normal_matrix() -> None:
    rng = np.random.default_rng(0)
    jacobian, r = rng.normal(size=(9, 4)), rng.normal(size=9)
    omega = np.diag(rng.uniform(1, 4, 9))
    h = jacobian.T @ omega @ jacobian
    delta = -np.linalg.solve(h, jacobian.T @ omega @ r)
    np.testing.assert_allclose(jacobian.T @ omega @ (r + jacobian @ delta), 0, atol=1e-12)
    reduced = h[:2, :2] - h[:2, 2:] @ np.linalg.solve(h[2:, 2:], h[2:, :2])
    np.testing.assert_allclose(np.linalg.inv(reduced), np.linalg.inv(h)[:2, :2])


def test_l10_a_step_on_the_right_is_another_on_the_left() -> None:
    pose, step = se3.exp(XI), np.array([0.01, 0.02, 0.0, 0.0, 0.01, 0.03])
    right = se3.compose(pose, se3.exp(step))
    left = se3.compose(se3.exp(se3.adjoint(pose) @ step), pose)
    np.testing.assert_allclose(right, left)


def test_l11_preintegration_of_a_constant_acceleration() -> None:
    dt, accelerations = 0.01, np.tile([2.0, 0.0, 0.0], (100, 1))
    for rate in (0.0, 0.5):
        turn, v, p = np.eye(3), np.zeros(3), np.zeros(3)
        for a in accelerations:
            p = p + v * dt + 0.5 * turn @ a * dt**2
            v = v + turn @ a * dt
            turn = turn @ se3.exp(np.array([0, 0, 0, 0, 0, rate * dt]))[:, :3]
        np.testing.assert_allclose(turn, se3.exp([0, 0, 0, 0, 0, rate])[:, :3], atol=1e-12)
        if not rate:
            np.testing.assert_allclose([*v, *p], [2, 0, 0, 1, 0, 0], atol=1e-12)


def test_l12_words_trees_and_false_positives() -> None:
    assert 3 / 100 * np.log(1000 / 1000) == 0
    assert 10**6 == 1_000_000 and 10 * 6 == 60
    assert round(0.01 * 0.9 / (0.01 * 0.9 + 0.99 * 0.01), 3) == 0.476


def test_l13_a_new_factor_changes_the_last_rows_alone() -> None:
    """A chain of six numbers, and a factor between the last two."""
    h = np.diag([2.0, 2, 2, 2, 2, 1]) - np.eye(6, k=1) - np.eye(6, k=-1) + np.eye(6) * 0.1
    new = np.zeros(6)
    new[4:] = -1, 1
    before, after = (np.linalg.cholesky(m).T for m in (h, h + np.outer(new, new)))
    changed = np.any(~np.isclose(before, after), axis=1)
    assert changed.tolist() == [False] * 4 + [True] * 2


def test_l14_the_kernels_as_printed() -> None:
    u, k, c = np.linspace(1.1, 9, 80), 1.0, 2.0
    table = [  # beyond Huber's threshold
        (k * u - k**2 / 2, k / u, kernels.huber(k)),
        (c**2 / 2 * np.log(1 + u**2 / c**2), 1 / (1 + u**2 / c**2), kernels.cauchy(c)),
        (c**2 * u**2 / (c**2 + u**2) / 2, c**4 / (c**2 + u**2) ** 2, kernels.geman_mcclure(c)),
        (c**2 / 2 * (1 - np.exp(-(u**2) / c**2)), np.exp(-(u**2) / c**2), kernels.welsch(c)),
        (np.minimum(u**2, c**2) / 2, np.where(u <= c, 1.0, 0.0), kernels.tls(c)),
    ]
    for rho, weight, kernel in table:
        np.testing.assert_allclose(rho, kernel.rho(u))
        np.testing.assert_allclose(weight, kernel.weight(u))
        np.testing.assert_allclose(weight, kernel.psi(u) / u)
    slope = np.gradient(kernels.cauchy(c).psi(u), u)
    np.testing.assert_array_equal((slope < 0)[np.abs(u - c) > 0.2], (u > c)[np.abs(u - c) > 0.2])


@pytest.mark.parametrize(("chi2", "penalty"), [(5.0, 2.0), (0.3, 1.0)])
def test_l14_the_best_switch_costs_geman_mcclure(chi2: float, penalty: float) -> None:
    s = np.linspace(0, 1, 100_001)
    cost = (s**2 * chi2 + penalty * (1 - s) ** 2) / 2
    assert s[cost.argmin()] == pytest.approx(penalty / (penalty + chi2), abs=1e-5)
    kernel = kernels.geman_mcclure(np.sqrt(penalty))
    assert cost.min() == pytest.approx(float(kernel.rho(np.sqrt(chi2))))


@pytest.mark.parametrize("u", [0.6, 0.9, 1.5])
def test_l14_the_weights_of_gnc(u: float) -> None:
    mu, c = 0.5, 1.0
    assert mu / (mu + 1) * c**2 < u**2 < (mu + 1) / mu * c**2
    w = np.linspace(0, 1, 200_001)
    cost = w * u**2 + mu * (1 - w) / (mu + w) * c**2
    printed = c / u * np.sqrt(mu * (mu + 1)) - mu
    assert w[cost.argmin()] == pytest.approx(printed, abs=1e-5)
    mu = 4.0
    cost = w * u**2 + mu * c**2 * (np.sqrt(w) - 1) ** 2
    printed = (mu * c**2 / (u**2 + mu * c**2)) ** 2
    assert w[cost.argmin()] == pytest.approx(printed, abs=1e-5)


@pytest.mark.parametrize(("u_max", "c"), [(7.5, 2.0), (100.0, 3.368)])
def test_l14_the_first_mu(u_max: float, c: float) -> None:
    assert start_mu(u_max, c) == pytest.approx(c**2 / (2 * u_max**2 - c**2))
    assert start_mu(u_max, c, "gm") == pytest.approx(2 * u_max**2 / c**2)


def test_l14_the_least_over_the_weight_is_the_cost() -> None:
    """The penalty of TLS is that of its family for large μ."""
    w = np.linspace(0, 1, 10_001)
    for u in (0.5, 1.9, 2.1, 9.0):
        least = np.min(w * u**2 / 2 + tls_process(w, 2.0, 1e9))
        assert least == pytest.approx(float(kernels.tls(2.0).rho(u)), abs=1e-6)


def test_l14_the_switch_of_dcs() -> None:
    chi2, phi = np.linspace(0, 30, 50), 4.0
    np.testing.assert_allclose(dcs_switch(chi2, phi), np.minimum(1, 2 * phi / (phi + chi2)))
    np.testing.assert_allclose(kernels.dcs(2.0).weight(np.sqrt(chi2)), dcs_switch(chi2, phi) ** 2)
