"""Chapter 00 prints the numbers that the library computes, and no others."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.typing import ArrayLike
from robust_slam.graphs import dead_reckoning, pose_graph
from robust_slam.graphs.metrics import ate
from robust_slam.problems import LinearProblem, PoseGraphProblem, chain
from robust_slam_course import pictures
from robust_slam_course.plots.opening import town

from tests.book.prose import Chapter, Numbers
from tests.book.samples import assert_right_options_are_hidden, three_poses

CHAPTER = Chapter("00-one-lie")
# Data of the examples, sizes of drawings and numbers of the quiz's stories.
GIVEN_WHOLE = {100, 300, 310, 1000, 400}
FRACTION = re.compile(r"(?<![\w/.])(-?\d+)/(\d+)(?![\w/])|frac\{(\d+)\}\{(\d+)\}")
WHOLE = re.compile(r"(?<![\w.,/{])\d{3,}(?![\w/]|\.\d)")


def length(*closures: float, sigma: ArrayLike = 0.05) -> float:
    """x3 - x1 for two odometry edges and these closures."""
    return three_poses(*closures, sigma=sigma).initial()[2]


def cost(problem: LinearProblem) -> float:
    return float(np.sum(problem.residuals(problem.initial()) ** 2))


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The town of the opening, the examples of the chapter, and its own five poses."""
    scene = town()
    inliers = ~scene.graph.is_odometry & ~scene.is_outlier
    correct = pose_graph.select(scene.graph, ~scene.is_outlier)
    three, half, alone = three_poses(2, 0), three_poses(2, 1), three_poses(0)
    x, u = three.initial(), three.residuals(three.initial())
    five = chain(5, [0, 1, 2, 3, 1], [1, 2, 3, 4, 3], [1, 1, 1, 1, 0], [0.1] * 4 + [0.05])
    four = chain(4, [0, 1, 2, 0], [1, 2, 3, 2], [1, 1, 1, 0], [0.1] * 3 + [0.05])
    normal = three.jacobian.T @ (three.jacobian / three.sigma[:, None] ** 2)
    cells = CHAPTER.run("imports", "five-graph")
    solve, build, pentagon = (cells[name] for name in ("gauss_newton", "five_poses", "pentagon"))
    return SimpleNamespace(**locals())


def without_noise(correct: pose_graph.PoseGraph) -> np.ndarray:
    """The map of the live picture, whose wrong closure says exactly that its ends coincide."""
    start = pictures.cycles()
    information = correct.information[~correct.is_odometry][:1]
    graph = pose_graph.with_closures(correct, start.state["town"], np.zeros((1, 3)), information)
    return PoseGraphProblem(graph).initial()


