"""Chapter 09 prints the numbers that the library computes, and its formulas are right."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import nbformat
import numpy as np
import pytest
from robust_slam import pipeline
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

from tests.book import prose

NOTEBOOK = nbformat.read(prose.CHAPTERS / "09-frontiers.ipynb", as_version=4)
CELLS = {cell["id"]: cell.source for cell in NOTEBOOK.cells}
TEXT = prose.chapter_text("09-frontiers.ipynb")
C = chi_square_threshold(0.99, 3)
LEFT_BRANCH = ("sensors", "features", "views", "ransac", "odometry", "control")

# Probabilities, ratios, noise, factors of other programs and data of exercises: what is given.
GIVEN = {"0.01", "0.02", "0.05", "0.1", "0.25", "0.4", "0.5", "0.7", "0.75", "0.99", "0.999"}
GIVEN |= {"2.5", "99.9"}


@pytest.fixture(scope="module")
def page() -> dict[str, Any]:
    """The names that the page's own cells define: its towns, faults and experiments."""
    names: dict[str, Any] = {"C": C}
    cells = ("imports", "tries", "promise-ransac", "promise-run", "world", "faults", "outcomes")
    for cell in (
        *cells,
        "stage-words",
        "canvas-draw",
        "canvas-words",
        "canvas-ransac",
        "robots-town",
        "robots-world",
        "robots-draw",
        "robots-words",
        "break-covariance-run",
        "break-bus-run",
    ):
        exec(CELLS[cell].replace("use_style()\n", ""), names)
    return names


@pytest.fixture(scope="module")
def outcomes(page: dict[str, Any]) -> dict[str, tuple[float, int, int, int, str]]:
    return {stage: page["score"](stage) for stage in page["CHOICES"]}


@pytest.fixture(scope="module")
def by_factor(page: dict[str, Any]) -> dict[float, np.ndarray]:
    """For each factor rows of: honest kept, lies kept, error in m, bound, chi² ratio."""
    return {f: page["with_sigma"](f) for f in (0.25, 0.5, 1, 2, 4, 8)}


def lone_error(page: dict[str, Any]) -> float:
    """How far the map is off (m) when robot 2 shares nothing but a lie."""
    exec(CELLS["robots-lone"], page)
    return float(page["ate"](page["end"].poses, page["met_truth"]))


