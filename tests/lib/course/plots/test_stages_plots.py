"""What the drawn machine shows, read back from the axes."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyBboxPatch
from robust_slam_course.plots.stages import STAGES, draw_stages
from robust_slam_course.style import figure_style


@pytest.fixture
def ax() -> Iterator[Axes]:
    with figure_style():
        figure, axes = plt.subplots(figsize=(5.6, 6.0))
        yield axes
        plt.close(figure)


def boxes(ax: Axes) -> list[FancyBboxPatch]:
    return [patch for patch in ax.patches if isinstance(patch, FancyBboxPatch)]


def written(ax: Axes) -> list[str]:
    return [text.get_text() for text in ax.texts if text.get_text()]


def test_every_lesson_stands_in_the_picture(ax: Axes) -> None:
    draw_stages(ax)
    words = " ".join(written(ax)).split()
    assert {f"L{number}" for number in range(1, 15)} <= set(words)


def test_the_lit_stage_differs_in_more_than_colour(ax: Axes) -> None:
    draw_stages(ax, "ransac")
    wide = [box for box in boxes(ax) if box.get_linewidth() > 2.0]
    assert len(wide) == 1
    assert wide[0].get_y() == pytest.approx(-STAGES["ransac"].row - wide[0].get_height() / 2)
    assert [text for text in written(ax) if text.startswith("▶")] == ["▶ RANSAC · L8"]


def test_an_unlit_machine_has_no_mark(ax: Axes) -> None:
    draw_stages(ax)
    assert len({box.get_linewidth() for box in boxes(ax)}) == 1
    assert not [text for text in written(ax) if text.startswith("▶")]


def test_labels_can_be_left_out(ax: Axes) -> None:
    draw_stages(ax, labels=False)
    assert len(written(ax)) == len(STAGES) + 1


def test_boxes_hold_their_words_and_do_not_overlap(ax: Axes) -> None:
    draw_stages(ax, "places")
    ax.figure.draw_without_rendering()
    frames = [box.get_window_extent() for box in boxes(ax)]
    for frame, name in zip(frames, STAGES, strict=True):
        (text,) = [t for t in ax.texts if STAGES[name].name in t.get_text()]
        inside = text.get_window_extent()
        assert frame.x0 <= inside.x0
        assert inside.x1 <= frame.x1
    for k, one in enumerate(frames):
        assert not any(one.overlaps(other) for other in frames[k + 1 :])


def test_an_unknown_stage_is_named(ax: Axes) -> None:
    with pytest.raises(ValueError, match="'lidar' is no stage"):
        draw_stages(ax, "lidar")
