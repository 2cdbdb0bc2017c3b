"""Chapter 08 prints the numbers that the library computes, and no others."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from robust_slam import pipeline
from robust_slam.certificates.optimality import Verdict
from robust_slam.consistency import pairwise
from robust_slam.estimators import graduation
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import pose_graph
from robust_slam.graphs.metrics import ate
from robust_slam.graphs.odometry import spanning_tree
from robust_slam.problems import PoseGraphProblem

from tests.book.prose import Chapter, Numbers, rounds_to
from tests.book.samples import assert_right_options_are_hidden

pytestmark = pytest.mark.long

CHAPTER = Chapter("08-showcase")
C = chi_square_threshold(0.99, 3)
SEEDS = range(5)
# What 18 consistent outliers leave of the pipeline's map in each town: its error.
LEFT = {0: "1.96", 1: "0.10", 2: "0.10", 3: "1.97", 4: "0.13"}
# The error from which on a town counts as lost.
LOST = 0.4


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The names that the page's own cells define: its towns, its methods and its sweep."""
    cells = ("imports", "town", "methods", "town-table", "sweep-run")
    page = SimpleNamespace(**CHAPTER.run(*cells, C=C))
    page.tired = page.Noise(odometry=(0.2, 0.2))
    page.minority = page.scores("consistent", 8, 3)["GNC-TLS"]
    return page


def kept_of(page, method: str, *world: object) -> tuple[int, int]:
    """Return how many inlier closures, and how many outliers, a method keeps."""
    graph, wrong, _ = page.with_outliers(*world)
    kept = page.four_maps(*world)[method][1] & ~graph.is_odometry
    return int(np.sum(kept & ~wrong)), int(np.sum(kept & wrong))


def lost(page, kind: str, method: str) -> list[int]:
    """Return how many of the five towns are lost, for each share of outliers."""
    return np.sum(page.grid[kind, method][..., 0] > LOST, axis=0).tolist()


def first_mus(page) -> list[float]:
    """The first μ of GNC with 12 consistent outliers: from least squares, and from odometry."""
    graph, _, _ = page.with_outliers("consistent", 12, page.SEED)
    problem = PoseGraphProblem(graph, steps=1, tol=1e-6)
    return [
        graduation.start_mu(float(problem.residual_norms(poses)[~graph.is_odometry].max()), C)
        for poses in (problem.initial(), problem.guess)
    ]


def solved(page) -> tuple[pose_graph.PoseGraph, np.ndarray, np.ndarray]:
    """The town without outliers, its least-squares map, and the truth."""
    graph, _, truth = page.with_outliers("random", 0)
    return graph, PoseGraphProblem(graph).initial(), truth


def walks(page, *noise: object) -> list[float]:
    """The error of dead reckoning in each town."""
    towns = (page.with_outliers("random", 0, seed, *noise) for seed in SEEDS)
    return [ate(spanning_tree(graph), truth) for graph, _, truth in towns]


def misled(page) -> tuple[float, float]:
    """The pipeline's least and largest error where tired odometry let outliers in."""
    scores = (page.scores("random", 12, seed, page.tired)["pipeline"] for seed in SEEDS)
    errors = [error for error, precision, _ in scores if precision < 1.0]
    return min(errors), max(errors)


