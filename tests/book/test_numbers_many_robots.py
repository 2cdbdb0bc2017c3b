"""The appendix *Many robots* prints the numbers that the library computes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from robust_slam.certificates.optimality import Verdict
from robust_slam.fleet import rounds
from robust_slam.fleet.robot import Message
from robust_slam.graphs import pose_graph
from robust_slam.problems import PoseGraphProblem

from tests.book.prose import Chapter, Numbers

pytestmark = pytest.mark.long

CHAPTER = Chapter("many-robots")


class Page:
    """The names that the page's own cells define, and its experiments."""

    def __init__(self) -> None:
        names = CHAPTER.run("imports", "robots-town", "robots-world")
        vars(self).update(names)
        # When robot 2 shares nothing but an outlier.
        self.lone = CHAPTER.run("robots-lone", **names)
        self.edges_elsewhere = int(np.sum(~np.any(self.walker[self.met.edges] == 0, axis=1)))

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

    def steps_at_one_place(self) -> int:
        """How many Gauss–Newton steps one computer takes for the map of the robots."""
        problem = PoseGraphProblem(self.met, steps=1)
        steps = [self.met_fleet().rounds[0].poses]
        for _ in range(6):
            steps.append(problem.solve(self.last.weights, steps[-1]))
        return self.rounds_until(steps, 1e-6)

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


@pytest.fixture(scope="module")
def page() -> Page:
    return Page()


FORMULAS = {
    "4.77": lambda page: page.ate(page.lone["end"].poses, page.met_truth),
    "17, 13 and 12 of their 40 poses": lambda page: [
        *np.bincount(page.walker[page.border]),
        page.met.n / 3,
    ],
    "78 of the 120 poses": lambda page: [page.met.n - page.border.size, page.met.n],
    "share 27 closures": lambda page: page.shared.sum(),
    "27 shared closures": lambda page: page.shared.sum(),
    "lacks 88 of the 153 edges": lambda page: [page.edges_elsewhere, len(page.met.edges)],
    "takes 2 steps": lambda page: page.steps_at_one_place(),
    "12 rounds to be within 1 %, and 43": lambda page: page.rounds_to_be_near(),
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    given = ""


def test_six_of_the_shared_closures_are_wrong(page) -> None:
    assert "of which six are wrong" in CHAPTER.text
    assert np.sum(page.shared & page.met_outliers) == 6


def test_the_robots_keep_what_one_computer_keeps(page) -> None:
    np.testing.assert_array_equal(page.last.weights, page.centre.weights)
    assert not np.any(page.last.weights[page.met_outliers])
    costs = [
        pose_graph.cost(page.met, x, page.last.weights) for x in (page.last.poses, page.centre.x)
    ]
    assert costs[0] == pytest.approx(costs[1], rel=1e-6)


def test_what_is_sent_between_the_robots(page) -> None:
    assert (len(page.history) - 1, page.last.numbers) == (92, 14086)
    assert "14 086 numbers are sent in 92 rounds" in CHAPTER.text
    assert page.edges_elsewhere * 9 == 792
    assert round(page.last.numbers / 792) == 18


def test_to_hold_pose_0_makes_the_robots_slower(page, monkeypatch: pytest.MonkeyPatch) -> None:
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
    assert after["proof"].verdict is Verdict.CERTIFIED
    assert page.ate(page.last.poses, page.met_truth) < 0.1
