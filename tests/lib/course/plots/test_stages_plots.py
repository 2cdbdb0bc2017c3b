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


def test_boxes_hold_their_words_and_do_not_overlap(ax) -> None:
    draw_stages(ax)
    ax.figure.draw_without_rendering()
    frames = [box.get_window_extent() for box in boxes(ax)]
    for frame, name in zip(frames, STAGES, strict=True):
        (text,) = [t for t in ax.texts if STAGES[name].name in t.get_text()]
        inside = text.get_window_extent()
        assert frame.x0 <= inside.x0
        assert inside.x1 <= frame.x1
    for k, one in enumerate(frames):
        assert not any(one.overlaps(other) for other in frames[k + 1 :])