FORMULAS = {
    "81.6": lambda page: math.sqrt(2 * (math.pi / 4 / 0.05) ** 2 + (math.pi / 2 / 0.02) ** 2),
    "3.37": lambda page: C,
    "0.0154 0.000539": lambda page: first_mus(page),
    "0.110 0.023": lambda page: [graduation.tls_weight(C, C, mu) for mu in first_mus(page)],
    "0.26": lambda page: walks(page)[page.SEED],
    "0.10": lambda page: ate(*solved(page)[1:]),
    "1.41": lambda page: math.sqrt((1 + 1 + 4) / 3),
    "0.9 0.75 0.917": lambda page: [18 / 20, 9 / 12, 11 / 12],
    "0.32": lambda page: np.median(walks(page)),
    "0.20 0.17": lambda page: page.minority[1:],
    "1.61 2.31": lambda page: misled(page),
    "1.7 6.2": lambda page: [f(walks(page, page.tired)) for f in (min, max)],
    "1.96 1.97": lambda page: [
        page.scores("consistent", 18, seed)["pipeline"][0] for seed in (0, 3)
    ],
    "-0.1": lambda page: -5 * 0.02,
    "-0.02": lambda page: -0.02,
    "2.24": lambda page: math.sqrt(5),
    "The cost is 22.2": lambda page: pose_graph.cost(*solved(page)[:2]),
    "its expected value is 18": lambda page: (
        (3 * len(solved(page)[0].edges) - 3 * (solved(page)[0].n - 1)) / 2
    ),
    "Of 36 consistent outliers it keeps 32": lambda page: [
        36,
        kept_of(page, "pipeline", "consistent", 36)[1],
    ],
    "0.9^5 = 59\\,\\%": lambda page: [0.9, 5, 100 * 0.9**5],
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Noise, scales, the error from which on a town counts as lost, parameters of the sweep.
    given = "0.05 0.02 0.2 2.666 0.4"


def test_the_cost_that_is_left_is_counted_as_the_text_counts_it(page) -> None:
    graph = solved(page)[0]
    assert (3 * len(graph.edges), 3 * (graph.n - 1)) == (303, 267)


def test_pcm_finds_eleven_inlier_closures_and_then_twelve_outliers(page) -> None:
    for kind, size, inliers in (("random", 11, 11), ("consistent", 12, 0)):
        graph, is_outlier, _ = page.with_outliers(kind, 12)
        said = pairwise.pcm(graph, C)
        true = ~is_outlier[said.closures]
        assert said.clique.members.size == size
        assert np.sum(true[said.clique.members]) == inliers
        among_inliers = said.adjacency[np.ix_(true, true)]
        assert np.sum(np.triu(~among_inliers, 1)) == 3
        assert np.sum(~among_inliers, axis=0).max() == 3
        among_outliers = said.adjacency[np.ix_(~true, ~true)]
        if kind == "random":
            assert among_inliers.shape == (12, 12)
            assert np.sum(np.triu(among_outliers, 1)) == 3
            assert np.sum(np.triu(said.adjacency, 1)) == 66  # no inlier agrees with an outlier


def test_after_pcm_gnc_rejects_no_closure(page) -> None:
    graph, _, _ = page.with_outliers("random", 12)
    answer = pipeline.solve(graph)
    doubted = ~pose_graph.select(graph, answer.consistency.kept).is_odometry
    first = answer.result.history[1].weights[doubted]
    assert np.all((first > 0.0) & (first < 1.0))
    assert "Eleven solves later all are 1" in CHAPTER.text
    assert len(answer.result.history) - 1 == 11
    assert np.all(answer.result.weights == 1.0)
    assert answer.returned.size == 0
    assert answer.certificate.verdict is Verdict.CERTIFIED


@pytest.mark.parametrize(
    ("method", "kind", "count"),
    [
        ("least squares", "random", 1),
        ("least squares", "consistent", 1),
        ("GNC-TLS", "consistent", 12),
        ("pipeline", "consistent", 36),
        ("IRLS", "consistent", 36),
    ],
)
def test_each_method_is_lost_from_the_named_number_of_outliers_on(
    method: str, kind: str, count: int, page
) -> None:
    for outliers in page.OUTLIERS.values():
        error = page.scores(kind, outliers)[method][0]
        assert (error > LOST) == (outliers >= count), outliers


def test_at_60_percent_irls_has_the_smallest_error(page) -> None:
    errors = {name: score[0] for name, score in page.scores("consistent", 18).items()}
    assert min(errors, key=errors.__getitem__) == "IRLS"


def test_inliers_return_to_dead_reckoning_in_the_town_until_outliers_bend_it(page) -> None:
    for count in (12, 18):
        graph, _, truth = page.with_outliers("consistent", count)
        answer = pipeline.solve(graph)
        assert np.sum(answer.result.kept) == np.sum(graph.is_odometry)
        assert rounds_to(ate(answer.result.x, truth), "0.26")
        assert kept_of(page, "pipeline", "consistent", count) == (11, 0)
    assert kept_of(page, "pipeline", "consistent", 36) == (0, 32)
    answer = pipeline.solve(page.with_outliers("consistent", 36)[0])
    assert answer.certificate.verdict is Verdict.CERTIFIED


def test_the_sweep_says_what_the_text_says(page) -> None:
    assert page.shares == [20, 40, 50, 60, 75]
    assert lost(page, "random", "least squares") == [5] * 5
    for method in ("IRLS", "GNC-TLS", "pipeline"):
        assert lost(page, "random", method) == [0] * 5
        values = page.grid["random", method]
        assert values[..., 2].min() >= 11 / 12
        assert values[..., 1].min() == 1.0
    assert lost(page, "consistent", "least squares") == [5] * 5
    assert lost(page, "consistent", "GNC-TLS") == [0, 2, 4, 4, 4]
    assert lost(page, "consistent", "pipeline") == [0, 0, 0, 2, 3]
    assert lost(page, "consistent", "IRLS") == [0, 0, 0, 0, 1]
    assert int(page.grid["consistent", "IRLS"][:, -1, 0].argmax()) == page.SEED == 2
    solves = len(page.grid) * len(page.shares) * len(page.seeds)
    assert f"{solves} solves" in CHAPTER.text


def test_a_minority_misleads_gnc_in_two_towns_and_costs_a_third_its_inliers(
    page,
) -> None:
    errors = [page.scores("consistent", 8, seed)["GNC-TLS"][0] for seed in SEEDS]
    assert [seed for seed in SEEDS if errors[seed] > LOST] == [0, 3]
    assert kept_of(page, "GNC-TLS", "consistent", 8, 3) == (2, 8)
    assert kept_of(page, "GNC-TLS", "consistent", 8, 4) == (6, 0)
    assert all(kept_of(page, "pipeline", "consistent", 8, seed)[1] == 0 for seed in SEEDS)


def test_a_majority_gets_its_map_certified(page) -> None:
    inliers, outliers = zip(
        *(kept_of(page, "pipeline", "consistent", 18, seed) for seed in SEEDS), strict=True
    )
    assert inliers == (2, 12, 11, 1, 12)
    assert outliers == (18, 0, 0, 18, 0)
    for seed in SEEDS:
        graph, is_outlier, truth = page.with_outliers("consistent", 18, seed)
        answer = pipeline.solve(graph)
        alone = not np.any(answer.result.kept & ~answer.graph.is_odometry[answer.consistency.kept])
        assert alone == (seed in (1, 2, 4))
        if alone:
            walked = ate(spanning_tree(graph), truth)
            assert ate(answer.result.x, truth) == pytest.approx(walked, abs=1e-4)
        assert not np.any(answer.consistency.kept & ~graph.is_odometry & ~is_outlier)
        assert rounds_to(page.scores("consistent", 18, seed)["pipeline"][0], LEFT[seed])
        assert answer.certificate.verdict is Verdict.CERTIFIED


def test_tired_odometry_lets_random_outliers_in(page) -> None:
    noise = page.tired
    kept = {
        method: [kept_of(page, method, "random", 12, seed, noise) for seed in SEEDS]
        for method in ("IRLS", "GNC-TLS", "pipeline")
    }
    assert [outliers for _, outliers in kept["pipeline"]] == [1, 0, 1, 0, 0]
    assert [outliers for _, outliers in kept["IRLS"]] == [2, 0, 2, 0, 1]
    assert sorted(kept["GNC-TLS"]) == [(11, 12)] + [(12, 12)] * 4
    passed = []
    for seed in SEEDS:
        graph, is_outlier, _ = page.with_outliers("random", 12, seed, noise)
        passed.append(int(np.sum(pairwise.pcm(graph, C).kept & is_outlier)))
    assert (min(passed), max(passed)) == (1, 5)


def test_at_half_the_noise_the_pipeline_keeps_no_random_outlier(page) -> None:
    noise = page.Noise(odometry=(0.1, 0.1))
    kept = [kept_of(page, "pipeline", "random", 12, seed, noise)[1] for seed in SEEDS]
    assert kept == [0] * 5


def test_the_exercises_by_hand() -> None:
    turned = pose_graph.PoseGraph(2, [[0, 1]], [[5.0, 0.0, 0.0]], [np.eye(3)], [False])
    by_i, _ = pose_graph.jacobians(turned, np.array([[0.0, 0, 0], [5.0, 0, 0]]))
    change = by_i[0][:, 2] * 0.02
    assert change == pytest.approx([0, -0.1, -0.02])
    assert np.linalg.norm(change / [0.05, 0.05, 0.02]) == pytest.approx(math.sqrt(5))


def test_the_quiz_gives_nothing_away_by_place_or_length() -> None:
    questions = CHAPTER.questions()
    assert len(questions) == 5
    assert assert_right_options_are_hidden(questions, 1.3) == {0, 1, 2, 3}
