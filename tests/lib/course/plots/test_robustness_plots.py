"""What drawn shares show, read back from the axes."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from robust_slam_course.plots.robustness import draw_shares

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


def luminance(colour) -> float:
    """The relative luminance of WCAG 2."""
    parts = np.array(to_rgb(colour))
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def test_a_larger_share_is_darker_and_every_number_is_legible(ax) -> None:
    steps = np.linspace(0, 1, 21)
    draw_shares(ax, [f"{step}" for step in steps], {"all": steps})
    (mesh,) = ax.collections
    mesh.update_scalarmappable()
    cells = [luminance(colour[:3]) for colour in mesh.get_facecolors()]
    assert np.all(np.diff(cells) < 0)
    for cell, text in zip(cells, ax.texts, strict=True):
        low, high = sorted((cell, luminance(text.get_color())))
        assert (high + 0.05) / (low + 0.05) >= 4.5, text.get_text()


@pytest.mark.parametrize(("values", "what"), [([1.0, 1.0], "shape"), ([0, 0, 1.5], "from 0 to 1")])
def test_shares_that_do_not_fit_are_refused(ax, values: list[float], what: str) -> None:
    with pytest.raises(ValueError, match=what):
        draw_shares(ax, RATES, {"odd": values})
