"""Chapter 08 prints the numbers that the library computes, and no others."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import nbformat
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

from tests.book import prose

NOTEBOOK = nbformat.read(prose.CHAPTERS / "08-showcase.ipynb", as_version=4)
CELLS = {cell["id"]: cell.source for cell in NOTEBOOK.cells}
TEXT = prose.chapter_text("08-showcase.ipynb").replace("−", "-")
C = chi_square_threshold(0.99, 3)
SEEDS = range(5)

# Noise, scales, and the error from which on a town counts as lost.
GIVEN = {"0.05", "0.02", "0.2", "2.666", "0.4"}
TIRED = (0.2, 0.2)
# What 18 consistent lies leave of the pipeline's map in each town: its error.
LEFT = {0: "1.94", 1: "0.32", 2: "0.26", 3: "1.95", 4: "0.73"}


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """The names that the page's own cells define: its towns, its methods and its sweep."""
    names: dict[str, Any] = {"C": C}
    for cell in ("imports", "town", "methods", "canvas-draw", "sweep-run"):
        exec(CELLS[cell].replace("use_style()\n", ""), names)
    return names


@pytest.fixture(scope="module")
def towns(page: dict[str, Any]) -> SimpleNamespace:
    return SimpleNamespace(**{name: page[name] for name in ("with_lies", "four_maps", "scores")})


def kept_of(towns: SimpleNamespace, method: str, *world: object) -> tuple[int, int]:
    """Return how many honest closures, and how many lies, a method keeps."""
    graph, is_lie, _ = towns.with_lies(*world)
    kept = towns.four_maps(*world)[method][1] & ~graph.is_odometry
    return int(np.sum(kept & ~is_lie)), int(np.sum(kept & is_lie))


def lost(page: dict[str, Any], kind: str, method: str) -> list[int]:
    """Return how many of the five towns are more than 0.4 m off, for each share of lies."""
    return np.sum(page["grid"][kind, method][..., 0] > 0.4, axis=0).tolist()


def first_mus(towns: SimpleNamespace, seed: int) -> tuple[float, float]:
    """Return the first μ of GNC with 12 consistent lies: from least squares, and from odometry."""
    graph, _, _ = towns.with_lies("consistent", 12, seed)
    problem = PoseGraphProblem(graph, steps=1, tol=1e-6)
    one, other = (
        graduation.start_mu(float(problem.residual_norms(poses)[~graph.is_odometry].max()), C)
        for poses in (problem.initial(), problem.guess)
    )
    return one, other


@pytest.fixture(scope="module")
def claims(page: dict[str, Any], towns: SimpleNamespace) -> dict[str, float]:
    graph, _, truth = towns.with_lies("random", 0)
    walked, solved = spanning_tree(graph), PoseGraphProblem(graph).initial()
    walks = [
        ate(spanning_tree(world), true)
        for world, _, true in (towns.with_lies("random", 0, seed) for seed in SEEDS)
    ]
    quarter = math.pi / 4
    noise = page["Noise"](odometry=TIRED)
    tired = [towns.scores("random", 12, seed, noise)["pipeline"] for seed in SEEDS]
    tired_walks = [
        ate(spanning_tree(world), true)
        for world, _, true in (towns.with_lies("random", 0, seed, noise) for seed in SEEDS)
    ]
    misled = [error for error, precision, _ in tired if precision < 1.0]
    minority = towns.scores("consistent", 8, 3)["GNC-TLS"]
    bold, timid = first_mus(towns, page["SEED"])
    return {
        "0.785398": quarter,
        "1.570796": 2 * quarter,
        "81.6210": math.sqrt(2 * (quarter / 0.05) ** 2 + (2 * quarter / 0.02) ** 2),
        "3.3682": C,
        "4.1002": chi_square_threshold(0.99, 6),
        "0.0154": bold,
        "0.000539": timid,
        "0.110": float(graduation.tls_weight(C, C, bold)),
        "0.023": float(graduation.tls_weight(C, C, timid)),
        "0.26": ate(walked, truth),
        "0.10": ate(solved, truth),
        "22.22": pose_graph.cost(solved, graph),
        "1.414214": math.sqrt((1 + 1 + 4) / 3),
        "1.732051": math.sqrt(9 / 3),
        "0.9": 9 / 10,
        "0.75": 9 / 12,
        "0.917": 11 / 12,
        "0.32": float(np.median(walks)),
        "0.20": minority[1],
        "0.17": minority[2],
        "1.61": min(misled),
        "2.31": max(misled),
        "1.7": min(tired_walks),
        "6.2": max(tired_walks),
        **{LEFT[seed]: towns.scores("consistent", 18, seed)["pipeline"][0] for seed in (0, 3, 4)},
        "-0.1": -5 * 0.02,
        "-0.02": -0.02,
        "2.236068": math.sqrt(5),
    }


