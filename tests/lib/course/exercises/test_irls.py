"""The pictures of assignment 03 draw what a student's functions return, beside the truth."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.exercises import irls as pictures


def irls_step(z, sigma, x, c):
    weights = 1 / (1 + ((z - x) / sigma / c) ** 2)
    return np.average(z, weights=weights), list(weights)


def irls(z, sigma, weight, x0, tol):
    history = [x0]
    for _ in range(80):
        history.append(np.average(z, weights=weight((z - history[-1]) / sigma)))
    return history[-1], history


def irls_tls(z, sigma, c, x0, tol):
    x = x0
    for _ in range(20):
        left = np.abs(z - x) <= c * sigma
        if not left.any():
            raise ValueError("no fit exists")
        x = np.mean(z[left])
    return x, left


def weighted_variance(weights, sigma):
    return sigma**2 / np.sum(weights)


RIGHT = [irls_step, irls, irls_tls, weighted_variance]


def drawn(student, name=""):
    figure = getattr(pictures, name or student.__name__)(student)
    figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize("student", RIGHT, ids=lambda student: student.__name__)
def test_a_picture_says_what_to_look_for_and_whose_is_what(student):
    figure = drawn(student)
    titles = [ax.get_title(loc) for ax in figure.axes for loc in ("left", "center")]
    labels = [label for ax in figure.axes for label in ax.get_legend_handles_labels()[1]]
    assert any(titles)
    assert figure.axes[-1].get_xlabel()
    assert any("your" in text for text in titles + labels)


def test_the_step_from_the_mean_ends_where_it_should():
    truth, yours = drawn(irls_step).axes
    assert truth.get_title("left") == "the truth: x goes from 0.99 to 0.1026"
    assert yours.get_title("left") == "yours: x goes from 0.99 to 0.1026"
    printed = drawn(lambda *args: (0.28, irls_step(*args)[1]), "irls_step").axes[1]
    assert printed.get_title("left").endswith("to 0.2800")


def test_both_descents_start_and_end_in_their_own_valleys():
    ax = drawn(irls).axes[0]
    visited = [line.get_xdata() for line in ax.lines if line.get_label().startswith("yours")]
    assert [path[0] for path in visited] == [pytest.approx(0.99), pytest.approx(4.6)]
    np.testing.assert_allclose([path[-1] for path in visited], [-0.000241046, 4.922390691], 1e-4)
    labels = ax.get_legend_handles_labels()[1]
    assert {"true end −0.0002", "true end 4.9224"} <= set(labels)


def test_a_start_without_a_fit_is_a_gap_in_both_lines():
    truth, yours = (np.asarray(line.get_ydata()) for line in drawn(irls_tls).axes[0].lines[:2])
    np.testing.assert_allclose(yours, truth, atol=1e-9)
    assert np.isnan(truth).any()
    assert set(np.round(truth[~np.isnan(truth)], 4)) == {-0.0125, 5.0}


def test_the_root_of_the_variance_lies_beside_the_truth():
    ax = drawn(lambda w, sigma: np.sqrt(weighted_variance(w, sigma)), "weighted_variance").axes[0]
    truth, yours = (np.asarray(line.get_ydata()) for line in ax.lines[:2])
    assert np.all(np.abs(yours - truth) > 0.01)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels.count("the truth") == 1
