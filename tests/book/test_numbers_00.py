"""Chapter 00 prints the numbers that the library computes, and no others."""

from __future__ import annotations

import math
import re
from typing import Any

import nbformat
import numpy as np
import pytest
from numpy.typing import ArrayLike
from robust_slam import problems
from robust_slam.estimators import kernels, reweighting
from robust_slam.estimators.result import Result
from robust_slam.graphs import pose_graph
from robust_slam.graphs.metrics import ate
from robust_slam.problems import PoseGraphProblem
from robust_slam_course.plots.opening import Town, town
from scipy.optimize import brentq

from tests.book import prose
from tests.book.efficiency import efficiency

NOTEBOOK = nbformat.read(prose.CHAPTERS / "00-one-lie.ipynb", as_version=4)
CELLS = {cell["id"]: cell.source for cell in NOTEBOOK.cells}
TEXT = "\n".join(
    [prose.chapter_text("00-one-lie.ipynb"), *(s for s in CELLS.values() if "Question(" in s)]
).replace("−", "-")

# Data of the examples, sizes of drawings and numbers of the quiz's stories.
GIVEN = {"0.1", "0.05", "0.01", "0.02", "-0.5", "2.0", "2.5"}
GIVEN_WHOLE = {100, 300, 310, 1000, 400}

FRACTION = re.compile(r"(?<![\w/.])(-?\d+)/(\d+)(?![\w/])|frac\{(\d+)\}\{(\d+)\}")
WHOLE = re.compile(r"(?<![\w.,/{])\d{3,}(?![\w/]|\.\d)")


def length(says: ArrayLike, sigma: ArrayLike, odometry: float = 0.1) -> float:
    """Return x3 - x1 for two odometry edges and closures that say `says`, by the library."""
    closures = np.atleast_1d(np.asarray(says, dtype=float))
    spread = np.broadcast_to(np.asarray(sigma, dtype=float), closures.shape)
    return float(chain_of(closures, spread, odometry).initial()[2])


def chain_of(says: np.ndarray, sigma: np.ndarray, odometry: float = 0.1) -> problems.LinearProblem:
    i, j = [0, 1] + [0] * len(says), [1, 2] + [2] * len(says)
    z, spread = [1.0, 1.0, *says], [odometry, odometry, *sigma]
    return problems.chain(3, i, j, z, spread, trusted=[True, True] + [False] * len(says))


def cost(problem: problems.LinearProblem) -> float:
    return float(np.sum(problem.residuals(problem.initial()) ** 2))


@pytest.fixture(scope="module")
def scene() -> Town:
    return town()


@pytest.fixture(scope="module")
def relaxed(scene: Town) -> Result:
    """The town by Cauchy's kernel with the wider threshold that the page names."""
    problem = PoseGraphProblem(scene.graph)
    return reweighting.irls(problem, kernels.cauchy(2.666), tol=1e-6, max_iterations=300)


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """The names that the page's five poses and its quiz define."""
    names: dict[str, Any] = {}
    quiz = [name for name, source in CELLS.items() if "Question(" in source]
    for name in ("imports", "five-graph", *quiz):
        exec(CELLS[name].replace("use_style()\n", ""), names)
    return names


@pytest.fixture(scope="module")
def folded_pentagon(page: dict[str, Any]) -> np.ndarray:
    """The page's five poses with the lie at 0.1 m: the canvas after its first click."""
    graph = page["five_poses"](True, True, 0.1)
    return np.asarray(page["gauss_newton"](graph, page["pentagon"]) - page["pentagon"])


