"""What the drawn fleet shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.lines import Line2D
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam_course.plots.robots import draw_robots

LABELS = np.array([0, 0, 0, 1, 1, 1])
POSES = np.array([[k % 3, 2.0 * (k // 3), 0.0] for k in range(6)])
EDGES = [[0, 1], [1, 2], [3, 4], [4, 5], [0, 3], [1, 4], [2, 4], [0, 2]]
GRAPH = PoseGraph(6, EDGES, np.zeros((8, 3)), [np.eye(3)] * 8, np.arange(8) < 4)
WEIGHTS = np.array([1, 1, 1, 1, 1, 0.3, 0, 0.2])
OUTLIERS = np.arange(8) == 6


@pytest.fixture
def lines(ax) -> dict[str, Line2D]:
    draw_robots(ax, GRAPH, POSES, LABELS, WEIGHTS, is_outlier=OUTLIERS)
    return {str(line.get_label()): line for line in ax.lines}


def test_each_robot_has_a_look_of_its_own(lines) -> None:
    one, two = lines["robot A"], lines["robot B"]
    np.testing.assert_array_equal(one.get_xydata(), POSES[:3, :2])
    assert one.get_marker() != two.get_marker()
    assert one.get_color() != two.get_color()


def test_rings_are_on_the_boundary_and_nowhere_else(lines) -> None:
    np.testing.assert_array_equal(lines["boundary pose"].get_xydata(), POSES[[0, 1, 2, 3, 4], :2])


def test_shared_closures_are_counted_by_what_is_thought_of_them(lines) -> None:
    assert {"trusted (1)", "in doubt (1)", "rejected (1)", "wrong (1)"} <= set(lines)
    np.testing.assert_array_equal(
        np.asarray(lines["trusted (1)"].get_xydata())[:2], POSES[[0, 3], :2]
    )
    middle = POSES[[2, 4], :2].mean(axis=0)
    np.testing.assert_array_equal(lines["wrong (1)"].get_xydata(), [middle])


def test_there_are_not_looks_for_any_number_of_robots(ax) -> None:
    with pytest.raises(ValueError, match="6 robots"):
        draw_robots(ax, GRAPH, POSES, np.arange(6), WEIGHTS, is_outlier=OUTLIERS)
