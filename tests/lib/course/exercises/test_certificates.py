"""The pictures of 07-certificates: drawn with right functions, a sentence with unfinished ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from robust_slam.certificates import sdp
from robust_slam_course.exercises import certificates

pytest.importorskip("cvxpy")


def connection_matrix(n, i, j, measured, kappa):
    return sdp.connection_matrix(n, np.column_stack([i, j]), measured, kappa)


def certificate(Q, R):
    S, eigenvalues = sdp.dense_certificate(Q, R)
    return S, eigenvalues[0]


def verdict(Q, R, tol):
    S, lowest = certificate(Q, R)
    small = tol * np.linalg.norm(Q, 2)
    if np.abs(S @ R.T).max() > small:
        return "not stationary"
    return "certified" if lowest >= -small else "not certified"


RIGHT: dict[str, Callable[..., object]] = {
    "connection_matrix": connection_matrix,
    "solve_sdp": lambda Q, n, d: sdp.solve_sdp(Q, d).Z.tolist(),
    "round_solution": lambda Z, n, d: sdp.round_solution(Z, d),
    "is_tight": sdp.is_tight,
    "certificate": certificate,
    "verdict": verdict,
    "suboptimality": sdp.suboptimality,
}


def named(ax: Axes, label: str) -> np.ndarray:
    """The points (2, k) of the line of this name."""
    (line,) = [line for line in ax.lines if line.get_label() == label]
    return np.asarray(line.get_xydata()).T


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_function_is_drawn(name: str) -> None:
    assert isinstance(getattr(certificates, name)(RIGHT[name]), Figure)


def test_both_matrices_are_the_same_field_of_colours() -> None:
    yours, truth = certificates.connection_matrix(connection_matrix).axes
    np.testing.assert_allclose(yours.images[0].get_array(), truth.images[0].get_array())


def test_the_relaxation_meets_the_best_rotations_of_a_ring_and_not_of_the_pair() -> None:
    ring, pair = certificates.solve_sdp(RIGHT["solve_sdp"]).axes
    x, value = named(ring, "your value")
    np.testing.assert_allclose(value, np.interp(x, *named(ring, "best rotations")), atol=2e-3)
    x, value = named(pair, "your value")
    gap = named(pair, "best rotations")[1] - value
    np.testing.assert_allclose(gap, 4.0 * np.maximum(1.0 - x, 0.0), atol=1e-4)


def test_rounded_axes_lie_on_the_true_ones() -> None:
    (ax,) = certificates.round_solution(RIGHT["round_solution"]).axes
    for name in "xy":
        yours, truth = named(ax, f"your {name} axis"), named(ax, f"true {name} axis")
        np.testing.assert_allclose(yours, truth, atol=1e-6)


def test_little_noise_is_tight_and_some_great_noise_is_not() -> None:
    (ax,) = certificates.is_tight(sdp.is_tight).axes
    np.testing.assert_array_equal(named(ax, "yours: True"), named(ax, "tight"))
    assert named(ax, "yours: True")[0].min() < 0.1
    assert named(ax, "yours: False")[0].min() > 0.5


def test_a_twisted_ring_has_an_eigenvalue_below_zero_and_the_best_has_none() -> None:
    best, twisted = certificates.certificate(certificate).axes
    for ax in (best, twisted):
        np.testing.assert_allclose(named(ax, "yours"), named(ax, "the truth"), atol=1e-9)
    assert named(best, "yours")[1].min() >= -1e-9
    assert named(twisted, "yours")[1].min() < -0.5


def test_another_verdict_than_the_truth_is_framed() -> None:
    (ax,) = certificates.verdict(verdict).axes
    assert "the truth is another" not in ax.get_legend_handles_labels()[1]
    np.testing.assert_allclose(named(ax, "yours: certified"), [[0.0], [0.0]], atol=1e-12)
    np.testing.assert_allclose(named(ax, "yours: not certified")[0], [5 / 6, 1.0, 2.0])
    (ax,) = certificates.verdict(lambda Q, R, tol: "certified").axes
    assert named(ax, "the truth is another").shape == (2, 11)


def test_the_bound_is_the_gap_of_the_twisted_ring() -> None:
    (ax,) = certificates.suboptimality(sdp.suboptimality).axes
    twist, bound = named(ax, "your bound")
    gap = named(ax, "the gap")[1]
    assert np.all(gap <= bound + 1e-9)
    at = np.argmin(np.abs(twist - 1.0))
    np.testing.assert_allclose([bound[at], gap[at]], 13.819660, atol=1e-6)
