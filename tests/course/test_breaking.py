"""Break the map: attacks, their scores and ranks, and the table of the best."""

import json
from importlib.resources import files
from itertools import islice

import numpy as np
import pytest
from robust_slam import breaking, cli
from robust_slam.graphs import pose_graph

from lib.tests.worlds import refused
from tools.data.breaking import best

TABLE = json.loads(files("robust_slam_course.pictures").joinpath("breaking.json").read_text())


def test_all_closures_of_an_attack_fit_a_town_whose_part_has_moved():
    what = breaking.attack("C:gnc:2-10:-1,2:3")
    graph, truth, _ = breaking.town("C")
    moved = truth.copy()
    moved[10:13, :2] += [-1, 2]
    norms = pose_graph.residual_norms(breaking.attacked(what), moved)
    np.testing.assert_allclose(norms[len(graph.edges) :], 0, atol=1e-9)


def test_attacks_come_in_the_order_of_their_ranks_and_none_twice():
    found = [str(each) for each in islice(breaking.attacks("A", "gm"), 5000)]
    ranks = [breaking.attack(score).rank for score in found]
    assert ranks == sorted(ranks) and len(set(found)) == len(found) == 4440


@pytest.mark.parametrize("name", TABLE)
def test_the_best_score_fools_its_solver(name, capsys):
    score = TABLE[name]["score"]
    if score is None:
        assert TABLE[name]["tried"] == len(list(breaking.attacks(*name.split(":"))))
        return
    assert cli.main(["replay", score]) == 0
    head, told = capsys.readouterr().out.splitlines()
    assert head.startswith("town,solver,result,outliers,offset")
    assert told.startswith(f"{name.replace(':', ',')},fooled,")


@pytest.mark.parametrize("solver", ["squares", pytest.param("gnc", marks=pytest.mark.soak)])
def test_no_attack_in_town_a_has_a_better_score(solver):
    assert best("A", solver) == TABLE[f"A:{solver}"]


@refused(
    ("A:gnc", "is no score; copy it again"),
    ("D:gnc:0-9:0,1:2", "town D: there is none; give A or B or C"),
    ("A:huber:0-9:0,1:2", "solver huber: there is none"),
    ("A:gnc:0-9:0,1:6", "6 closures: give 1 to 5"),
    ("A:gnc:9-0:0,1:2", "the earlier first, the later at most 10"),
    ("A:gnc:0-11:0,1:2", "the earlier first, the later at most 10"),
    ("A:gnc:0-9:0,0:2", "not both 0"),
    ("A:gnc:0-9:0,3:2", "from -2 to 2"),
)
def test_what_is_no_attack_is_refused_with_what_to_give(wrong, message, capsys):
    assert cli.main(["replay", wrong]) == 2
    assert message in capsys.readouterr().err
