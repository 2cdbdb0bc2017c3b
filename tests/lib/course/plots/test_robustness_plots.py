"""What drawn shares show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb
from robust_slam.palette import COLOURS
from robust_slam_course.plots.robustness import draw_shares

from tests.lib.course.contrast import contrast, luminance

RATES = ["10", "50", "90"]
SHARES = {"good": [1.0, 0.6, 0.54], "seldom": [0.0, 0.125, np.nan]}


@pytest.fixture
def shares(ax):
    return draw_shares(ax, RATES, SHARES)


def test_each_cell_has_its_share_in_percent(shares) -> None:
    found = {(text.get_position()[::-1]): text.get_text() for text in shares.texts}
    assert found == {
        (0.5, 0.5): "100",
        (0.5, 1.5): "60",
        (0.5, 2.5): "54",
        (1.5, 0.5): "0",
        (1.5, 1.5): "12",
    }


def test_rows_and_columns_have_their_names(shares) -> None:
    assert [label.get_text() for label in shares.get_yticklabels()] == list(SHARES)
    assert [label.get_text() for label in shares.get_xticklabels()] == RATES
    assert shares.get_ylim() == (2.0, 0.0)


@pytest.mark.parametrize("page", ["light", "dark"])
def test_a_larger_share_stands_out_more_and_every_number_is_legible(ax, page: str) -> None:
    steps = np.linspace(0, 1, 21)
    draw_shares(ax, [f"{step}" for step in steps], {"all": steps})
    (mesh,) = ax.collections
    mesh.update_scalarmappable()
    hue, ground, ink = (
        np.array(to_rgb(getattr(COLOURS[name], page))) for name in ("estimate", "ground", "ink")
    )
    assert {to_hex(colour) for colour in mesh.get_facecolors()} == {COLOURS["estimate"].light}
    assert {text.get_color() for text in ax.texts} == {COLOURS["ink"].light}
    opacity = mesh.get_facecolors()[:, 3:]
    cells = [luminance(colour) for colour in opacity * hue + (1 - opacity) * ground]
    from_ground = np.abs(np.array(cells) - luminance(ground))
    assert np.all(np.diff(from_ground) > 0)
    assert all(contrast(luminance(ink), cell) >= 4.5 for cell in cells)


@pytest.mark.parametrize(("values", "what"), [([1.0, 1.0], "shape"), ([0, 0, 1.5], "from 0 to 1")])
def test_shares_that_do_not_fit_are_refused(ax, values: list[float], what: str) -> None:
    with pytest.raises(ValueError, match=what):
        draw_shares(ax, RATES, {"odd": values})
