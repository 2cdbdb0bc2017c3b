"""Worlds of tiers G to J: a wrong map is not called unique, and a good one seldom doubted."""

import numpy as np
import pytest
from robust_slam.graphs import ate
from robust_slam.solver import Support, solve

from benchmarks.methods import Made
from benchmarks.sweep.contests import CONTESTS, CONTROLS
from benchmarks.sweep.definition import World, make


def world(tier: str, change: str, seed: int = 0) -> Made:
    return make(World("manhattan", "contest", 0, seed, tier, change))


@pytest.mark.parametrize("tier", ["G", "H", "J"])
def test_contests_are_about_a_part_of_a_graph_that_is_joined(tier):
    for change in CONTESTS[tier]:
        made, again = world(tier, change), world(tier, change)
        np.testing.assert_array_equal(made.graph.measurement, again.graph.measurement)
        slips = np.any(made.graph.information != made.honest.information, axis=(1, 2))
        assert np.any(slips) == (tier == "H" and "none" not in change)
        wrong = change.split()[0] not in ("none", "turn", "shift", "restart", "origin")
        assert np.any(made.is_outlier) == wrong
        assert not np.any(made.is_outlier & made.graph.is_odometry)


@pytest.mark.parametrize(
    ("tier", "change"),
    [
        *(("G", one) for one in ("aisle 6:9", "aisle 6:15", "bridge 6:10", "beside 12")),
        *(("J", "agreeing 2"), ("J", "agreeing 3"), ("H", "origin 2")),
    ],
)
def test_a_map_that_wrong_closures_won_is_not_called_unique(tier, change):
    for seed in (0, 1):
        made = world(tier, change, seed)
        answer = solve(made.graph)
        kept = np.any(answer.kept & made.is_outlier) or tier == "H"
        assert answer.support is not Support.UNIQUE or not kept
        assert answer.support is Support.UNIQUE or answer.notes()


@pytest.mark.parametrize("change", [*CONTROLS, "random 3", "none 1"])
def test_where_nothing_wrong_agrees_the_map_is_unique(change):
    tier = {"random 3": "J", "none 1": "H"}.get(change, "G")
    for seed in (0, 11):
        made = world(tier, change, seed)
        answer = solve(made.graph)
        assert answer.support is Support.UNIQUE
        assert not np.any(answer.kept & made.is_outlier)


@pytest.mark.parametrize("every", [1, 2, 4, 5])
@pytest.mark.parametrize("kind", ["turn", "shift"])
def test_a_slip_is_found_however_many_closures_there_are(kind, every):
    for seed in (0, 1):
        made = world("H", f"{kind} {every}", seed)
        answer = solve(made.graph)
        assert answer.slips.size == 1
        assert ate(answer.poses, made.reference) < 0.3
        assert np.sum(~answer.kept & ~made.graph.is_odometry) <= 2


@pytest.mark.parametrize("kind", ["restart 2", "restart 4"])
def test_a_tracker_that_restarts_slipped_once(kind):
    made = world("H", kind, 1)
    answer = solve(made.graph)
    slip = np.flatnonzero(np.any(made.graph.information != made.honest.information, axis=(1, 2)))
    np.testing.assert_array_equal(answer.slips, slip)