FORMULAS = {
    "9.85": lambda page: closure_ends_apart(page.scene, page.scene.truth),
    "0.32": lambda page: ate(dead_reckoning(page.correct), page.scene.truth),
    "0.15": lambda page: ate(page.scene.before, page.scene.truth),
    "2.69": lambda page: ate(page.scene.folded, page.scene.truth),
    "2.71": lambda page: ate(without_noise(page.correct), page.scene.truth),
    "1.058824 1.06": lambda page: page.x[2],
    "0.53": lambda page: page.x[1],
    "847.058824": lambda page: cost(page.three),
    "-4.7": lambda page: page.u[0],
    "-18.8": lambda page: page.u[2],
    "21.2": lambda page: page.u[3],
    "448.4429": lambda page: page.u[3] ** 2,
    "398.6159": lambda page: page.u[:3] @ page.u[:3],
    "0.222222": lambda page: length(0),
    "-8.89": lambda page: page.alone.residuals(page.alone.initial())[0],
    "4.44": lambda page: page.alone.residuals(page.alone.initial())[2],
    "1.22 2.22": lambda page: page.five.initial()[3:],
    # The page's five poses with the outlier at 0.1 m: the canvas after its first click.
    "1.11": lambda page: np.linalg.norm(
        (page.solve(page.build(True, True, 0.1), page.pentagon) - page.pentagon)[2, :2]
    ),
    "1.995565": lambda page: length(2, 0, sigma=[0.05, 1.0]),
    "0.086124": lambda page: length(2, 0, sigma=[0.05, 0.01]),
    "0.72": lambda page: length(2, 0, 0),
    "1.529412": lambda page: page.half.initial()[2],
    "211.764706": lambda page: cost(page.half),
    "0.047140": lambda page: 1 / math.sqrt(450),
    "8.470588": lambda page: cost(three_poses(2, 0, sigma=0.5, odometry=1.0)),
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    given = "0.1 0.05 0.01 0.02 -0.5 2.0 2.5"


FRACTIONS = {
    "18/17 900/850": lambda page: page.x[2],
    "9/17": lambda page: page.x[1],
    "14400/17": lambda page: cost(page.three),
    "8/17": lambda page: (page.x + 1 - page.x[1])[0],
    "26/17": lambda page: (page.x + 1 - page.x[1])[2],
    "-8/17": lambda page: page.half.initial()[2] - 2,
    "64/289": lambda page: (page.half.initial()[2] - 2) ** 2,
    "81/289": lambda page: (page.half.initial()[2] - 1) ** 2,
    "3600/17": lambda page: cost(page.half),
    "144/17": lambda page: cost(page.three) / 100,
    "2/9 100/450": lambda page: length(0),
    "-8/9": lambda page: (page.five.residuals(page.five.initial()) * page.five.sigma)[1],
    "1/9": lambda page: page.four.initial()[1],
    "11/9": lambda page: page.four.initial()[3],
    "-62/17": lambda page: length(2, -10),
    "400/850": lambda page: length(2, 1) - length(2, 0),
    "18/25": lambda page: length(2, 0, 0),
}


def closure_ends_apart(scene, poses: np.ndarray) -> float:
    """How far the two ends of the outlier are apart in a map."""
    i, j = scene.graph.edges[-1]
    return float(np.linalg.norm(poses[i, :2] - poses[j, :2]))


@pytest.mark.parametrize("texts", FRACTIONS)
def test_a_printed_fraction_is_what_the_library_computes(texts: str, page) -> None:
    for text in texts.split():
        top, bottom = map(float, text.split("/"))
        assert top / bottom == pytest.approx(FRACTIONS[texts](page), abs=1e-9), text


def test_every_printed_fraction_is_computed_and_the_middle_pose_is_fixed_as_well(page) -> None:
    found = {f"{a or c}/{b or d}" for a, b, c, d in FRACTION.findall(CHAPTER.text)}
    assert found == set(" ".join(FRACTIONS).split())
    assert page.half.initial()[2] == pytest.approx(26 / 17)


def test_each_large_whole_number_is_known(page) -> None:
    odometry, closure = 1 / 0.1**2, 1 / 0.05**2
    pull, edges = odometry / 2 + closure, len(page.scene.graph.edges)
    computed = [
        *np.linalg.eigvalsh(page.normal)[1:],
        np.sum(page.three.residuals(np.array([0.0, 1.0, 2.0])) ** 2),
        math.floor(cost(page.three)),
        *(odometry, closure, 2 * closure, pull, 2 * pull, pull + closure),
        *(edges, edges - 1),
        100 / 0.01,
    ]
    found = {int(number) for number in WHOLE.findall(CHAPTER.text)}
    assert found - GIVEN_WHOLE <= {round(float(value)) for value in computed}


@pytest.mark.parametrize(
    ("stiffness", "motion"), [(0, (1, 1, 1)), (300, (1, -2, 1)), (1700, (-1, 0, 1))]
)
def test_the_motions_of_the_text_are_eigenvectors(page, stiffness, motion) -> None:
    assert f"**{stiffness}**, the vector ${motion}$" in CHAPTER.text
    assert page.normal @ motion == pytest.approx(stiffness * np.array(motion))


def test_the_outlier_folds_the_map(page) -> None:
    folded, true = (
        closure_ends_apart(page.scene, poses) for poses in (page.scene.folded, page.scene.truth)
    )
    assert folded < 0.1 * true
    assert "100 poses, 99 odometry steps and 12 correct loop closures" in CHAPTER.text
    assert (page.scene.graph.is_odometry.sum(), page.inliers.sum()) == (99, 12)


def test_every_measurement_of_the_town_claims_what_the_page_says(page) -> None:
    sigma = np.sqrt(1 / np.diagonal(page.scene.graph.information, axis1=1, axis2=2))
    assert sigma == pytest.approx(np.tile([0.05, 0.05, 0.02], (112, 1)))
    assert "the outlier included, claims $\\sigma$ = 5 cm and 0.02 rad" in CHAPTER.text


def test_a_sigma_of_the_pentagon_comes_with_half_of_it_for_the_heading(page) -> None:
    graph = page.build(True, True, 0.2)
    sigma = np.sqrt(1 / np.diagonal(graph.information, axis1=1, axis2=2))
    assert sigma[:, 0] == pytest.approx([0.1] * 4 + [0.05, 0.2])
    assert sigma[:, 2] == pytest.approx(sigma[:, 0] / 2)
    assert "comes with $s/2$ rad for the heading" in CHAPTER.text


def test_the_edges_off_the_cycle_of_the_outlier_keep_their_residual(page) -> None:
    graph = page.build(True, False, 0.1)
    norms = pose_graph.residual_norms(graph, page.solve(graph, page.pentagon))
    assert norms[2:4] == pytest.approx([0, 0], abs=1e-6)
    assert min(norms[[0, 1, 4]]) > 1


def test_the_quiz_gives_nothing_away_by_place_or_length() -> None:
    questions = CHAPTER.questions()
    assert len(questions) == 6
    assert assert_right_options_are_hidden(questions, 1.0) >= {0, 2, 3}


def test_the_page_draws_the_town_of_the_readme() -> None:
    cell = CHAPTER.cells["opening-picture"]
    assert "default_rng(2)" in cell
    assert "manhattan(100, rng, side=9, turn=0.25, closures=12)" in cell
    assert "add_random_closures(clean, 1, rng, poses=truth)" in cell
