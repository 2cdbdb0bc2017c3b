"""The figures' style: seen on every page, told apart without colour, the same bytes each time."""

from __future__ import annotations

import io
import itertools
import re
from pathlib import Path

import matplotlib as mpl
import pytest
from matplotlib import pyplot as plt
from robust_slam.estimators.kernels import KERNELS
from robust_slam.palette import COLOURS, LINESTYLES, MARKERS, PALETTE
from robust_slam_course.canvas import picture
from robust_slam_course.plots.kernels import kernel_look
from robust_slam_course.style import LOOKS, STYLE, figure_style, use_style

from tests.lib.course.contrast import contrast, luminance

PAGES = ("light", "dark")
SEEN = sorted(COLOURS.keys() - {"ground", "grid"})
SHEETS = (
    Path(picture.__file__).with_name("picture.css"),
    Path(__file__).parents[3] / "chapters" / "assets" / "site.css",
)
VARIABLE = re.compile(r"--rs-(\w+): (#[0-9a-f]{3,6});")


def on_the_ground(name: str, page: str) -> float:
    """The contrast of a colour and the page."""
    colour, ground = (getattr(COLOURS[each], page) for each in (name, "ground"))
    return contrast(luminance(colour), luminance(ground))


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("name", SEEN)
def test_every_colour_has_the_contrast_that_graphics_need(name: str, page: str) -> None:
    assert on_the_ground(name, page) >= 3.0


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("name", ["ink", "muted"])
def test_letters_have_the_contrast_that_text_needs(name: str, page: str) -> None:
    assert on_the_ground(name, page) >= 4.5


def test_letters_are_drawn_in_these_colours_alone() -> None:
    settings = ("text.color", "axes.labelcolor", "xtick.color", "ytick.color")
    allowed = {COLOURS["ink"].light, COLOURS["muted"].light}
    assert {STYLE[key] for key in settings} <= allowed


def test_palette_and_looks_know_no_other_colours() -> None:
    known = {colour.light for colour in COLOURS.values()}
    assert {*PALETTE.values(), *(look.color for look in LOOKS)} <= known


@pytest.mark.parametrize("sheet", SHEETS, ids=lambda path: path.name)
def test_the_style_sheets_have_the_same_colours(sheet: Path) -> None:
    found: dict[str, list[str]] = {}
    for name, colour in VARIABLE.findall(sheet.read_text(encoding="utf-8")):
        found.setdefault(name, []).append(colour)
    # A picture is a card of its own, and a page's ground is the theme's.
    found.pop("ground", None)
    assert found == {name: list(COLOURS[name]) for name in found}
    assert "ink" in found


def test_the_pages_know_every_colour() -> None:
    text = SHEETS[1].read_text(encoding="utf-8")
    assert {name for name, _ in VARIABLE.findall(text)} == COLOURS.keys() - {"ground"}
    assert "--rs-ground: var(--pst-color-background" in text


def test_every_colour_has_a_line_and_a_marker() -> None:
    assert PALETTE.keys() == LINESTYLES.keys() == MARKERS.keys()


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
