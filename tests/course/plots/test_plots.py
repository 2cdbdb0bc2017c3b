"""A drawing shows what it showed when it was looked at, keeps its laws and refuses nonsense."""

import os
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from robust_slam.estimators import gnc, graduation, irls, kernels
from robust_slam.estimators.mixtures import NullHypothesis
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.palette import COLOURS
from robust_slam.problems import LocationProblem
from robust_slam_course.canvas.still import to_svg
from robust_slam_course.plots import (
    annealing,
    certificates,
    chain,
    consistency,
    corners,
    landscapes,
    location,
    opening,
    pulls,
    registration,
    robots,
    sweeps,
    switches,
)
from robust_slam_course.plots import kernels as curves
from robust_slam_course.style import figure_style

from tests.course import drawn
from tests.course.contrast import contrast, luminance

DRAWN = Path(__file__).with_name("drawn.json")
README_PICTURE = Path(__file__).parents[3] / "chapters" / "assets" / "one-lie.svg"

FOUR, FIVE, LAST = (-0.2, 0.1, 0.4, 10.0), (0.1, -0.2, 0.15, -0.1, 5.0), [False] * 4 + [True]
X, U = np.linspace(-4.0, 14.0, 3601), np.linspace(0.0, 8.0, 41)
ALL = [make(1.5) for make in kernels.KERNELS.values()]
SEVEN = {"squared", "huber", "cauchy", "geman-mcclure", "tls", "dcs", "welsch"}
KEPT = [kernel for kernel in ALL if kernel.name in SEVEN]  # another one changes no drawing
CAUCHY, TLS = kernels.cauchy(1.0), kernels.tls(2.0)
PATH = irls(LocationProblem(FIVE, 0.3), CAUCHY).history
RUN = gnc(LocationProblem(FOUR), 2.0).history
AGREES = np.eye(4, dtype=bool)
AGREES[[0, 2, 2, 3], [2, 0, 3, 2]] = True
CLIQUES = np.array([[1, 1, 1, 0], [1, 1, 1, 0], [1, 1, 1, 1], [0, 0, 1, 1]], dtype=bool)
CROWD = np.append(np.zeros(20), 10.0)
GAPS = np.arange(6.0).reshape(3, 2)
PLACES, HEIGHTS, OUTLIER = [0.0, 1.0, 4.0], [1.0, 2.0, 9.0], [False, False, True]
FIRST = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 3.0]])
SECOND = FIRST + np.array([5.0, 0.0, 0.0])
POSES = np.array([[k % 3, 2.0 * (k // 3), 0.0] for k in range(6)])
EDGES = [[0, 1], [1, 2], [3, 4], [4, 5], [0, 3], [1, 4], [2, 4], [0, 2]]
GRAPH = PoseGraph(6, EDGES, np.zeros((8, 3)), [np.eye(3)] * 8, np.arange(8) < 4)
TRUST = np.array([1, 1, 1, 1, 1, 0.3, 0, 0.2])
SIZES = np.array([10.0, 100.0, 1000.0])
SCORES = {
    "bold": [[1.0, 2.0], [3.0, 2.0], [8.0, 5.0]],
    "shy": [[4.0, 4.0], [4.0, 4.0], [4.0, 9.0]],
}
LINK = {"edges": [(0, 1), (0, 2), (0, 2)], "is_odometry": [True, False, False]}

Draw = Callable[[Axes], object]
CASES: dict[str, Draw] = {
    "agreement": lambda ax: consistency.draw_agreement(ax, AGREES, [False, True] * 2, [0, 2]),
    "family with its end": lambda ax: annealing.draw_family(
        ax, graduation.tls_surrogate, 2.0, (0.1, 1e6), U, TLS.rho
    ),
    "prices": lambda ax: annealing.draw_prices(
        ax, graduation.gm_process, graduation.gm_weight, 2.0, 3.0, (0.0, 1.0, 4.0)
    ),
    "stage": lambda ax: annealing.draw_stage(
        ax, FOUR, X, graduation.gm_surrogate, 2.0, 5.0, (2.5, 0.1)
    ),
    "stage of a kernel": lambda ax: annealing.draw_stage(
        ax, FOUR, X, graduation.tls_surrogate, 2.0, 1e-3, (9.0, 2.5), kernel=TLS
    ),
    "paths": lambda ax: annealing.draw_paths(ax, {"one": RUN, "two": RUN}),
    "ends": lambda ax: landscapes.draw_ends(ax, CROWD, TLS, np.linspace(-2.9, 12.9, 80)),
    "ends that jump": lambda ax: landscapes.draw_ends(ax, [0, 10], CAUCHY, np.linspace(0, 10, 41)),
    "fork": lambda ax: landscapes.draw_fork(ax, 10.0, 8.0),
    "twist": lambda ax: landscapes.draw_twist(ax, 5, np.linspace(-0.5, 2.5, 301)),
    "spectrum": lambda ax: certificates.draw_spectrum(ax, [0.0, 3.0, -1.0, 5.0, 1e-9, -1e-9]),
    "spectrum of large ones": lambda ax: certificates.draw_spectrum(ax, [1e6, 2.0]),
    "spectrum of small ones": lambda ax: certificates.draw_spectrum(ax, [1e-6, 2e-7]),
    "ring": lambda ax: certificates.draw_ring(ax, [0.0, np.pi / 2, np.pi]),
    "ring with a nought": lambda ax: certificates.draw_ring(ax, [0, -1e-9, -0.7]),
    "gaps": lambda ax: certificates.draw_gaps(ax, [0.1, 0.2, 0.3], GAPS, ["A", "B"]),
    "climb": lambda ax: certificates.draw_climb(
        ax, [[9.0], [9.0, 5.0, 4.0], [4.0, -1e-17]], ranks=(2, 3, 4)
    ),
    "corner": lambda ax: corners.draw_corner(ax, corners.View(0.5, -0.06), "tree"),
    "chain": lambda ax: chain.draw_chain(
        ax, [0, 1, 2], **LINK, is_outlier=OUTLIER, labels=["says 1", "", "says 2"]
    ),
    "chain without names": lambda ax: chain.draw_chain(
        ax, [0.0, 0.5, 7.0], **LINK, is_outlier=[False] * 3, named=False
    ),
    "consistency": lambda ax: consistency.draw_consistency(
        ax, CLIQUES, [0, 1], is_outlier=[False, True, False, True]
    ),
    "consistency with names": lambda ax: consistency.draw_consistency(ax, CLIQUES, names="ABCD"),
    "ranges": lambda ax: consistency.draw_ranges(ax, [[0, 0], [4, 0]], [2.1, 2.5], [2.0, 0.0]),
    "growth": lambda ax: sweeps.draw_growth(ax, SIZES, 2.0 * SIZES**1.25),
    "costs": lambda ax: curves.draw_costs(ax, KEPT, u_max=6.0, mark=2.0),
    "influences": lambda ax: curves.draw_influences(ax, KEPT, u_max=6.0, mark=2.0),
    "curvatures": lambda ax: curves.draw_curvatures(ax, KEPT, u_max=4.0),
    "majoriser": lambda ax: curves.draw_majoriser(ax, CAUCHY, 3.0, u_max=6.0),
    "norm densities": lambda ax: curves.draw_norm_densities(ax, (1, 3, 6), probability=0.9),
    "drift": lambda ax: curves.draw_drift(ax, [0, 1], {"huber": [0, 0.1], "tls": [0, 0]}),
    "weights": lambda ax: location.draw_weights(
        ax, FIVE, [1.0, 0.5, 0.25, 0.0, 0.1], 0.3, LAST, height=2.0
    ),
    "weights in numbers": lambda ax: location.label_weights(ax, [1.0, 0.25]),
    "reweighting": lambda ax: location.draw_reweighting(ax, FIVE, PATH, (0, 1), LAST),
    "landscape": lambda ax: location.draw_landscape(ax, FIVE, 0.3, CAUCHY, X, at=PATH[0].x),
    "landscape without weights": lambda ax: location.draw_landscape(ax, FIVE, 0.3, TLS, X, at=2.0),
    "descent": lambda ax: location.draw_descent(ax, PATH),
    "convergence": lambda ax: location.draw_convergence(ax, [1.0, 0.6, 0.2, 0.1], rate=0.5),
    "line fit": lambda ax: pulls.draw_line_fit(
        ax, np.array(PLACES), np.array(HEIGHTS), (1.0, 0.5), (2.0, 0.25), np.array(OUTLIER)
    ),
    "pulls": lambda ax: pulls.draw_pulls(ax, PLACES, [0.5, -2.0, 1.5], np.array(OUTLIER)),
    "pulls down": lambda ax: pulls.draw_pulls(ax, PLACES, [0.5, 2.0, -2.0], np.array(OUTLIER)),
    "pull ends": lambda ax: pulls.draw_pull_ends(ax, KEPT, (-1, 6)),
    "scans": lambda ax: registration.draw_scans(ax, FIRST, SECOND),
    "matches": lambda ax: registration.draw_matches(
        ax, FIRST, SECOND, is_outlier=[True, False, True]
    ),
    "many matches": lambda ax: registration.draw_matches(
        ax, np.zeros((99, 3)), np.ones((99, 3)), is_outlier=[True] * 99
    ),
    "robots": lambda ax: robots.draw_robots(
        ax, GRAPH, POSES, np.arange(6) // 3, TRUST, is_outlier=np.arange(8) == 6
    ),
    "shares": lambda ax: sweeps.draw_shares(
        ax, ["10", "50", "90"], {"good": [1.0, 0.6, 0.54], "seldom": [0.0, 0.125, np.nan]}
    ),
    "sweep": lambda ax: sweeps.draw_sweep(ax, ["few", "many"], SCORES),
    "switch costs": lambda ax: switches.draw_switch_costs(ax, (1.0, 9.0), lam=1.0),
    "modes": lambda ax: switches.draw_modes(ax, NullHypothesis(0.9, 10.0, 1), u_max=5.0),
    "long weight history": lambda ax: annealing.draw_weight_history(
        ax, PATH, [False] * 5, shown=[True] * 5
    ),
    "some weights": lambda ax: annealing.draw_weight_history(
        ax, RUN, [False] * 3 + [True], shown=[True, False, False, False]
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_a_drawing_shows_what_it_showed(case, ax):
    CASES[case](ax)
    drawn.check(ax.figure, case, DRAWN)


@pytest.mark.parametrize(
    ("message", "draw"),
    [
        ("adjacency", lambda ax: consistency.draw_agreement(ax, AGREES[:3, :3], [False] * 4, [0])),
        ("n is 2; give at least 3 headings", lambda ax: landscapes.draw_twist(ax, 2, [0.0, 1.0])),
        ("gaps", lambda ax: certificates.draw_gaps(ax, [0.1, 0.2], GAPS, ["A", "B"])),
        ("ranks", lambda ax: certificates.draw_climb(ax, [[9.0]], ranks=(2, 3))),
        (
            "is_odometry",
            lambda ax: chain.draw_chain(ax, [0, 1], [(0, 1)], is_odometry=[1, 0], is_outlier=[0]),
        ),
        ("adjacency", lambda ax: consistency.draw_consistency(ax, CLIQUES[:3])),
        ("names", lambda ax: consistency.draw_consistency(ax, CLIQUES, names="AB")),
        ("ranges", lambda ax: consistency.draw_ranges(ax, [[0.0, 0.0]], [1.0, 2.0], [0.0, 0.0])),
        ("at least 2", lambda ax: sweeps.draw_growth(ax, [1.0], [1.0])),
        ("costs", lambda ax: sweeps.draw_growth(ax, [1.0, 2.0], [1.0])),
        ("above", lambda ax: sweeps.draw_growth(ax, [1.0, 2.0], [0.0, 1.0])),
        ("pulls", lambda ax: pulls.draw_pulls(ax, PLACES, [1.0, 2.0], OUTLIER)),
        (
            "second: the shape",
            lambda ax: registration.draw_matches(ax, FIRST, SECOND[:2], is_outlier=[False] * 3),
        ),
        (
            "is_outlier: the shape",
            lambda ax: registration.draw_matches(ax, FIRST, SECOND, is_outlier=[False]),
        ),
        ("points: the shape", lambda ax: registration.draw_scans(ax, FIRST[:, :2], SECOND)),
        (
            "6 robots",
            lambda ax: robots.draw_robots(
                ax, GRAPH, POSES, np.arange(6), TRUST, is_outlier=np.arange(8) == 6
            ),
        ),
        ("shape", lambda ax: sweeps.draw_shares(ax, ["1", "2", "3"], {"odd": [1.0, 1.0]})),
        ("from 0 to 1", lambda ax: sweeps.draw_shares(ax, ["1"], {"odd": [1.5]})),
        ("bold", lambda ax: sweeps.draw_sweep(ax, ["one"], SCORES)),
        ("9 methods", lambda ax: sweeps.draw_sweep(ax, "1", {str(k): [[1.0]] for k in range(9)})),
        (
            r"shown: the shape is \(1,\); give \(4,\)",
            lambda ax: annealing.draw_weight_history(ax, RUN, [True] * 4, shown=[True]),
        ),
    ],
)
def test_what_cannot_be_drawn_is_refused(message, draw, ax):
    with pytest.raises(ValueError, match=message):
        draw(ax)


def test_the_exponent_is_the_least_squares_slope_of_the_logarithms():
    assert sweeps.fitted_exponent(SIZES, 3.0 * SIZES**1.5) == pytest.approx(1.5, abs=1e-12)
    # By hand, in powers of ten: heights 0, 2, 2 over 1, 2, 3 have the slope (2 − 0)/2.
    assert sweeps.fitted_exponent(SIZES, [1.0, 100.0, 100.0]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("values", "places"),
    [
        ([3, 2, 1, 2, 3], [2]),
        ([1, 2, 3], []),
        ([3, 1, 3, 0, 3], [1, 3]),
        ([3, 1, 1, 1, 3], [2]),
        ([3, 1, 1, 0, 3], [3]),
        ([1, 1, 1], []),
        ([0, 0, 1, 0, 0], []),
    ],
)
def test_a_minimum_rises_on_both_sides(values, places):
    assert landscapes.minima(values).tolist() == places


@pytest.mark.parametrize("page", ["light", "dark"])
def test_a_larger_share_stands_out_more_and_every_number_is_legible(ax, page):
    steps = np.linspace(0, 1, 21)
    sweeps.draw_shares(ax, [f"{step}" for step in steps], {"all": steps})
    (mesh,) = ax.collections
    mesh.update_scalarmappable()
    colours = (getattr(COLOURS[name], page) for name in ("estimate", "ground", "ink"))
    hue, ground, ink = (np.array(to_rgb(colour)) for colour in colours)
    opacity = mesh.get_facecolors()[:, 3:]
    cells = [luminance(colour) for colour in opacity * hue + (1 - opacity) * ground]
    assert np.all(np.diff(np.abs(np.array(cells) - luminance(ground))) > 0)
    assert all(contrast(luminance(ink), cell) >= 4.5 for cell in cells)


def coordinates(svg: str) -> np.ndarray:
    """Return every number of every path and position, in order."""
    places = re.findall(r'(?:\sd|transform|\sx|\sy)="([^"]*)"', svg)
    return np.array([float(n) for text in places for n in re.findall(r"-?\d+(?:\.\d+)?", text)])


def test_the_readme_picture_is_what_the_library_draws():
    with figure_style():
        new = to_svg(opening.draw_opening(opening.town())) + "\n"
    if os.environ.get(drawn.AGAIN):
        README_PICTURE.write_text(new, "utf-8")
    svg = README_PICTURE.read_text("utf-8")
    assert coordinates(svg).size == coordinates(new).size > 1000
    assert np.abs(coordinates(svg) - coordinates(new)).max() < 0.1  # points: a line's width is 2
    assert len(svg) < 40_000
    assert re.search(r'<g id="patch_1">\s*<path[^>]*fill: #ffffff', svg), "a card of its own"
