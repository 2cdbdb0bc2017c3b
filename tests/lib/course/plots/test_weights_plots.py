"""What a drawn history of weights shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.kernels import cauchy
from robust_slam.estimators.reweighting import irls
from robust_slam.problems import LocationProblem
from robust_slam_course.plots.weights import draw_weight_history

Z = (-0.2, 0.1, 0.4, 10.0)
LIE = [False, False, False, True]


def heights(line) -> np.ndarray:
    """The weights (k, steps) of a line in which a NaN ends each of the k."""
    y = np.asarray(line.get_ydata())
    return y.reshape(np.count_nonzero(np.isnan(y)), -1)[:, :-1]


def test_every_weight_of_every_step_is_drawn_lies_apart(ax) -> None:
    result = gnc(LocationProblem(Z), 2.0, "gm")
    draw_weight_history(ax, result.history, LIE)
    weights = np.array([step.weights for step in result.history])
    inlier, outlier = ax.lines
    np.testing.assert_array_equal(heights(inlier), weights[:, :3].T)
    np.testing.assert_array_equal(heights(outlier), weights[:, 3:].T)
    assert inlier.get_linestyle() != outlier.get_linestyle()
    assert inlier.get_marker() != outlier.get_marker()
    assert [line.get_label() for line in ax.lines] == ["inliers (3)", "outliers (1)"]


def test_under_each_step_stands_its_mu(ax) -> None:
    result = gnc(LocationProblem(Z), 2.0)
    draw_weight_history(ax, result.history, LIE)
    names = [label.get_text() for label in ax.get_xticklabels()]
    assert names == ["0\nμ", *(f"{k}\n{s.mu:.2g}" for k, s in enumerate(result.history[1:], 1))]


def test_a_rule_without_mu_has_plain_steps_and_long_histories_fewer_ticks(ax) -> None:
    result = irls(LocationProblem(Z), cauchy(1.0))
    draw_weight_history(ax, result.history)
    names = [label.get_text() for label in ax.get_xticklabels()]
    assert names[0] == "0"
    assert len(names) <= 8 < len(result.history)


def test_only_what_is_asked_for_is_drawn(ax) -> None:
    result = gnc(LocationProblem(Z), 2.0)
    draw_weight_history(ax, result.history, LIE, shown=[True, False, False, False])
    (line,) = ax.lines
    assert line.get_label() == "inliers (1)"
    with pytest.raises(ValueError, match=r"shown: the shape is \(1,\); give \(4,\)"):
        draw_weight_history(ax, result.history, shown=[True])
