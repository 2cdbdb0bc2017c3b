"""Chapter 09 prints the numbers that the library computes."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from importlib.resources import files
from typing import Any

import numpy as np
import pytest
from robust_slam import certificates, pipeline
from robust_slam.certificates.optimality import Verdict, certificate
from robust_slam.consistency.pairwise import pcm
from robust_slam.descent import start
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.graphs import pose_graph
from robust_slam.problems import PoseGraphProblem
from robust_slam_course import pictures
from robust_slam_course.failures import FAULTS, measured, outcome
from robust_slam_course.plots.stages import STAGES
from scipy.stats import chi2

from tests.book.prose import Chapter, Numbers, rounds_to
from tools.data import machine

CHAPTER = Chapter("09-frontiers")
C = chi_square_threshold(0.99, 3)
LEFT_BRANCH = ("sensors", "features", "views", "ransac", "odometry", "control")
CELLS = ("imports", "outcomes-table", "break-covariance-run", "ransac-run")


class Page:
    """The names that the page's own cells define, and its experiments."""

    def __init__(self) -> None:
        names = CHAPTER.run(*CELLS, C=C)
        vars(self).update(names)
        self.outcomes = {stage: self.score(stage) for stage in ("nothing", *STAGES)}
        # For each factor rows of: inliers kept, outliers kept, error in m, bound, chi² ratio.
        self.by_factor = {f: self.with_sigma(f) for f in (0.25, 0.5, 1, 2, 4, 8)}
        self.ratio = {f: float(np.median(rows[:, 4])) for f, rows in self.by_factor.items()}

    def score(self, stage: str) -> tuple[float, int, int, int, str]:
        """Of a stage: error in m, correct and wrong closures kept, wrong ones told, verdict."""
        found = outcome(stage)
        wrong = found.is_outlier
        correct = inliers_kept(found.graph, found.kept, wrong)
        error = self.ate(found.poses, self.town()[2])
        told = int(wrong.sum())
        return error, correct, int(np.sum(found.kept & wrong)), told, found.verdict.value

    def of_branch(self, part: int) -> list[Any]:
        """A part of the outcome of each stage of the left branch."""
        return [self.outcomes[stage][part] for stage in LEFT_BRANCH]

    def left_by_gnc(self) -> list[int]:
        """How many closures GNC keeps in each stage of the left branch; all are inliers."""
        left = []
        for stage in LEFT_BRANCH:
            graph, wrong = measured(FAULTS[stage])
            left.append(self.kept_by_gnc(graph, wrong))
        return left

    def kept_by_gnc(self, graph: Any, wrong: np.ndarray) -> int:
        """How many inlier closures PCM and GNC leave in the pipeline, before some return."""
        answer = pipeline.solve(graph)
        kept = answer.consistency.kept.copy()
        kept[kept] = answer.result.kept
        return inliers_kept(graph, kept, wrong)

    def kept_by_gnc_where_sigma_is_half(self, seed: int) -> int:
        """The same in a town where every edge claims half of its deviation."""
        graph, wrong, _ = self.town(seed, "random", 12)
        precise = dataclasses.replace(graph, information=graph.information * 4)
        return self.kept_by_gnc(precise, wrong)

    def before_and_after_gnc(self) -> tuple[list[int], list[int]]:
        """How many inlier closures PCM passes in each stage of the left branch, and GNC keeps."""
        passed, left = [], []
        for stage in LEFT_BRANCH:
            graph, wrong = measured(FAULTS[stage])
            consistent = pcm(graph, C).kept
            passed.append(inliers_kept(graph, consistent, wrong))
            squares = gnc(PoseGraphProblem(pose_graph.select(graph, consistent), steps=5), C)
            consistent[consistent] = squares.weights > 0.5
            left.append(inliers_kept(graph, consistent, wrong))
        return passed, left


def inliers_kept(graph: Any, kept: np.ndarray, wrong: np.ndarray) -> int:
    return int(np.sum(kept & ~graph.is_odometry & ~wrong))


def costs_among_outliers(page: Page) -> list[float]:
    """Of the least-squares map among the outliers, and of the map from the chordal start."""
    graph, _, _ = page.town()
    stuck = certificate(graph, outcome("solve").poses)
    _, other = certificates.certify(graph, start.chordal(graph))
    assert other.verdict is Verdict.NOT_CERTIFIED
    return [stuck.cost, other.cost]


@pytest.fixture(scope="module")
def page() -> Page:
    return Page()


