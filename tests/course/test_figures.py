"""Figures as parts of a page: colours, letters and names, and the narrow drawing."""

import re
from collections.abc import Iterator
from itertools import pairwise
from xml.etree import ElementTree as ET

import matplotlib as mpl
import numpy as np
import pytest
from IPython.core.getipython import get_ipython
from IPython.core.interactiveshell import InteractiveShell
from matplotlib import pyplot as plt
from matplotlib.figure import Figure
from robust_slam.palette import COLOURS, PALETTE
from robust_slam_course import figures, style
from robust_slam_course.figures import page_html
from robust_slam_course.figures.narrow import WIDTH, narrowed
from robust_slam_course.figures.svg import inline
from robust_slam_course.style import figure_style

pytestmark = [pytest.mark.long, pytest.mark.rest]

BARE = re.compile(r"(?<!,)#[0-9a-f]{6}\b")
"""A colour that is no fall-back."""


@pytest.fixture(autouse=True)
def drawing():
    with figure_style():
        yield
    plt.close("all")


def panels(rows: int = 2, columns: int = 2, **more: object) -> Figure:
    """Return panels with a line each, a title, and labels at the edges."""
    figure, axes = plt.subplots(rows, columns, squeeze=False, **more)
    for number, ax in enumerate(axes.flat):
        ax.plot([0, 1, 2], [number, 1, 2], "o-", color=PALETTE["estimate"], label=f"line {number}")
        ax.set_title(f"panel {number}")
    for ax in axes[-1]:
        ax.set_xlabel("x")
    for ax in axes[:, 0]:
        ax.set_ylabel("y")
    return figure


def drawings(figure: Figure) -> tuple[ET.Element, ET.Element]:
    wide, narrow = ET.fromstring(page_html(figure))
    assert (wide.get("class"), narrow.get("class")) == ("rs-wide", "rs-narrow")
    return wide, narrow


def test_every_colour_that_has_a_name_is_one_of_the_page():
    figure = panels(1, 1)
    figure.axes[0].plot([0, 1], [1, 0], "ko", markerfacecolor="white")
    figure.axes[0].axvline(1, color="0.4")
    figure.axes[0].plot([0, 1], color="#123456")
    html = page_html(figure)
    assert {*BARE.findall(html)} == {"#123456"}
    assert set(re.findall(r"var\(--rs-(\w+)", html)) <= COLOURS.keys()
    known = [("estimate", PALETTE["estimate"]), ("ground", "#ffffff"), ("muted", "#666666")]
    for name, colour in known:
        assert f"var(--rs-{name},{colour})" in html


def test_letters_stay_letters_in_the_page_s_font():
    figure = panels()
    figure.axes[0].set(xlabel="$x_1$", yscale="log", ylim=(1e-3, 1e2), title="a < b")
    figure.axes[0].set_yticks([1e-3, 1e1])
    html = page_html(figure)
    assert "font-family" not in html and "DejaVu" not in html and "tspan" not in html
    said = {text.text for text in drawings(figure)[0].iter("text")}
    assert {"x₁", "10⁻³", "10¹", "panel 1", "a < b"} <= said


def test_a_letter_that_has_no_lowered_sign_is_small_and_below_the_line():
    figure = panels()
    figure.axes[0].set(xlabel="$z_q^{-1}x$")
    ((low, rest),) = (text for text in drawings(figure)[0].iter("text") if text.text == "z")
    assert (low.text, rest.text, rest.get("style")) == ("q", "⁻¹x", None)
    assert "font-size" in low.attrib["style"]
    assert float(low.attrib["dy"]) == -float(rest.attrib["dy"]) > 0


def test_lines_of_a_centred_text_are_centred_in_any_font():
    figure, ax = plt.subplots()
    ax.set_title("short\nand a longer line")
    ax.text(0.1, 0.1, "left\nand the next line")
    wide, _ = drawings(figure)
    places = {
        text.text: (text.get("transform", "").partition(" ")[0], "middle" in text.get("style", ""))
        for text in styled(wide)
    }
    assert places["short"] == places["and a longer line"]
    assert places["left"] == places["and the next line"]
    assert [places[said][1] for said in ("short", "left")] == [True, False]


def styled(element: ET.Element, style: str = "") -> Iterator[ET.Element]:
    """The texts of a drawing, each with the styles of the groups that it is in."""
    style += ";" + element.get("style", "")
    if element.tag == "text":
        element.set("style", style)
        yield element
    for child in element:
        yield from styled(child, style)


def test_the_fonts_of_an_older_matplotlib_are_understood():
    style = "fill: #262626; font: oblique 700 11.5px 'DejaVu Sans', Geneva; text-anchor: middle"
    svg = f'<svg viewBox="0 0 9 9"><text style="{style}">u</text></svg>'
    (text,) = ET.fromstring(inline(svg, "rs-wide"))
    parts = "fill:var(--rs-ink,#262626);font-size:11.5px;font-style:italic;text-anchor:middle"
    assert text.get("style") == parts


