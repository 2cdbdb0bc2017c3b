"""The pictures of assignment 06 draw what a student's functions return, beside the truth."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure
from robust_slam.consistency import cliques, pairwise
from robust_slam.estimators import switches
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam_course.exercises import switches_and_consistency as pictures


def max_mixture_mode(r, sigma_in, sigma_out, pi_in):
    inlier = np.log(pi_in / sigma_in) - (r / sigma_in) ** 2 / 2
    return np.log((1 - pi_in) / sigma_out) - (r / sigma_out) ** 2 / 2 > inlier


def solve_switchable(z, sigma, is_loop, lam):
    s = np.ones(len(z))
    for _ in range(200):
        x = np.average(z, weights=(s / sigma) ** 2)
        s = np.where(is_loop, switches.switch(((z - x) / sigma) ** 2, lam), 1.0)
    return x, s


def pairwise_consistent(odometry, odometry_cov, ends, loops, loop_cov, gamma):
    n = len(odometry) + 1
    steps = np.column_stack([np.arange(n - 1), np.arange(1, n)])
    graph = PoseGraph(
        n,
        np.vstack([steps, ends]),
        np.vstack([odometry, loops]),
        np.linalg.inv(np.concatenate([odometry_cov, loop_cov])),
        np.arange(n - 1 + len(ends)) < n - 1,
    )
    return pairwise.pairwise_consistent(graph, gamma)


RIGHT: dict[str, tuple[Callable[..., object], ...]] = {
    "switch": (switches.switch, switches.switched_cost),
    "switch_weight": (lambda chi2, lam: switches.switch(chi2, lam) ** 2,),
    "dcs_switch": (switches.dcs_switch,),
    "max_mixture_mode": (max_mixture_mode,),
    "solve_switchable": (solve_switchable,),
    "largest_consistent_set": (lambda A: cliques.max_clique(A).members.tolist(),),
    "pairwise_consistent": (pairwise_consistent,),
}


def drawn(name: str, *students: Callable[..., object]) -> Figure:
    figure = getattr(pictures, name)(*(students or RIGHT[name]))
    assert isinstance(figure, Figure)
    return figure


def labelled(figure: Figure, label: str) -> list[np.ndarray]:
    lines = [line for ax in figure.axes for line in ax.lines]
    return [np.asarray(line.get_xydata()) for line in lines if line.get_label() == label]


@pytest.mark.parametrize("name", RIGHT)
def test_a_right_answer_is_drawn_with_a_title_and_named_axes(name: str) -> None:
    figure = drawn(name)
    assert any(ax.get_title() for ax in figure.axes)
    assert all(ax.get_ylabel() or not ax.axison for ax in figure.axes)
    assert labelled(figure, "yours")


@pytest.mark.parametrize("name", ["switch", "switch_weight", "dcs_switch"])
def test_a_right_curve_lies_on_the_truth(name: str) -> None:
    figure = drawn(name)
    for yours, truth in zip(labelled(figure, "yours"), labelled(figure, "the truth"), strict=True):
        np.testing.assert_allclose(yours, truth, rtol=1e-12)


def test_the_mode_that_is_said_to_count_is_marked() -> None:
    (right,) = labelled(drawn("max_mixture_mode"), "yours")
    (truth,) = labelled(drawn("max_mixture_mode"), "the truth")
    np.testing.assert_allclose(right, truth)
    (always_in,) = labelled(drawn("max_mixture_mode", lambda r, *_: 0 * r), "yours")
    assert always_in[0, 1] < truth[0, 1]


def test_a_right_solve_stands_lowest_in_the_valley() -> None:
    figure = drawn("solve_switchable")
    (yours,) = labelled(figure, "yours")
    x, cost = yours[0]
    (valley,) = labelled(figure, "the truth")
    assert cost <= valley[:, 1].min()
    assert abs(x - valley[np.argmin(valley[:, 1]), 0]) < 0.05


def test_only_a_wrong_pair_is_crossed_out() -> None:
    assert not labelled(drawn("pairwise_consistent"), "not so")
    nobody = drawn("pairwise_consistent", lambda *arrays: np.eye(len(arrays[2])))
    (crossed,) = labelled(nobody, "not so")
    assert len(crossed) > 20


def test_the_members_that_are_said_are_marked() -> None:
    (four,) = labelled(drawn("largest_consistent_set"), "yours")
    (two,) = labelled(drawn("largest_consistent_set", lambda A: [0, 1]), "yours")
    assert len(four) == 4
    assert len(two) == 2