def test_each_claim_is_printed_and_rounds_to_its_value(claims: dict[str, float]) -> None:
    printed = prose.decimals(TEXT)
    for text, value in claims.items():
        assert text in printed, f"{text} is no longer printed: drop the claim"
        assert prose.rounds_to(float(value), text), f"{text} is printed, {value} is right"


def test_no_decimal_is_printed_without_a_claim(claims: dict[str, float]) -> None:
    assert prose.unchecked(TEXT, claims, GIVEN) == set()


def test_what_is_given_is_printed() -> None:
    assert prose.decimals(TEXT) >= GIVEN


def test_the_cost_that_is_left_is_counted_as_the_text_counts_it(towns: SimpleNamespace) -> None:
    graph, _, _ = towns.with_lies("random", 0)
    assert (3 * len(graph.edges), 3 * (graph.n - 1)) == (303, 267)
    assert "That leaves 18 on average" in TEXT
    assert (303 - 267) / 2 == 18


def test_pcm_finds_eleven_honest_closures_and_then_twelve_lies(towns: SimpleNamespace) -> None:
    for kind, size, honest in (("random", 11, 11), ("consistent", 12, 0)):
        graph, is_lie, _ = towns.with_lies(kind, 12)
        said = pairwise.pcm(graph, C)
        true = ~is_lie[said.closures]
        assert said.clique.members.size == size
        assert np.sum(true[said.clique.members]) == honest
        among_honest = said.adjacency[np.ix_(true, true)]
        assert np.sum(np.triu(~among_honest, 1)) == 3
        assert np.sum(~among_honest, axis=0).max() == 3


def test_after_pcm_gnc_rejects_nobody(towns: SimpleNamespace) -> None:
    graph, _, _ = towns.with_lies("random", 12)
    answer = pipeline.solve(graph)
    doubted = ~pose_graph.select(graph, answer.consistency.kept).is_odometry
    first = answer.result.history[1].weights[doubted]
    assert np.all((first > 0.0) & (first < 1.0))
    assert "Twelve solves later all are 1" in TEXT
    assert len(answer.result.history) - 1 == 12
    assert np.all(answer.result.weights == 1.0)
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
def test_each_method_is_lost_in_the_town_from_the_named_number_of_lies_on(
    method: str, kind: str, count: int, towns: SimpleNamespace, page: dict[str, Any]
) -> None:
    for lies in page["LIES"].values():
        error = towns.scores(kind, lies)[method][0]
        assert (error > 0.4) == (lies >= count), lies


def test_at_60_percent_irls_has_the_smallest_error(towns: SimpleNamespace) -> None:
    errors = {name: score[0] for name, score in towns.scores("consistent", 18).items()}
    assert min(errors, key=errors.__getitem__) == "IRLS"


def test_the_pipeline_keeps_nobody_in_the_town_and_then_the_lies(towns: SimpleNamespace) -> None:
    for count in (12, 18):
        assert kept_of(towns, "pipeline", "consistent", count) == (0, 0)
        assert prose.rounds_to(towns.scores("consistent", count)["pipeline"][0], "0.26")
    assert kept_of(towns, "pipeline", "consistent", 36) == (0, 31)
    assert "Of 36 lies that agree it keeps 31" in TEXT
    answer = pipeline.solve(towns.with_lies("consistent", 36)[0])
    assert answer.certificate.verdict is Verdict.CERTIFIED


def test_the_sweep_says_what_the_text_says(page: dict[str, Any]) -> None:
    assert page["shares"] == [20, 40, 50, 60, 75]
    assert lost(page, "random", "least squares") == [5] * 5
    for method in ("IRLS", "GNC-TLS", "pipeline"):
        assert lost(page, "random", method) == [0] * 5
        values = page["grid"]["random", method]
        assert values[..., 2].min() >= 11 / 12
        assert values[..., 1].min() == 1.0
    assert lost(page, "consistent", "least squares") == [5] * 5
    assert lost(page, "consistent", "GNC-TLS") == [0, 2, 4, 4, 4]
    assert lost(page, "consistent", "pipeline") == [0, 0, 0, 3, 4]
    assert lost(page, "consistent", "IRLS") == [0, 0, 0, 0, 1]
    assert int(page["grid"]["consistent", "IRLS"][:, -1, 0].argmax()) == page["SEED"] == 2
    solves = len(page["grid"]) * len(page["shares"]) * len(page["seeds"])
    assert f"{solves} solves" in TEXT