def test_there_is_no_ground_no_black_and_no_rule_for_the_whole_page():
    for drawing in drawings(panels(1, 1)):
        assert drawing.get("style") == "fill:var(--rs-ink,#000000)"
        tags = {element.tag for element in drawing.iter()}
        assert tags <= {"svg", "g", "path", "use", "text", "defs", "clipPath", "rect"}
        ground = next(drawing.iter("path"))
        assert ground.get("style") == "fill:none"


def test_names_are_those_of_one_drawing_and_the_figure_stays_as_it_is():
    hatched = panels(1, 2)
    hatched.axes[0].bar([0, 1], [1, 2], hatch="///")
    html = page_html(panels()) + page_html(hatched)
    assert "<pattern" in html and "fill:url(#f" in html
    names = re.findall(r' id="([^"]+)"', html)
    assert len(names) == len(set(names)) > 4
    assert set(re.findall(r"#(f\w+)", html)) <= set(names)
    figure = panels()
    before = plt.get_fignums(), figure.get_size_inches().tolist()
    first = page_html(figure)
    assert (plt.get_fignums(), figure.get_size_inches().tolist()) == before
    assert page_html(figure) == first


class TestNarrow:
    def test_panels_stand_one_below_the_other_and_a_small_figure_keeps_its_size(self):
        narrow = narrowed(panels())
        narrow.draw_without_rendering()
        boxes = [ax.get_window_extent() for ax in narrow.axes]
        assert all(low.y1 < high.y0 for high, low in pairwise(boxes))
        assert np.allclose([box.x0 for box in boxes], boxes[0].x0)
        assert [ax.get_title() for ax in narrow.axes] == [f"panel {k}" for k in range(4)]
        for made, size in ((panels(2, 1), [WIDTH, 3.5]), (panels(1, 1, figsize=(3, 2)), [3, 2])):
            assert narrowed(made).get_size_inches().tolist() == size

    def test_panels_that_shared_axes_get_their_own_numbers_and_labels(self):
        narrow = narrowed(panels(sharex=True, sharey=True))
        narrow.draw_without_rendering()
        for ax in narrow.axes:
            assert (ax.get_xlabel(), ax.get_ylabel()) == ("x", "y")
            for axis in (ax.xaxis, ax.yaxis):
                assert any(tick.label1.get_visible() for tick in axis.get_major_ticks())

    def test_a_panel_of_a_legend_is_lower(self):
        figure = panels()
        last = figure.axes[3]
        last.clear()
        last.set_axis_off()
        last.legend(*figure.axes[0].get_legend_handles_labels(), loc="center")
        narrow = narrowed(figure)
        narrow.draw_without_rendering()
        *_, drawn, told = (ax.get_window_extent().height for ax in narrow.axes)
        assert told < 0.7 * drawn

    def test_a_wide_legend_gets_fewer_columns_and_numbers_of_an_axis_do_not_touch(self):
        figure = panels(1, 1)
        handles, _ = figure.axes[0].get_legend_handles_labels()
        names = ["a name that is long", "another name", "and a third one", "the last"]
        figure.legend(handles * 4, names, loc="outside lower center", ncols=4)
        narrow = narrowed(figure)
        assert narrow.legends[0].get_window_extent().width <= narrow.bbox.width
        assert figure.legends[0].get_window_extent().width > 0.8 * figure.bbox.width
        figure = panels(1, 1)
        figure.axes[0].set_xticks(np.linspace(0, 2, 9), [f"{k}.00001" for k in range(9)])
        narrow = narrowed(figure)
        shown = [label for label in narrow.axes[0].get_xticklabels() if label.get_visible()]
        assert [label.get_text()[0] for label in shown] == list("02468")
        boxes = [label.get_window_extent() for label in shown]
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))


@pytest.mark.parametrize("for_a_page", [False, True])
def test_only_a_build_of_the_book_gets_elements_of_a_page(for_a_page, monkeypatch):
    monkeypatch.delenv(figures.BUILD, raising=False)
    if for_a_page:
        monkeypatch.setenv(figures.BUILD, "1")
    shell = InteractiveShell.instance()
    try:
        assert get_ipython() is shell
        mpl.rcParams["svg.hashsalt"] = None
        style.use_style()
        assert mpl.rcParams["svg.hashsalt"] == "robust-slam"
        data, _ = shell.display_formatter.format(panels(1, 1))
        assert data["image/svg+xml"].startswith("<div class=") is for_a_page
        assert "<svg" in data["image/svg+xml"]
    finally:
        InteractiveShell.clear_instance()