@pytest.fixture(scope="module")
def claims(scene: Town, relaxed: Result, folded_pentagon: np.ndarray) -> dict[str, float]:
    three = chain_of(np.array([2.0, 0.0]), np.array([0.05, 0.05]))
    x = three.initial()
    u = three.residuals(x)
    alone = chain_of(np.array([0.0]), np.array([0.05]))
    hidden = alone.residuals(alone.initial())
    five = problems.chain(5, [0, 1, 2, 3, 1], [1, 2, 3, 4, 3], [1, 1, 1, 1, 0], [0.1] * 4 + [0.05])
    x5 = five.initial()
    robust = reweighting.irls(three, kernels.cauchy(1.0))
    many = chain_of(np.array([2.0, 0.0, 0.0]), np.full(3, 0.05), odometry=1.0)
    outvoted = reweighting.irls(many, kernels.cauchy(1.0), max_iterations=1000)
    i, j = scene.graph.edges[-1]
    honest = scene.weights[~scene.graph.is_odometry & ~scene.is_lie]
    half = chain_of(np.array([2.0, 1.0]), np.array([0.05, 0.05]))
    return {
        "9.85": float(np.linalg.norm(scene.truth[i, :2] - scene.truth[j, :2])),
        "0.15": ate(scene.before, scene.truth),
        "2.69": ate(scene.folded, scene.truth),
        "0.17": ate(scene.robust, scene.truth),
        "0.10": float(honest.min()),
        "2.666": brentq(lambda c: efficiency(kernels.cauchy(c), 3) - 0.95, 1.0, 5.0),
        "0.81": float(relaxed.weights[~scene.graph.is_odometry & ~scene.is_lie].min()),
        "0.0002": float(relaxed.weights[scene.is_lie][0]),
        "1.058824": x[2] - x[0],
        "1.06": x[2],
        "0.53": x[1],
        "847.058824": cost(three),
        "-4.7": u[0],
        "-18.8": u[2],
        "21.2": u[3],
        "448.4429": u[3] ** 2,
        "398.6159": float(u[:3] @ u[:3]),
        "0.222222": alone.initial()[2],
        "-8.89": hidden[0],
        "4.44": hidden[2],
        "1.22": x5[3],
        "2.22": x5[4],
        "1.11": float(np.linalg.norm(folded_pentagon[2, :2])),
        "1.995565": length([2, 0], [0.05, 1.0]),
        "0.086124": length([2, 0], [0.05, 0.01]),
        "0.72": length([2, 0, 0], 0.05),
        "1.99888848": robust.x[2],
        "0.000625": robust.weights[3],
        "0.001877": outvoted.x[2],
        "1.529412": half.initial()[2],
        "211.764706": cost(half),
        "0.047140": 1 / math.sqrt(450),
        "8.470588": cost(chain_of(np.array([2.0, 0.0]), np.array([0.5, 0.5]), odometry=1.0)),
    }


def fractions() -> dict[str, float]:
    """Return each printed fraction with its value by the library, or by its meaning."""
    three = chain_of(np.array([2.0, 0.0]), np.array([0.05, 0.05]))
    x, centred = three.initial(), three.initial() + 1 - three.initial()[1]
    five = problems.chain(5, [0, 1, 2, 3, 1], [1, 2, 3, 4, 3], [1, 1, 1, 1, 0], [0.1] * 4 + [0.05])
    four = problems.chain(4, [0, 1, 2, 0], [1, 2, 3, 2], [1, 1, 1, 0], [0.1] * 3 + [0.05])
    half = chain_of(np.array([2.0, 1.0]), np.array([0.05, 0.05]))
    by_unit = length([2, 1], 0.05) - length([2, 0], 0.05)
    miss = half.initial()[2] - 2
    assert centred[2] == pytest.approx(26 / 17)
    return {
        "18/17": x[2],
        "9/17": x[1],
        "900/850": x[2],
        "14400/17": cost(three),
        "8/17": centred[0],
        "26/17": half.initial()[2],
        "-8/17": miss,
        "64/289": miss**2,
        "81/289": (miss + 1) ** 2,
        "3600/17": cost(half),
        "144/17": cost(three) / 100,
        "2/9": length(0, 0.05),
        "100/450": length(0, 0.05),
        "-8/9": (five.residuals(five.initial()) * five.sigma)[1],
        "1/9": four.initial()[1],
        "11/9": four.initial()[3],
        "-62/17": length([2, -10], 0.05),
        "400/850": by_unit,
        "18/25": length([2, 0, 0], 0.05),
    }


def whole_numbers(scene: Town) -> set[int]:
    """Return the whole numbers from 100 on that the chapter may print."""
    three = chain_of(np.array([2.0, 0.0]), np.array([0.05, 0.05]))
    normal = three.jacobian.T @ (three.jacobian / three.sigma[:, None] ** 2)
    at_truth = float(np.sum(three.residuals(np.array([0.0, 1.0, 2.0])) ** 2))
    odometry, closure = 1 / 0.1**2, 1 / 0.05**2
    pull = odometry / 2 + closure
    values = [
        *np.linalg.eigvalsh(normal)[1:],
        at_truth,
        math.floor(cost(three)),
        *(odometry, closure, 2 * closure, pull, 2 * pull, pull + closure),
        *(len(scene.graph.edges), len(scene.graph.edges) - 1),
        100 / 0.01,
    ]
    return {round(float(value)) for value in values}


def test_each_claim_is_printed_and_rounds_to_its_value(claims: dict[str, float]) -> None:
    printed = prose.decimals(TEXT)
    for text, value in claims.items():
        assert text in printed, f"{text} is no longer printed: drop the claim"
        assert prose.rounds_to(float(value), text), f"{text} is printed, {value} is right"