FORMULAS = {
    "16.008": lambda page: math.log(0.01) / math.log(0.75),
    "0.168 0.832": lambda page: [0.7**5, 1 - 0.7**5],
    "25.03": lambda page: math.log(0.01) / math.log(1 - 0.7**5),
    "0.992": lambda page: 1 - 0.75**17,
    "82.5": lambda page: 100 * page.share_found(17),
    "3.37 1.68": lambda page: [C, C / 2],
    "2.58": lambda page: chi_square_threshold(0.99, 1),
    "3.56 0.19": lambda page: [89 * 0.04, 0.02 * math.sqrt(89)],
    "0.09": lambda page: page.outcomes["nothing"][0],
    "0.61 2.97": lambda page: [min(page.of_branch(0)), max(page.of_branch(0))],
    "0.33": lambda page: page.outcomes["plan"][0],
    "2.05": lambda page: page.outcomes["places"][0],
    "0.94 0.23 1.92": lambda page: [page.ratio[f] for f in (1, 2, 0.5)],
    "2.44": lambda page: page.by_factor[8][0, 2],
    "0.60": lambda page: page.by_factor[8][0, 4],
    "0.55": lambda page: page.by_factor[1][:, 4].min(),
    "0 to 7 of 18": lambda page: [min(page.of_branch(1)), max(page.of_branch(1)), 18],
    "Of the 72 inliers": lambda page: 6 * 12,
    "PCM passes 26 and GNC keeps 15": lambda page: [
        sum(page.before_and_after_gnc()[0]),
        sum(page.left_by_gnc()),
    ],
    "GNC would keep 23": lambda page: sum(page.before_and_after_gnc()[1]),
    "3.91": lambda page: costs_among_outliers(page)[0] / 1e4,
    "3.63": lambda page: costs_among_outliers(page)[1] / 1e4,
    "23 of 60": lambda page: [60 - page.by_factor[0.5][:, 0].sum(), 60],
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Probabilities, ratios, noise, a factor and a version of other programs, data of exercises.
    given = "0.01 0.02 0.04 0.05 0.1 0.25 0.5 0.7 0.75 0.99 1.4 2.0 2.5"


@pytest.mark.parametrize(
    ("w", "s", "p", "count"),
    [
        (0.5, 8, 0.99, 1177),
        (0.5, 5, 0.99, 146),
        (0.5, 4, 0.99, 72),
        (0.5, 2, 0.99, 17),
        (0.7, 8, 0.99, 78),
        (0.7, 5, 0.99, 26),
        (0.7, 4, 0.99, 17),
        (0.7, 2, 0.99, 7),
    ],
)
def test_ransac_tries_are_the_fewest_that_suffice(page, w, s, p, count) -> None:
    assert page.tries(w, s, p) == count
    assert re.search(rf"\b{count}\b", CHAPTER.cells["ransac"])
    assert (1 - w**s) ** count <= 1 - p < (1 - w**s) ** (count - 1)


def test_fifty_tries_find_the_motion_every_time(page) -> None:
    assert "With 50 tries it was found every time" in CHAPTER.text
    assert page.share_found(50) == 1.0


def test_with_faults_of_the_odometry_no_outlier_is_kept(page) -> None:
    assert page.of_branch(2) == [0] * 6
    assert page.outcomes["nothing"][1] == 12


def test_outliers_that_agree_are_kept_from_some_number_on(page) -> None:
    assert page.outcomes["places"][1:] == (1, 22, 24, "certified")
    graph, wrong, truth = page.town(kind="aliased", count=18)
    answer = pipeline.solve(graph)
    assert np.sum(answer.consistency.kept & ~graph.is_odometry) == 18
    assert np.sum(answer.result.kept) == np.sum(graph.is_odometry)
    assert np.array_equal(answer.kept, ~wrong)
    assert rounds_to(page.ate(answer.poses, truth), "0.09")


def test_gnc_without_pcm_rejects_the_outliers_that_agree(page) -> None:
    graph, wrong, truth = page.town(kind="aliased", count=24)
    consistent = pcm(graph, C).kept & ~graph.is_odometry
    assert np.array_equal(consistent, wrong)
    alone = gnc(graph, C)
    assert np.array_equal(alone.weights > 0.5, ~wrong)
    assert rounds_to(page.ate(alone.x, truth), "0.09")
    assert "without* PCM rejects all 24, and the error is 0.09 m" in CHAPTER.text


def test_two_searches_that_got_stuck_are_not_certified(page) -> None:
    refused = {stage for stage, score in page.outcomes.items() if score[4] != "certified"}
    assert refused == {"solve", "certificate"}


def test_pcm_can_be_left_out_here(page) -> None:
    with_pcm, without = page.outcomes["nothing"], page.outcomes["pcm"]
    assert without[:3] == pytest.approx(with_pcm[:3])


def test_a_sigma_wrong_by_a_factor_does_what_the_text_says(page) -> None:
    outliers = {f: int(rows[:, 1].sum()) for f, rows in page.by_factor.items()}
    assert outliers == {0.25: 0, 0.5: 0, 1: 0, 2: 0, 4: 0, 8: 5}
    assert page.by_factor[0.25][:, 0].sum() == 2
    assert sum(map(page.kept_by_gnc_where_sigma_is_half, range(5))) == 60 - 29
    assert page.by_factor[8][:, 2].argmax() == 0
    assert rounds_to(page.ratio[8], "0.02")
    assert np.sum(np.isnan(page.by_factor[0.25][:, 4])) == 3
    misled = np.concatenate([rows[rows[:, 1] > 0.0, 4] for rows in page.by_factor.values()])
    assert misled.min() > 0.01 > min(np.nanmin(rows[:, 4]) for rows in page.by_factor.values())
    assert max(rows[:, 3].max() for rows in page.by_factor.values()) < 1e-3


@pytest.mark.parametrize(
    ("factor", "inliers", "outliers"), [(0.5, 36, 0), (4, 57, 3), (8, 55, 21)]
)
def test_what_pcm_passes_where_sigma_is_wrong(page, factor, inliers, outliers) -> None:
    passed = np.zeros(2, dtype=int)
    for seed in range(5):
        graph, wrong, _ = page.town(seed, "random", 12)
        graph = dataclasses.replace(graph, information=graph.information / factor**2)
        kept = pcm(graph, C).kept
        passed += inliers_kept(graph, kept, wrong), int(np.sum(kept & wrong))
    assert passed.tolist() == [inliers, outliers]


def test_half_a_sigma_passes_58_percent() -> None:
    assert round(100 * chi2.cdf((C / 2) ** 2, 3)) == 58


def test_a_common_factor_leaves_the_best_map_alone(page) -> None:
    graph, wrong, _ = page.town(0, "random", 12)
    inliers = pose_graph.select(graph, ~wrong)
    scaled = dataclasses.replace(inliers, information=inliers.information / 4)
    one, two = (certificates.certify(g, start.chordal(g))[0] for g in (inliers, scaled))
    np.testing.assert_allclose(one, two, atol=1e-6)


def test_the_exercise_with_a_modest_sigma() -> None:
    assert 0.25 / 0.1 < chi_square_threshold(0.99, 1) < 0.25 / 0.05


@pytest.mark.parametrize(
    ("turn", "cost", "verdict"),
    [
        (0.0, 0.0, Verdict.CERTIFIED),
        (math.pi / 3, 6 * 4 * (1 - math.cos(math.pi / 3)), Verdict.NOT_CERTIFIED),
        (math.radians(50), None, Verdict.NOT_STATIONARY),
    ],
)
def test_the_ring_of_the_capstone_costs_12_and_is_refused(turn, cost, verdict) -> None:
    ends = [[k, (k + 1) % 6] for k in range(6)]
    ring = pose_graph.PoseGraph(6, ends, np.zeros((6, 3)), [np.eye(3)] * 6, np.arange(6) < 5)
    proof = certificate(ring, np.outer(np.arange(6), [0.0, 0.0, turn]))
    assert proof.verdict is verdict
    assert cost is None or proof.cost == pytest.approx(cost, abs=1e-9)


def test_the_bus_wins_when_it_has_more_matches(page) -> None:
    assert [page.street_wins(bus) for bus in (20, 30, 50, 60)] == [1, 1, 0, 0]
    assert 0.2 < page.street_wins(40) < 0.8


def test_the_live_picture_shows_the_outcomes_of_the_page() -> None:
    text = files("robust_slam_course.pictures").joinpath("machine.json").read_text("utf-8")
    shown, made = json.loads(text), machine.table()
    for stage, found in made["outcomes"].items():
        there = shown["outcomes"][stage]
        np.testing.assert_allclose(there.pop("poses"), found.pop("poses"), atol=0.011)
        assert there.pop("off") == pytest.approx(found.pop("off"), abs=1e-3)
        assert there == found, stage
    assert shown["truth"] == made["truth"]


def test_the_first_caption_of_the_live_picture_says_what_is_seen(page) -> None:
    error, correct, wrong, _, verdict = page.outcomes["nothing"]
    chain = f"PCM keeps {correct} and {wrong}, GNC {correct} and {wrong}, the map 12 and 0."
    said = f"Of 12 inliers and 6 outliers {chain} The map is {error:.2f} m off and {verdict}."
    assert said in pictures.machine().caption


def test_a_wrong_factor_is_another_threshold_of_tls() -> None:
    u, f, c = np.linspace(0.0, 9.0, 50), 2.5, 3.0
    claimed = np.minimum((u / f) ** 2, c**2)
    np.testing.assert_allclose(claimed, np.minimum(u**2, (f * c) ** 2) / f**2)
