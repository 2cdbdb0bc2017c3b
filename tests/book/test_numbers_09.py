"""Chapter 09 prints the numbers that the library computes, and its formulas are right."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from robust_slam import certificates, pipeline
from robust_slam.certificates.optimality import Verdict, certificate
from robust_slam.consistency.pairwise import pcm
from robust_slam.estimators import kernels
from robust_slam.estimators.graduation import gnc
from robust_slam.estimators.thresholds import chi_square_threshold
from robust_slam.fleet import rounds
from robust_slam.fleet.robot import Message
from robust_slam.graphs import pose_graph
from robust_slam.problems import PoseGraphProblem
from robust_slam_course.plots.stages import STAGES
from scipy.linalg import solve_continuous_are
from scipy.stats import chi2

from tests.book.prose import Chapter, Numbers, rounds_to

CHAPTER = Chapter("09-frontiers")
C = chi_square_threshold(0.99, 3)
LEFT_BRANCH = ("sensors", "features", "views", "ransac", "odometry", "control")
CELLS = (
    *("imports", "tries", "promise-ransac", "promise-run", "world", "faults", "outcomes"),
    *("outcomes-table", "robots-town", "robots-world"),
    *("break-covariance-run", "break-bus-run"),
)


class Page:
    """The names that the page's own cells define, and its experiments."""

    def __init__(self) -> None:
        names = CHAPTER.run(*CELLS, C=C)
        vars(self).update(names)
        self.outcomes = {stage: self.score(stage) for stage in ("nothing", *STAGES)}
        # For each factor rows of: inliers kept, outliers kept, error in m, bound, chi² ratio.
        self.by_factor = {f: self.with_sigma(f) for f in (0.25, 0.5, 1, 2, 4, 8)}
        self.ratio = {f: float(np.median(rows[:, 4])) for f, rows in self.by_factor.items()}
        # When robot 2 shares nothing but an outlier.
        self.lone = CHAPTER.run("robots-lone", **names)
        self.edges_elsewhere = int(np.sum(~np.any(self.walker[self.met.edges] == 0, axis=1)))

    def of_branch(self, part: int) -> list[Any]:
        """A part of the outcome of each stage of the left branch."""
        return [self.outcomes[stage][part] for stage in LEFT_BRANCH]

    def left_by_gnc(self) -> list[int]:
        """How many closures GNC keeps in each stage of the left branch; all are inliers."""
        left = []
        for stage in LEFT_BRANCH:
            graph, wrong = self.measured(self.FAULTS[stage])
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
            graph, wrong = self.measured(self.FAULTS[stage])
            consistent = pcm(graph, C).kept
            passed.append(inliers_kept(graph, consistent, wrong))
            squares = gnc(PoseGraphProblem(pose_graph.select(graph, consistent), steps=5), C)
            consistent[consistent] = squares.weights > 0.5
            left.append(inliers_kept(graph, consistent, wrong))
        return passed, left

    def rounds_until(self, maps: list[np.ndarray], gap: float) -> int:
        """After how many rounds the maps stay within this share of the least cost."""
        weights = self.last.weights
        least = pose_graph.cost(self.met, self.centre.x, weights)
        high = [pose_graph.cost(self.met, poses, weights) > least * (1 + gap) for poses in maps]
        assert not high[-1]
        return int(np.flatnonzero(high)[-1]) + 1

    def rounds_to_be_near(self) -> list[int]:
        """The rounds to be within 1 % of the least cost, the 1, and the rounds to 1e-6 of it."""
        maps = descended(self.met_fleet())
        return [self.rounds_until(maps, 1e-2), 1, self.rounds_until(maps, 1e-6)]

    def met_fleet(self) -> rounds.Fleet:
        """The robots when they have just met, with the last weights."""
        fleet = rounds.Fleet(self.met, self.walker)
        fleet.meet()
        fleet.record(None)
        for robot in fleet.robots:
            robot.weights = self.last.weights[robot.number].copy()
        return fleet