@pytest.fixture(scope="module")
def claims(page: dict[str, Any], outcomes: Any, by_factor: Any) -> dict[str, float]:
    ratio = {f: float(np.median(rows[:, 4])) for f, rows in by_factor.items()}
    errors = [outcomes[stage][0] for stage in LEFT_BRANCH]
    return {
        "16.008": math.log(0.01) / math.log(0.75),
        "0.010023": 0.75**16,
        "0.03125": 0.5**5,
        "0.0576": 0.7**8,
        "0.16807": 0.7**5,
        "0.83193": 1 - 0.7**5,
        "25.027": math.log(0.01) / math.log(1 - 0.7**5),
        "0.992": 1 - 0.75**17,
        "0.825": page["share_found"](17),
        "0.618034": (math.sqrt(5) - 1) / 2,
        "3.3682": C,
        "1.6841": C / 2,
        "2.5758": chi_square_threshold(0.99, 1),
        "0.2": 0.02 * math.sqrt(100),
        "0.09": outcomes["nothing"][0],
        "0.66": min(errors),
        "2.97": max(errors),
        "0.33": outcomes["plan"][0],
        "0.94": ratio[1],
        "0.23": ratio[2],
        "1.96": ratio[0.5],
        "2.47": by_factor[8][0, 2],
        "0.59": by_factor[8][0, 4],
        "0.55": by_factor[1][:, 4].min(),
        "4.77": lone_error(page),
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
def test_ransac_tries_are_the_fewest_that_suffice(
    page: dict[str, Any], w: float, s: int, p: float, count: int
) -> None:
    assert page["tries"](w, s, p) == count
    assert str(count) in TEXT
    assert (1 - w**s) ** count <= 1 - p < (1 - w**s) ** (count - 1)


def test_fifty_tries_find_the_motion_every_time(page: dict[str, Any]) -> None:
    assert "With 50 tries it was found every time" in TEXT
    assert page["share_found"](50) == 1.0


def test_faults_of_the_odometry_reject_honest_closures_and_keep_no_lie(outcomes: Any) -> None:
    kept = [outcomes[stage][1] for stage in LEFT_BRANCH]
    assert kept == [1, 0, 7, 7, 0, 0]
    assert "1, 0, 7, 7, 0 and 0 of the 18" in TEXT
    assert all(outcomes[stage][2] == 0 for stage in LEFT_BRANCH)
    assert outcomes["nothing"][1] == 12


def kept_honest(graph: Any, kept: np.ndarray, is_lie: np.ndarray) -> int:
    return int(np.sum(kept & ~graph.is_odometry & ~is_lie))


def test_the_beginning_costs_honest_closures_where_the_odometry_is_wrong(
    page: dict[str, Any],
) -> None:
    passed, left = [], []
    for stage in LEFT_BRANCH:
        graph, is_lie = page["measured"](page["FAULTS"][stage])
        consistent = pcm(graph, C).kept
        passed.append(kept_honest(graph, consistent, is_lie))
        squares = gnc(PoseGraphProblem(pose_graph.select(graph, consistent), steps=5), C)
        consistent[consistent] = squares.weights > 0.5
        left.append(kept_honest(graph, consistent, is_lie))
    assert passed == [4, 2, 8, 7, 3, 2]
    assert "passes 4, 2, 8, 7, 3 and 2 honest ones" in TEXT
    assert left == [4, 2, 7, 7, 3, 0]
    assert "would have left 4, 2, 7, 7, 3 and 0" in TEXT


def test_lies_that_agree_are_kept_from_some_number_on(page: dict[str, Any], outcomes: Any) -> None:
    assert outcomes["places"][1:] == (0, 22, 24, "certified")
    graph, _, _ = page["town"](kind="aliased", count=18)
    answer = pipeline.solve(graph)
    assert np.sum(answer.consistency.kept & ~graph.is_odometry) == 18
    assert np.array_equal(answer.kept, graph.is_odometry)


def test_the_certificate_refuses_the_two_searches_that_got_stuck(outcomes: Any) -> None:
    refused = {stage for stage, score in outcomes.items() if score[4] != "certified"}
    assert refused == {"solve", "certificate"}


def test_least_squares_among_the_lies_is_not_the_best_map(page: dict[str, Any]) -> None:
    graph, _, _ = page["town"]()
    stuck = certificate(graph, page["outcome"]("solve")[2])
    _, other = page["certify"](graph, page["start"].chordal(graph))
    assert (round(stuck.cost), round(other.cost)) == (39063, 36350)
    assert "39063" in TEXT
    assert "36350" in TEXT
    assert other.verdict is Verdict.NOT_CERTIFIED


def test_pcm_can_be_left_out_here(outcomes: Any) -> None:
    assert outcomes["pcm"] == pytest.approx(outcomes["nothing"][:3] + outcomes["pcm"][3:])


def test_every_stage_can_be_lit_and_says_what_it_does(page: dict[str, Any]) -> None:
    assert set(page["WORDS"]) == {"nothing", *STAGES} == set(page["CHOICES"])
    for stage in STAGES:
        said = page["describe"](stage)
        assert said.startswith("In: ")
        assert "; out: " in said


def test_a_sigma_wrong_by_a_factor_does_what_the_text_says(by_factor: Any) -> None:
    honest = {f: int(rows[:, 0].sum()) for f, rows in by_factor.items()}
    lies = {f: int(rows[:, 1].sum()) for f, rows in by_factor.items()}
    assert (60 - honest[0.5], 60 - honest[0.25]) == (29, 60)
    assert "29 of 60" in TEXT
    assert lies == {0.25: 0, 0.5: 0, 1: 0, 2: 0, 4: 0, 8: 5}
    assert by_factor[8][:, 2].argmax() == 0
    assert prose.rounds_to(float(np.median(by_factor[8][:, 4])), "0.02")
    assert np.all(np.isnan(by_factor[0.25][:, 4]))
    assert max(rows[:, 3].max() for rows in by_factor.values()) < 1e-3


@pytest.mark.parametrize(("factor", "honest", "lies"), [(0.5, 36, 0), (4, 57, 3), (8, 55, 21)])
def test_what_pcm_passes_where_sigma_is_wrong(
    page: dict[str, Any], factor: float, honest: int, lies: int
) -> None:
    passed = np.zeros(2, dtype=int)
    for seed in range(5):
        graph, is_lie, _ = page["town"](seed, "random", 12)
        graph = dataclasses.replace(graph, information=graph.information / factor**2)
        kept = pcm(graph, C).kept
        passed += kept_honest(graph, kept, is_lie), int(np.sum(kept & is_lie))
    assert passed.tolist() == [honest, lies]


def test_half_a_sigma_passes_58_percent() -> None:
    assert round(100 * chi2.cdf((C / 2) ** 2, 3)) == 58


def test_a_common_factor_leaves_the_best_map_alone(page: dict[str, Any]) -> None:
    graph, is_lie, _ = page["town"](0, "random", 12)
    honest = pose_graph.select(graph, ~is_lie)
    scaled = dataclasses.replace(honest, information=honest.information / 4)
    one, two = (pipeline.certify(g, page["start"].chordal(g))[0] for g in (honest, scaled))
    np.testing.assert_allclose(one, two, atol=1e-6)


@pytest.mark.parametrize(("a", "q", "p"), [(0.0, 1.0, 1.0), (1.0, 3.0, 3.0)])
def test_riccati_has_a_zero_on_its_left(a: float, q: float, p: float) -> None:
    one = np.eye(1)
    assert solve_continuous_are(a * one, one, q * one, one)[0, 0] == pytest.approx(p)
    assert 2 * a * p - p**2 + q == 0


def test_the_printed_switch_costs_geman_mcclure() -> None:
    for chi2_, phi in ((5.0, 2.0), (0.3, 1.0)):
        s = phi / (phi + chi2_)
        cost = (s**2 * chi2_ + phi * (1 - s) ** 2) / 2
        kernel = kernels.geman_mcclure(math.sqrt(phi))
        assert cost == pytest.approx(float(kernel.rho(math.sqrt(chi2_))))


def test_the_exercise_with_a_modest_sigma() -> None:
    assert 0.25 / 0.1 < chi_square_threshold(0.99, 1) < 0.25 / 0.05


def test_the_ring_of_the_capstone_costs_12_and_is_refused() -> None:
    ends = [[k, (k + 1) % 6] for k in range(6)]
    ring = pose_graph.PoseGraph(6, ends, np.zeros((6, 3)), [np.eye(3)] * 6, np.arange(6) < 5)
    for turn, cost, verdict in (
        (0.0, 0.0, Verdict.CERTIFIED),
        (math.pi / 3, 6 * 4 * (1 - math.cos(math.pi / 3)), Verdict.NOT_CERTIFIED),
        (math.radians(50), None, Verdict.NOT_STATIONARY),
    ):
        poses = np.outer(np.arange(6), [0.0, 0.0, turn])
        proof = certificate(ring, poses)
        assert proof.verdict is verdict
        assert cost is None or proof.cost == pytest.approx(cost, abs=1e-9)


def test_the_bus_wins_when_it_has_more_matches(page: dict[str, Any]) -> None:
    share = {bus: page["street_wins"](bus) for bus in (20, 30, 40, 50, 60)}
    assert [share[bus] for bus in (20, 30, 50, 60)] == [1, 1, 0, 0]
    assert 0.2 < share[40] < 0.8


def test_the_fleet_keeps_what_the_centre_keeps(page: dict[str, Any]) -> None:
    met, last, centre = page["met"], page["last"], page["centre"]
    np.testing.assert_array_equal(last.weights, centre.weights)
    assert not np.any(last.weights[page["met_lies"]])
    costs = [pose_graph.cost(x, met, last.weights) for x in (last.poses, centre.x)]
    assert costs[0] == pytest.approx(costs[1], rel=1e-6)
    assert page["share"](len(page["history"]) - 1) == pytest.approx(1.0, rel=1e-6)


def test_what_crosses_between_the_robots(page: dict[str, Any]) -> None:
    met, walker, shared = page["met"], page["walker"], page["shared"]
    assert np.bincount(walker[page["border"]]).tolist() == [17, 13, 12]
    assert "17, 13 and 12 of their 40 poses" in TEXT
    assert met.n - page["border"].size == 78
    assert "78 of the 120 poses" in TEXT
    assert shared.sum() == 27
    assert "27 shared closures" in TEXT
    assert (len(page["history"]) - 1, page["last"].numbers) == (92, 14086)
    assert "14 086 have crossed in 92 rounds" in TEXT
    lacking = int(np.sum(~np.any(walker[met.edges] == 0, axis=1)))
    assert (lacking, len(met.edges), lacking * 9) == (88, 153, 792)
    assert "lacks 88 of the 153 edges" in TEXT
    assert round(page["last"].numbers / 792) == 18


def rounds_until(page: dict[str, Any], maps: list[np.ndarray], gap: float) -> int:
    """After how many rounds the maps stay within this share of the least cost."""
    met, weights = page["met"], page["last"].weights
    least = pose_graph.cost(page["centre"].x, met, weights)
    high = [pose_graph.cost(poses, met, weights) > least * (1 + gap) for poses in maps]
    assert not high[-1]
    return int(np.flatnonzero(high)[-1]) + 1


def met_fleet(page: dict[str, Any]) -> rounds.Fleet:
    """The robots when they have just met, with the last weights."""
    fleet = rounds.Fleet(page["met"], page["walker"])
    fleet.meet()
    fleet.record(None)
    for robot in fleet.robots:
        robot.weights = page["last"].weights[robot.number].copy()
    return fleet


def test_how_many_rounds_the_fleet_needs(page: dict[str, Any]) -> None:
    fleet = met_fleet(page)
    fleet.descend(None, 1e-6, 100)
    maps = [seen.poses for seen in fleet.rounds]
    assert [rounds_until(page, maps, gap) for gap in (1e-2, 1e-6)] == [12, 43]
    assert "takes 2 steps" in TEXT
    problem = PoseGraphProblem(page["met"], steps=1)
    steps = [fleet.rounds[0].poses]
    for _ in range(6):
        steps.append(problem.solve(page["last"].weights, steps[-1]))
    assert rounds_until(page, steps, 1e-6) == 2
    assert "12 rounds to be within 1 %, and 43" in TEXT


def test_to_hold_pose_0_makes_the_fleet_slower(
    page: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    fleet = met_fleet(page)
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
    fleet.descend(None, 1e-6, 100)
    maps = [seen.poses for seen in fleet.rounds]
    assert rounds_until(page, maps, 1e-2) == 74
    assert "1 % takes 74 rounds" in TEXT


def test_nobody_finds_a_lie_that_is_alone(page: dict[str, Any]) -> None:
    exec(CELLS["robots-lone"], page)
    assert page["end"].weights[page["used"][: page["lone"]].sum()] == 1.0
    assert page["verdict"] == "certified"
    assert page["ate"](page["last"].poses, page["met_truth"]) < 0.1


def test_a_frame_of_the_fleet_says_what_it_costs_and_what_crossed(page: dict[str, Any]) -> None:
    assert page["SHOWN"][-1] == 92
    words = page["say_round"](92)
    assert "1.0000 times" in words
    assert "14 086 numbers" in words
    assert "21 are trusted, 0 in doubt and 6 rejected" in words
    assert dict(page["table_round"](0))["μ"] == "none yet"
