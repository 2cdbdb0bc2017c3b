"""What a drawn sweep shows, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from robust_slam_course.plots.sweeps import draw_sweep

SCORES = {
    "bold": [[1.0, 2.0], [3.0, 2.0], [8.0, 5.0]],
    "shy": [[4.0, 4.0], [4.0, 4.0], [4.0, 9.0]],
}


def test_lines_go_through_the_medians_and_bars_from_best_to_worst(ax) -> None:
    draw_sweep(ax, ["few", "many"], SCORES)
    for line, bars, runs in zip(ax.lines, ax.collections, SCORES.values(), strict=True):
        assert line.get_ydata().tolist() == np.median(runs, axis=0).tolist()
        spans = np.array([segment[:, 1] for segment in bars.get_segments()])
        assert spans.tolist() == np.stack([np.min(runs, axis=0), np.max(runs, axis=0)], 1).tolist()
        assert [segment[0, 0] for segment in bars.get_segments()] == line.get_xdata().tolist()


def test_methods_differ_in_place_colour_line_and_marker(ax) -> None:
    draw_sweep(ax, ["few", "many"], SCORES)
    one, two = ax.lines
    assert one.get_label() == "bold"
    assert one.get_color() != two.get_color()
    assert one.get_linestyle() != two.get_linestyle()
    assert one.get_marker() != two.get_marker()
    assert np.all(one.get_xdata() < two.get_xdata())
    assert np.all(np.round(two.get_xdata()) == [0, 1])


def test_levels_are_named_and_the_axis_is_logarithmic(ax) -> None:
    draw_sweep(ax, ["few", "many"], SCORES)
    assert [label.get_text() for label in ax.get_xticklabels()] == ["few", "many"]
    assert ax.get_yscale() == "log"


def test_scores_that_do_not_fit_are_refused(ax) -> None:
    with pytest.raises(ValueError, match="bold"):
        draw_sweep(ax, ["one"], SCORES)
    with pytest.raises(ValueError, match="9 methods"):
        draw_sweep(ax, ["one"], {str(k): [[1.0]] for k in range(9)})