def descended(fleet: rounds.Fleet) -> list[np.ndarray]:
    """The maps of the fleet's rounds."""
    fleet.descend(None, 1e-6, 100)
    return [seen.poses for seen in fleet.rounds]


def inliers_kept(graph: Any, kept: np.ndarray, wrong: np.ndarray) -> int:
    return int(np.sum(kept & ~graph.is_odometry & ~wrong))


def costs_among_outliers(page: Page) -> list[float]:
    """Of the least-squares map among the outliers, and of the map from the chordal start."""
    graph, _, _ = page.town()
    stuck = certificate(graph, page.outcome("solve")[2])
    _, other = page.certify(graph, page.start.chordal(graph))
    assert other.verdict is Verdict.NOT_CERTIFIED
    return [stuck.cost, other.cost]


def steps_at_one_place(page: Page) -> int:
    """How many Gauss–Newton steps one computer takes for the map of the fleet."""
    problem = PoseGraphProblem(page.met, steps=1)
    steps = [page.met_fleet().rounds[0].poses]
    for _ in range(6):
        steps.append(problem.solve(page.last.weights, steps[-1]))
    return page.rounds_until(steps, 1e-6)


@pytest.fixture(scope="module")
def page() -> Page:
    return Page()


FORMULAS = {
    "16.008": lambda page: math.log(0.01) / math.log(0.75),
    "0.010023": lambda page: 0.75**16,
    "0.03125": lambda page: 0.5**5,
    "0.0576": lambda page: 0.7**8,
    "0.16807 0.83193": lambda page: [0.7**5, 1 - 0.7**5],
    "25.027": lambda page: math.log(0.01) / math.log(1 - 0.7**5),
    "0.992": lambda page: 1 - 0.75**17,
    "0.825": lambda page: page.share_found(17),
    "0.618034": lambda page: (math.sqrt(5) - 1) / 2,
    "3.3682 1.6841": lambda page: [C, C / 2],
    "2.5758": lambda page: chi_square_threshold(0.99, 1),
    "0.2": lambda page: 0.02 * math.sqrt(100),
    "0.09": lambda page: page.outcomes["nothing"][0],
    "0.61 2.97": lambda page: [min(page.of_branch(0)), max(page.of_branch(0))],
    "0.33": lambda page: page.outcomes["plan"][0],
    "0.94 0.23 1.73": lambda page: [page.ratio[f] for f in (1, 2, 0.5)],
    "2.44": lambda page: page.by_factor[8][0, 2],
    "0.60": lambda page: page.by_factor[8][0, 4],
    "0.55": lambda page: page.by_factor[1][:, 4].min(),
    "4.77": lambda page: page.ate(page.lone["end"].poses, page.met_truth),
    "3, 0, 7, 7, 0 and 0 of the 18": lambda page: [*page.of_branch(1), 18],
    "leaves 1, 0, 7, 7, 0 and 0": lambda page: page.left_by_gnc(),
    "passes 4, 2, 8, 7, 3 and 2 honest ones": lambda page: page.before_and_after_gnc()[0],
    "would have left 4, 2, 7, 7, 3 and 0": lambda page: page.before_and_after_gnc()[1],
    "39063": lambda page: costs_among_outliers(page)[0],
    "36350": lambda page: costs_among_outliers(page)[1],
    "24 of 60": lambda page: [60 - page.by_factor[0.5][:, 0].sum(), 60],
    "17, 13 and 12 of their 40 poses": lambda page: [
        *np.bincount(page.walker[page.border]),
        page.met.n / 3,
    ],
    "78 of the 120 poses": lambda page: [page.met.n - page.border.size, page.met.n],
    "27 shared closures": lambda page: page.shared.sum(),
    "lacks 88 of the 153 edges": lambda page: [page.edges_elsewhere, len(page.met.edges)],
    "takes 2 steps": steps_at_one_place,
    "12 rounds to be within 1 %, and 43": lambda page: page.rounds_to_be_near(),
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    # Probabilities, ratios, noise, factors of other programs and data of exercises.
    given = "0.01 0.02 0.04 0.05 0.1 0.25 0.4 0.5 0.7 0.75 0.99 0.999 2.5 99.9"


@pytest.mark.parametrize(
    ("w", "s", "p", "count"),
    [
        (0.5, 8, 0.99, 1177),
        (0.5, 5, 0.99, 146),
        (0.5, 4, 0.99, 72),
        (0.5, 2, 0.99, 17),
        (0.7, 8, 0.99, 78),
        (0.5, 5, 0.999, 218),
        (0.7, 5, 0.99, 26),
        (0.4, 2, 0.99, 27),
    ],
)
def test_ransac_tries_are_the_fewest_that_suffice(page, w, s, p, count) -> None:
    assert page.tries(w, s, p) == count
    assert str(count) in CHAPTER.text
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


def test_the_certificate_refuses_the_two_searches_that_got_stuck(page) -> None:
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
    one, two = (certificates.certify(g, page.start.chordal(g))[0] for g in (inliers, scaled))
    np.testing.assert_allclose(one, two, atol=1e-6)


@pytest.mark.parametrize(("a", "q", "p"), [(0.0, 1.0, 1.0), (1.0, 3.0, 3.0)])
def test_riccati_has_a_zero_on_its_left(a: float, q: float, p: float) -> None:
    one = np.eye(1)
    assert solve_continuous_are(a * one, one, q * one, one)[0, 0] == pytest.approx(p)
    assert 2 * a * p - p**2 + q == 0


@pytest.mark.parametrize(("square", "phi"), [(5.0, 2.0), (0.3, 1.0)])
def test_the_printed_switch_costs_geman_mcclure(square: float, phi: float) -> None:
    s = phi / (phi + square)
    cost = (s**2 * square + phi * (1 - s) ** 2) / 2
    kernel = kernels.geman_mcclure(math.sqrt(phi))
    assert cost == pytest.approx(float(kernel.rho(math.sqrt(square))))


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


def test_the_fleet_keeps_what_the_centre_keeps(page) -> None:
    np.testing.assert_array_equal(page.last.weights, page.centre.weights)
    assert not np.any(page.last.weights[page.met_lies])
    costs = [
        pose_graph.cost(page.met, x, page.last.weights) for x in (page.last.poses, page.centre.x)
    ]
    assert costs[0] == pytest.approx(costs[1], rel=1e-6)


def test_what_crosses_between_the_robots(page) -> None:
    assert (len(page.history) - 1, page.last.numbers) == (92, 14086)
    assert "14 086 have crossed in 92 rounds" in CHAPTER.text
    assert page.edges_elsewhere * 9 == 792
    assert round(page.last.numbers / 792) == 18


def test_to_hold_pose_0_makes_the_fleet_slower(page, monkeypatch: pytest.MonkeyPatch) -> None:
    fleet = page.met_fleet()
    robot = fleet.robots[0]

    def hold(tol: float) -> list[Message]:
        # The edge that holds the first pose counts always, and outweighs all others.
        block, poses = robot.block()
        information = block.information.copy()
        information[-1] *= 1e10
        stiff = dataclasses.replace(block, information=information)
        problem = PoseGraphProblem(stiff, poses, steps=1)
        robot.poses = problem.solve(np.append(robot.weights, 1.0), poses)[1:]
        return robot.tell()

    monkeypatch.setattr(robot, "improve", hold)
    assert page.rounds_until(descended(fleet), 1e-2) == 74
    assert "1 % takes 74 rounds" in CHAPTER.text


def test_no_robot_finds_an_outlier_that_is_alone(page) -> None:
    after = page.lone
    assert after["end"].weights[after["used"][: after["lone"]].sum()] == 1.0
    assert after["verdict"] == "certified"
    assert page.ate(page.last.poses, page.met_truth) < 0.1
