"""The pictures of assignment 08 draw what a student's functions return, beside the truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam import descent as solver
from robust_slam.estimators import graduation
from robust_slam.graphs import metrics, pose_graph, se2
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.problems import PoseGraphProblem
from robust_slam_course.exercises import showcase


def residuals(poses, graph):
    return pose_graph.residuals(PoseGraph(**graph), np.asarray(poses))


def jacobians(i, j, z):
    edge = PoseGraph(2, [[0, 1]], z[None], np.eye(3)[None], [True])
    by_i, by_j = pose_graph.jacobians(edge, np.stack([i, j]))
    return by_i[0], by_j[0]


def gauss_newton(graph, poses, weights, tol):
    return solver.gauss_newton(PoseGraph(**graph), poses, weights, tol=tol)


def robust_solve(graph, c, solve):
    result = graduation.gnc(PoseGraphProblem(PoseGraph(**graph)), c)
    poses, norms = solve(graph, result.weights, result.x)
    assert norms.shape == result.weights.shape
    np.testing.assert_allclose(solve(graph, result.weights, None)[0], poses, atol=1e-6)
    return poses, result.weights


RIGHT: dict[str, Callable[..., object]] = {
    "between": se2.between,
    "residuals": residuals,
    "jacobians": jacobians,
    "gauss_newton": gauss_newton,
    "robust_solve": robust_solve,
    "precision_recall": metrics.precision_recall,
    "ate": metrics.ate,
}


def drawn(name: str, student: Callable[..., object] | None = None) -> Figure:
    figure = getattr(showcase, name)(student or RIGHT[name])
    assert isinstance(figure, Figure)
    return figure


def labelled(figure: Figure, label: str) -> list[np.ndarray]:
    lines = [line for ax in figure.axes for line in ax.lines]
    return [np.asarray(line.get_xydata()) for line in lines if line.get_label() == label]


@pytest.mark.parametrize("name", ["between", "gauss_newton", "precision_recall", "ate"])
def test_a_right_function_lies_on_the_truth(name: str) -> None:
    figure = drawn(name)
    truth, yours = labelled(figure, "the truth"), labelled(figure, "yours")
    assert len(truth) == len(yours) == (2 if name == "precision_recall" else 1)
    np.testing.assert_allclose(yours, truth, atol=1e-6)


def test_right_residuals_stand_on_top_of_the_bars() -> None:
    figure = drawn("residuals")
    (yours,) = labelled(figure, "yours")
    tops = [bar.get_height() for bar in figure.axes[0].patches]
    np.testing.assert_allclose(yours[:, 1], tops, atol=1e-9)


def test_a_right_slope_touches_its_curve() -> None:
    for ax in drawn("jacobians").axes:
        for curve, line in zip(ax.lines[::2], ax.lines[1::2], strict=True):
            gap = np.abs(curve.get_ydata() - line.get_ydata())
            assert gap[20] < 1e-12
            assert gap[19:22].max() < 2e-3


def test_a_right_loop_keeps_no_lie() -> None:
    (legend,) = [ax.get_legend() for ax in drawn("robust_solve").axes]
    words = {text.get_text().partition(" (")[0] for text in legend.get_texts()}
    assert "wrong, rejected" in words
    assert "wrong, kept" not in words


def test_a_wrong_function_leaves_the_truth() -> None:
    figure = drawn("ate", lambda one, two: float(np.abs(one - two).max()))
    (truth,), (yours,) = labelled(figure, "the truth"), labelled(figure, "yours")
    assert np.abs(truth - yours).max() > 1.0
