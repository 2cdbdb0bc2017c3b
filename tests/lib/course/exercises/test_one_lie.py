"""The pictures of assignment 00 draw what a student's functions return, beside the truth."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.problems import chain
from robust_slam_course.exercises import one_lie


def total_cost(x, i, j, z, sigma):
    return float(np.sum(chain(len(x), i, j, z, sigma).residuals(np.asarray(x)) ** 2))


def normal_equations(n, i, j, z, sigma):
    J = np.eye(n)[j] - np.eye(n)[i]
    return (J.T / np.square(sigma)) @ J, (J.T / np.square(sigma)) @ z


def solve_anchored(n, i, j, z, sigma, anchor=0):
    return list(chain(n, i, j, z, sigma, anchor).initial())


def strained_edges(residuals, tol):
    return [bool(abs(u) > tol) for u in residuals]


RIGHT = [total_cost, normal_equations, solve_anchored, strained_edges]


@pytest.mark.parametrize("student", RIGHT, ids=lambda student: student.__name__)
def test_a_picture_says_what_to_look_for_and_whose_is_what(student):
    figure = getattr(one_lie, student.__name__)(student)
    figure.draw_without_rendering()
    said = [text.get_text() for ax in figure.axes for text in ax.texts]
    titles = [ax.get_title(loc) for ax in figure.axes for loc in ("left", "center")]
    labels = [label for ax in figure.axes for label in ax.get_legend_handles_labels()[1]]
    assert any(titles)
    assert any("you" in one for one in titles + labels + said)


def test_the_cost_that_a_student_forgot_to_double_lies_below_the_truth():
    ax = one_lie.total_cost(lambda *args: 0.5 * total_cost(*args)).axes[0]
    truth, yours, lowest, true_map = (line.get_ydata() for line in ax.lines)
    np.testing.assert_allclose(yours, 0.5 * np.asarray(truth))
    assert lowest == pytest.approx(np.min(truth), rel=1e-3)
    assert true_map == pytest.approx(np.interp(2.0, ax.lines[0].get_xdata(), truth))


def test_only_the_entries_that_differ_are_framed():
    def anchored(*args):
        H, b = normal_equations(*args)
        return H + np.diag([1.0, 0.0, 0.0]), b

    truth, yours = one_lie.normal_equations(anchored).axes
    assert not truth.patches
    assert [frame.get_xy() for frame in yours.patches] == [(-0.45, -0.45)]
    assert [text.get_text() for text in yours.texts[:3]] == ["901", "−100", "−800"]


def test_the_student_map_stands_over_the_places_of_the_truth():
    _, yours = one_lie.solve_anchored(lambda n, *edges: np.arange(n)).axes
    np.testing.assert_allclose(yours.lines[5].get_xdata(), np.arange(5))
    bars = [line.get_xdata()[0] for line in yours.lines[6:]]
    np.testing.assert_allclose(bars, [0, 1, 10 / 9, 11 / 9, 20 / 9])


def test_an_edge_that_is_not_called_strained_gets_no_cross():
    ax = one_lie.strained_edges(lambda u, tol: np.asarray(u) > tol).axes[0]
    (crosses,) = ax.lines
    assert list(crosses.get_xdata()) == [11]