def test_no_decimal_is_printed_without_a_claim(claims: dict[str, float]) -> None:
    assert prose.unchecked(TEXT, claims, GIVEN) == set()


def test_each_fraction_is_what_the_library_computes() -> None:
    known = fractions()
    found = {f"{a or c}/{b or d}" for a, b, c, d in FRACTION.findall(TEXT)}
    assert found == set(known)
    for text, value in known.items():
        top, bottom = text.split("/")
        assert float(top) / float(bottom) == pytest.approx(value, abs=1e-9), text


def test_each_large_whole_number_is_known(scene: Town) -> None:
    found = {int(number) for number in WHOLE.findall(TEXT)}
    assert found - GIVEN_WHOLE <= whole_numbers(scene)


def test_the_motions_named_in_the_text_are_eigenvectors_with_the_named_stiffness() -> None:
    three = chain_of(np.array([2.0, 0.0]), np.array([0.05, 0.05]))
    normal = three.jacobian.T @ (three.jacobian / three.sigma[:, None] ** 2)
    for stiffness, motion in ((0, (1, 1, 1)), (300, (1, -2, 1)), (1700, (-1, 0, 1))):
        assert f"**{stiffness}**, the vector $({motion[0]}, {motion[1]}, {motion[2]})$" in TEXT
        assert normal @ motion == pytest.approx(stiffness * np.array(motion))


def test_the_lesson_of_the_lie_is_what_the_picture_shows(scene: Town) -> None:
    i, j = scene.graph.edges[-1]
    apart = np.linalg.norm(scene.folded[i, :2] - scene.folded[j, :2])
    assert apart < 0.1 * np.linalg.norm(scene.truth[i, :2] - scene.truth[j, :2])
    assert scene.weights[scene.is_lie] < 1e-3
    assert int(scene.graph.is_odometry.sum()) == 99
    assert "100 poses, 99 steps of odometry, 12 honest loop closures" in TEXT


def test_half_of_the_honest_closures_fall_to_a_third(scene: Town) -> None:
    honest = scene.weights[~scene.graph.is_odometry & ~scene.is_lie]
    assert int(np.sum(honest <= 1 / 3)) == 6
    assert "half of the twelve inlier closures fall to a third" in TEXT


def test_every_measurement_of_the_town_claims_what_the_page_says(scene: Town) -> None:
    sigma = np.sqrt(1 / np.diagonal(scene.graph.information, axis1=1, axis2=2))
    assert sigma == pytest.approx(np.tile([0.05, 0.05, 0.02], (112, 1)))
    assert "the lie too, claim 5 cm and 0.02 rad" in TEXT


def test_a_sigma_of_the_pentagon_comes_with_half_of_it_for_the_heading(
    page: dict[str, Any],
) -> None:
    graph = page["five_poses"](True, True, 0.2)
    sigma = np.sqrt(1 / np.diagonal(graph.information, axis1=1, axis2=2))
    assert sigma[:, 0] == pytest.approx([0.1] * 4 + [0.05, 0.2])
    assert sigma[:, 2] == pytest.approx(sigma[:, 0] / 2)
    assert "comes with $s/2$ rad for the heading" in TEXT


def test_the_edges_off_the_cycle_of_the_lie_keep_their_residual(page: dict[str, Any]) -> None:
    graph = page["five_poses"](True, False, 0.1)
    poses = page["gauss_newton"](graph, page["pentagon"])
    norms = pose_graph.residual_norms(poses, graph)
    assert norms[2:4] == pytest.approx([0, 0], abs=1e-6)
    assert min(norms[[0, 1, 4]]) > 1


def test_the_quiz_gives_nothing_away_by_place_or_length(page: dict[str, Any]) -> None:
    questions = [value for value in page.values() if isinstance(value, page["Question"])]
    right = [[option.correct for option in q.options].index(True) for q in questions]
    assert len(questions) == 6
    assert {0, 2, 3} <= set(right)
    for question, place in zip(questions, right, strict=True):
        lengths = [len(option.text) for option in question.options]
        assert lengths[place] <= max(lengths[:place] + lengths[place + 1 :]), question.prompt


def test_the_page_draws_the_town_of_the_readme() -> None:
    cell = CELLS["opening-picture"]
    assert "default_rng(2)" in cell
    assert "manhattan(100, rng, side=9, turn=0.25, closures=12)" in cell
    assert "add_random_closures(honest, 1, rng, poses=truth)" in cell
