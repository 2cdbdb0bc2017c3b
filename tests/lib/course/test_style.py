"""The figures' style: seen on white, told apart without colour, and the same bytes each time."""

from __future__ import annotations

import io
import itertools

import matplotlib as mpl
import pytest
from matplotlib import colors
from matplotlib import pyplot as plt
from robust_slam.estimators.kernels import KERNELS
from robust_slam_course.plots.kernels import kernel_look
from robust_slam_course.style import (
    LINESTYLES,
    LOOKS,
    MARKERS,
    PALETTE,
    Look,
    figure_style,
    use_style,
)


def luminance(colour: str) -> float:
    """Return the relative luminance of WCAG 2.1."""
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in rgb(colour)]
    return float(0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2])


def rgb(colour: str) -> tuple[float, float, float]:
    return colors.to_rgb(colour)


@pytest.mark.parametrize("name", PALETTE)
def test_every_colour_has_the_contrast_that_graphics_need_on_white(name: str) -> None:
    assert 1.05 / (luminance(PALETTE[name]) + 0.05) >= 3.0


def test_every_colour_has_a_line_and_a_marker() -> None:
    assert PALETTE.keys() == LINESTYLES.keys() == MARKERS.keys()


@pytest.mark.parametrize("look", LOOKS, ids=lambda look: look.color)
def test_every_look_has_the_contrast_that_graphics_need_on_white(look: Look) -> None:
    assert 1.05 / (luminance(look.color) + 0.05) >= 3.0


def test_two_looks_differ_in_colour_in_line_and_in_marker() -> None:
    for first, second in itertools.combinations(LOOKS, 2):
        assert first.color != second.color
        assert first.linestyle != second.linestyle
        assert first.marker != second.marker


def test_there_is_a_look_of_its_own_for_every_kernel() -> None:
    assert len({kernel_look(name) for name in KERNELS}) == len(KERNELS)
    with pytest.raises(ValueError, match="name: there is no kernel 'no kernel'; give one of sq"):
        kernel_look("no kernel")


def test_an_outlier_is_told_from_an_inlier_without_colour() -> None:
    assert MARKERS["outlier"] != MARKERS["inlier"]
    assert LINESTYLES["outlier"] != LINESTYLES["inlier"]


def test_the_settings_come_back_after_the_block() -> None:
    before = dict(mpl.rcParams)
    with figure_style():
        assert mpl.rcParams["svg.fonttype"] == "none"
    assert dict(mpl.rcParams) == before


def test_use_style_lasts() -> None:
    with mpl.rc_context():
        use_style()
        assert mpl.rcParams["svg.hashsalt"] == "robust-slam"


def draw() -> str:
    figure, ax = plt.subplots()
    ax.plot([0, 1], [1, 0], marker="o")
    ax.set(xlabel="u", ylabel=r"$\rho(u)$")
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    plt.close(figure)
    return buffer.getvalue()


def test_the_same_figure_gives_the_same_bytes_and_keeps_its_letters() -> None:
    with figure_style():
        first, second = draw(), draw()
    assert first == second
    assert ">u</text>" in first