def test_a_fault_of_one_town_in_ten_is_missed_by_most_sweeps_of_five() -> None:
    assert "0.9^5 = 59\\,\\%" in TEXT
    assert round(100 * 0.9**5) == 59


def test_a_minority_misleads_gnc_in_two_towns_and_costs_a_third_its_honest_closures(
    towns: SimpleNamespace,
) -> None:
    errors = [towns.scores("consistent", 8, seed)["GNC-TLS"][0] for seed in SEEDS]
    assert [seed for seed in SEEDS if errors[seed] > 0.4] == [0, 3]
    assert kept_of(towns, "GNC-TLS", "consistent", 8, 3) == (2, 8)
    assert kept_of(towns, "GNC-TLS", "consistent", 8, 4) == (6, 0)
    assert all(kept_of(towns, "pipeline", "consistent", 8, seed)[1] == 0 for seed in SEEDS)


def test_a_majority_gets_its_map_certified(towns: SimpleNamespace) -> None:
    honest, lies = zip(
        *(kept_of(towns, "pipeline", "consistent", 18, seed) for seed in SEEDS), strict=True
    )
    assert honest == (0, 0, 0, 0, 0)
    assert lies == (18, 0, 0, 18, 0)
    for seed in SEEDS:
        graph, _, truth = towns.with_lies("consistent", 18, seed)
        walked = ate(spanning_tree(graph), truth)
        error = towns.scores("consistent", 18, seed)["pipeline"][0]
        assert (error == pytest.approx(walked, abs=1e-6)) == (seed in (1, 2, 4))
        assert prose.rounds_to(error, LEFT[seed])
        answer = pipeline.solve(towns.with_lies("consistent", 18, seed)[0])
        assert answer.certificate.verdict is Verdict.CERTIFIED


def test_tired_odometry_lets_random_lies_in(page: dict[str, Any], towns: SimpleNamespace) -> None:
    noise = page["Noise"](odometry=TIRED)
    kept = {
        method: [kept_of(towns, method, "random", 12, seed, noise) for seed in SEEDS]
        for method in ("IRLS", "GNC-TLS", "pipeline")
    }
    assert [lies for _, lies in kept["pipeline"]] == [1, 0, 1, 0, 0]
    assert [lies for _, lies in kept["IRLS"]] == [2, 0, 2, 0, 1]
    assert sorted(kept["GNC-TLS"]) == [(11, 12)] + [(12, 12)] * 4
    passed = []
    for seed in SEEDS:
        graph, is_lie, _ = towns.with_lies("random", 12, seed, noise)
        passed.append(int(np.sum(pairwise.pcm(graph, C).kept & is_lie)))
    assert (min(passed), max(passed)) == (1, 5)


def test_at_half_the_noise_the_pipeline_keeps_no_random_lie(
    page: dict[str, Any], towns: SimpleNamespace
) -> None:
    noise = page["Noise"](odometry=tuple(sigma / 2 for sigma in TIRED))
    lies = [kept_of(towns, "pipeline", "random", 12, seed, noise)[1] for seed in SEEDS]
    assert lies == [0] * 5


def test_the_exercises_by_hand() -> None:
    turned = pose_graph.PoseGraph(2, [[0, 1]], [[5.0, 0.0, 0.0]], [np.eye(3)], [False])
    by_i, _ = pose_graph.jacobians(np.array([[0.0, 0, 0], [5.0, 0, 0]]), turned)
    change = by_i[0][:, 2] * 0.02
    assert change == pytest.approx([0, -0.1, -0.02])
    assert np.linalg.norm(change / [0.05, 0.05, 0.02]) == pytest.approx(math.sqrt(5))


def test_the_quiz_gives_nothing_away_by_place_or_length() -> None:
    names: dict[str, Any] = {}
    for cell in (name for name, source in CELLS.items() if "Question(" in source):
        exec(CELLS[cell], names)
    questions = [value for value in names.values() if isinstance(value, names["Question"])]
    right = [[option.correct for option in q.options].index(True) for q in questions]
    assert len(questions) == 5
    assert set(right) == {0, 1, 2, 3}
    for question, place in zip(questions, right, strict=True):
        lengths = [len(option.text) for option in question.options]
        others = lengths[:place] + lengths[place + 1 :]
        assert lengths[place] <= 1.3 * max(others), question.prompt
