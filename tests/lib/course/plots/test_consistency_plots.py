"""What a drawn consistency graph shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.consistency import draw_consistency, draw_ranges

A = np.array([[1, 1, 1, 0], [1, 1, 1, 0], [1, 1, 1, 1], [0, 0, 1, 1]], dtype=bool)


def pairs(line) -> int:
    return int(np.count_nonzero(np.isnan(np.asarray(line.get_xdata(), dtype=float))))


def test_every_pair_that_agrees_is_a_line_and_the_clique_is_apart(ax) -> None:
    draw_consistency(ax, A, [0, 1, 2], is_outlier=[False, False, False, True])
    others, clique = ax.lines[:2]
    assert pairs(others) == 1
    assert pairs(clique) == 3
    assert clique.get_linewidth() > others.get_linewidth()
    assert clique.get_linestyle() == others.get_linestyle() == "-"


def test_members_are_filled_and_lies_are_crosses(ax) -> None:
    draw_consistency(ax, A, [0, 1], is_outlier=[False, True, False, True])
    looks = {
        (line.get_marker(), line.get_markerfacecolor() == "white"): len(line.get_xdata())
        for line in ax.lines[2:]
    }
    assert looks == {("o", False): 1, ("o", True): 1, ("X", False): 1, ("X", True): 1}


def test_names_stand_clockwise_from_the_top(ax) -> None:
    draw_consistency(ax, A, names="ABCD")
    assert [text.get_text() for text in ax.texts] == ["A", "B", "C", "D"]
    (x0, y0), (x1, y1) = (text.get_position() for text in ax.texts[:2])
    assert y0 > 1.0 > abs(x0)
    assert x1 > 1.0 > abs(y1)


def test_a_graph_that_is_not_square_or_has_other_names_is_refused(ax) -> None:
    with pytest.raises(ValueError, match="adjacency"):
        draw_consistency(ax, A[:3])
    with pytest.raises(ValueError, match="names"):
        draw_consistency(ax, A, names="AB")


def test_ranges_are_circles_around_their_places(ax) -> None:
    draw_ranges(ax, [[0.0, 0.0], [4.0, 0.0]], [2.1, 2.5], [2.0, 0.0])
    circles = [(patch.center, patch.radius) for patch in ax.patches]
    assert circles == [((0.0, 0.0), 2.1), ((4.0, 0.0), 2.5)]
    np.testing.assert_array_equal(ax.lines[1].get_xydata(), [[2.0, 0.0]])
    with pytest.raises(ValueError, match="ranges"):
        draw_ranges(ax, [[0.0, 0.0]], [1.0, 2.0], [0.0, 0.0])
