"""What a drawn chain shows, and the picture of the README."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt
from matplotlib.colors import to_hex
from robust_slam.palette import PALETTE
from robust_slam_course.plots import opening
from robust_slam_course.plots.chain import draw_chain

PICTURE = Path(__file__).parents[4] / "chapters" / "assets" / "one-lie.svg"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")
COORDINATES = re.compile(r'(?:\sd|transform|\sx|\sy)="([^"]*)"')


def test_a_chain_draws_closures_above_outliers_below_and_odometry_on_the_line(ax) -> None:
    draw_chain(
        ax,
        [0, 1, 2],
        [(0, 1), (0, 2), (0, 2)],
        is_odometry=[True, False, False],
        is_outlier=[False, False, True],
        height=3.0,
    )
    middles = {to_hex(line.get_color()): line.get_ydata()[20] for line in ax.lines[:3]}
    assert middles[PALETTE["estimate"].lower()] == 3.0
    assert middles[PALETTE["inlier"].lower()] > 3.0
    assert middles[PALETTE["outlier"].lower()] < 3.0


def test_an_arc_ends_at_its_two_poses(ax) -> None:
    draw_chain(ax, [0.0, 0.5, 7.0], [(2, 0)], is_odometry=[False])
    x, y = ax.lines[0].get_data()
    assert (x[0], x[-1]) == pytest.approx((7.0, 0.0))
    assert (y[0], y[-1]) == pytest.approx((0.0, 0.0))


def test_a_chain_names_its_poses_from_one_unless_told_not_to(ax) -> None:
    edges = [(0, 1)]
    draw_chain(ax, [0, 1], edges, is_odometry=[True], labels=["says 1"])
    assert {text.get_text() for text in ax.texts} == {"says 1", "$x_1$", "$x_2$"}
    figure, other = plt.subplots()
    draw_chain(other, [0, 1], edges, is_odometry=[True], named=False)
    assert [text.get_text() for text in other.texts] == []
    plt.close(figure)


def coordinates(svg: str) -> np.ndarray:
    """Return every number of every path and position, in order."""
    return np.array([float(n) for text in COORDINATES.findall(svg) for n in NUMBER.findall(text)])


def test_the_readme_picture_is_what_the_library_draws(tmp_path: Path) -> None:
    opening.main([str(tmp_path / "new.svg")])
    drawn = coordinates((tmp_path / "new.svg").read_text(encoding="utf-8"))
    kept = coordinates(PICTURE.read_text(encoding="utf-8"))
    assert kept.size == drawn.size > 1000
    assert np.abs(kept - drawn).max() < 0.1  # points: a line's width is 2


def test_the_picture_is_small_and_stands_on_a_card_of_its_own() -> None:
    svg = PICTURE.read_text(encoding="utf-8")
    assert len(svg) < 40_000
    assert re.search(r'<g id="patch_1">\s*<path[^>]*fill: #ffffff', svg)


def test_the_picture_is_written_to_one_place() -> None:
    with pytest.raises(SystemExit, match=r"OUT\.svg"):
        opening.main([])
