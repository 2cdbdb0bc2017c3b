"""The figures' style: seen on every page, told apart without colour, the same bytes each time."""

import itertools
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib import pyplot as plt
from robust_slam import palette
from robust_slam.estimators.kernels import KERNELS
from robust_slam.palette import COLOURS, LINESTYLES, MARKERS, PALETTE
from robust_slam_course.canvas.still import to_svg
from robust_slam_course.plots.kernels import kernel_look
from robust_slam_course.style import LOOKS, STYLE, figure_style, site_colours

from tests.course.contrast import contrast, luminance

PAGES = ("light", "dark")
SEEN = sorted(COLOURS.keys() - {"ground", "card", "grid"})
LETTERS = {"ink", "muted"}
ROOT = Path(__file__).parents[2]
SOURCES = {".py", ".css", ".js"}


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("name", SEEN)
def test_every_colour_has_the_contrast_that_graphics_or_letters_need(name, page):
    colour, ground = (getattr(COLOURS[each], page) for each in (name, "ground"))
    found, least = contrast(luminance(colour), luminance(ground)), 4.5 if name in LETTERS else 3.0
    assert found >= least, f"colours.toml: {name} on a {page} page has {found:.1f}, not {least}"


def test_letters_palette_and_looks_have_these_colours_alone_and_the_ground_is_the_themes():
    assert "--rs-ground" not in site_colours()
    settings = ("text.color", "axes.labelcolor", "xtick.color", "ytick.color")
    assert {STYLE[key] for key in settings} <= {COLOURS[name].light for name in LETTERS}
    known = {colour.light for colour in COLOURS.values()}
    assert {*PALETTE.values(), *(look.color for look in LOOKS)} <= known


def test_no_other_file_has_a_colour_of_the_palette():
    shades = {shade.lower() for colour in COLOURS.values() for shade in colour} - {"#ffffff"}
    names = ("lib/robust_slam", "lib/course", "chapters/assets", "chapters/_ext")
    folders = [ROOT / name for name in names]
    sources = [p for folder in folders for p in folder.rglob("*") if p.suffix in SOURCES]
    assert len(sources) > 100
    for path in sources:
        found = re.findall("#[0-9a-f]{6}", path.read_text("utf-8").lower())
        assert not shades & {*found}, path


RECOLOURED = """
from matplotlib.figure import Figure
from robust_slam.palette import PALETTE
from robust_slam_autograder.reports import class_pages
from robust_slam_autograder.reports.heat_map import heat_map
from robust_slam_course import figures, pictures, quiz
from robust_slam_course.style import site_colours

figure = Figure()
figure.subplots().plot([0, 1], color=PALETTE["estimate"])
options = [quiz.Option("a", "yes", correct=True), quiz.Option("b", "no")]
for text in (
    figures.page_html(figure),
    pictures.certificate().static_html(),
    quiz.Quiz([quiz.Question("which?", options)]).html(),
    site_colours(),
    class_pages.index([], heat_map([]), names=False),
):
    print("#123456" in text, "#0072b2" in text)
"""


def test_a_colour_is_changed_in_one_place(tmp_path):
    """In figures, live pictures, quizzes, the site and reports."""
    shutil.copytree(ROOT / "lib", tmp_path / "lib", ignore=shutil.ignore_patterns(".*"))
    colours = tmp_path / "lib" / "robust_slam" / "colours.toml"
    text = colours.read_text("utf-8").replace(COLOURS["estimate"].light, "#123456")
    colours.write_text(text, "utf-8")
    places = (tmp_path / "lib", tmp_path / "lib" / "course", ROOT / "autograder")
    path = os.pathsep.join(map(str, places))
    done = subprocess.run(
        [sys.executable, "-c", RECOLOURED], cwd=tmp_path, env={**os.environ, "PYTHONPATH": path},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split("\n") == ["True False"] * 5 + [""]


def test_a_colour_that_is_none_is_named():
    with pytest.raises(ValueError, match=r"colours.toml: ink is .*; write each shade as #rrggbb"):
        palette.colours('ink = { light = "black", dark = "#ffffff" }')


def test_every_colour_has_a_line_and_a_marker_and_two_looks_differ_in_both():
    assert PALETTE.keys() == LINESTYLES.keys() == MARKERS.keys()
    for signs in (LINESTYLES, MARKERS):
        assert signs["outlier"] != signs["inlier"]
    for first, second in itertools.combinations(LOOKS, 2):
        assert first.color != second.color
        assert first.linestyle != second.linestyle
        assert first.marker != second.marker


def test_there_is_a_look_of_its_own_for_every_kernel_and_none_of_an_inlier_or_an_outlier():
    """Also in the live picture, which has the same colours."""
    assert len({kernel_look(name) for name in KERNELS}) == len(KERNELS)
    with pytest.raises(ValueError, match="name: there is no kernel 'no kernel'; give one of sq"):
        kernel_look("no kernel")
    script = ROOT / "lib/course/robust_slam_course/pictures/kernels.js"
    live = re.findall(r'name: "(\w+)", .*colour: "(\w+)"', script.read_text("utf-8"))
    assert len(live) == 4
    for name, colour in live:
        assert COLOURS[colour].light == kernel_look(name).color
    for look in LOOKS:
        assert look.color not in {PALETTE["inlier"], PALETTE["outlier"]}
        assert look.marker not in {MARKERS["outlier"], "D"}


def draw() -> str:
    figure, ax = plt.subplots()
    ax.plot([0, 1], [1, 0], marker="o")
    ax.set(xlabel="u", ylabel=r"$\rho(u)$")
    return to_svg(figure)


def test_the_same_figure_gives_the_same_bytes_and_keeps_its_letters():
    with figure_style():
        first, second = draw(), draw()
    assert first == second
    assert ">u</text>" in first
