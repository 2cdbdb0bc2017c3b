"""The pictures of assignment 02 draw what a student's functions return, beside the truth."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators import kernels
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam_course.exercises import four_costs


def curves(make):
    """A kernel's three functions as a student hands them in."""
    return [
        lambda u, c: make(c).rho(u),
        lambda u, c: make(c).psi(u),
        lambda u, c: list(make(c).weight(u)),
    ]


def table(c):
    chosen = [kernels.KERNELS[name](c) for name in ("squared", "huber", "cauchy", "tls")]
    costs = [[float(one.rho(u)) for u in (1.0, 10.0)] for one in chosen]
    return [
        [near, far, far / near, float(one.weight(10.0))]
        for one, (near, far) in zip(chosen, costs, strict=True)
    ]


def convex_until(rho, lo, hi):
    u = np.linspace(lo, hi, 2001)
    bent = np.gradient(np.gradient(rho(u), u), u)[2:-2] < 0
    return u[2:-2][np.argmax(bent)] if np.any(bent) else np.inf


RIGHT = {
    "rho_huber": curves(kernels.huber),
    "rho_cauchy": curves(kernels.cauchy),
    "rho_tls": curves(kernels.tls)[::2],
    "table": [table],
    "convex_until": [convex_until],
    "threshold": [chi_square_threshold],
}


def drawn(name, *students):
    figure = getattr(four_costs, name)(*students)
    figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize("name", RIGHT)
def test_a_picture_has_a_title_labelled_axes_and_a_legend(name):
    axes = drawn(name, *RIGHT[name]).axes
    assert axes[0].get_title()
    assert all(ax.get_ylabel() for ax in axes)
    assert axes[-1].get_xlabel()
    assert any(ax.get_legend() for ax in axes)


@pytest.mark.parametrize("name", ["rho_huber", "rho_cauchy", "rho_tls"])
def test_a_right_curve_lies_on_the_truth_and_a_wrong_one_beside_it(name):
    for ax in drawn(name, *RIGHT[name]).axes:
        truth, yours = (line.get_ydata() for line in ax.lines[:2])
        np.testing.assert_allclose(yours, truth, atol=1e-12)
    signless = [lambda u, c: u * 0.7] * len(RIGHT[name])
    for ax in drawn(name, *signless).axes:
        truth, yours = (line.get_ydata() for line in ax.lines[:2])
        assert np.max(np.abs(np.asarray(yours) - truth)) > 0.1


def test_tls_without_the_half_is_no_error():
    rho, weight = RIGHT["rho_tls"]
    cost = drawn("rho_tls", lambda u, c: 2 * rho(u, c), weight).axes[0]
    truth, yours = (line.get_ydata() for line in cost.lines[:2])
    np.testing.assert_allclose(yours, truth)


def test_the_table_s_curves_are_its_two_last_columns():
    ratio, weight = drawn("table", table).axes
    thresholds = ratio.lines[5].get_xdata()
    np.testing.assert_allclose(ratio.lines[5].get_ydata(), [table(c)[2][2] for c in thresholds])
    np.testing.assert_allclose(weight.lines[5].get_ydata(), [table(c)[2][3] for c in thresholds])
    labels = [text.get_text() for text in weight.get_legend().get_texts()]
    assert labels.count("the truth") == 1
    assert len(labels) == 5


def test_a_turn_that_is_found_is_marked_and_one_that_is_not_is_left_out():
    ax = drawn("convex_until", lambda rho, lo, hi: 0.75).axes[0]
    assert [text.get_text() for text in ax.texts] == ["0.750"] * 3
    assert not drawn("convex_until", lambda rho, lo, hi: np.inf).axes[0].texts


def test_a_threshold_that_was_not_rooted_stands_far_right():
    ax = drawn("threshold", lambda p, d: chi_square_threshold(p, d) ** 2).axes[0]
    assert ax.get_xlim()[1] > 16
    np.testing.assert_allclose(ax.lines[-1].get_xdata(), [6.6349, 11.3449, 16.8119], rtol=1e-4)
