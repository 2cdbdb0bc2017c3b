"""What the drawn machine shows, read back from the axes."""

from __future__ import annotations

import pytest
from matplotlib.patches import FancyBboxPatch
from robust_slam_course.plots.stages import STAGES, draw_stages


@pytest.fixture
def ax(ax):
    ax.figure.set_size_inches(5.6, 6.0)
    return ax


def boxes(ax) -> list[FancyBboxPatch]:
    return [patch for patch in ax.patches if isinstance(patch, FancyBboxPatch)]


def written(ax) -> list[str]:
    return [text.get_text() for text in ax.texts if text.get_text()]


def test_every_lesson_stands_in_the_picture(ax) -> None:
    draw_stages(ax)
    words = " ".join(written(ax)).split()
    assert {f"L{number}" for number in range(1, 15)} <= set(words)


def test_the_lit_stage_differs_in_more_than_colour(ax) -> None:
    draw_stages(ax, "ransac")
    wide = [box for box in boxes(ax) if box.get_linewidth() > 2.0]
    assert len(wide) == 1
    assert wide[0].get_y() == pytest.approx(-STAGES["ransac"].row - wide[0].get_height() / 2)
    assert [text for text in written(ax) if text.startswith("▶")] == ["▶ RANSAC · L8"]


def test_an_unlit_machine_has_no_mark(ax) -> None:
    draw_stages(ax)
    assert len({box.get_linewidth() for box in boxes(ax)}) == 1
    assert not [text for text in written(ax) if text.startswith("▶")]


def test_labels_can_be_left_out(ax) -> None:
    draw_stages(ax, labels=False)
    assert len(written(ax)) == len(STAGES) + 1


def test_boxes_hold_their_words_and_do_not_overlap(ax) -> None:
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


def test_an_unknown_stage_is_named(ax) -> None:
    with pytest.raises(ValueError, match="'lidar' is no stage"):
        draw_stages(ax, "lidar")
