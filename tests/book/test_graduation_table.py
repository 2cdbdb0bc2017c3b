"""The table of starts and graduation: as committed, and as computed anew.

What chapter 9 says of it has its rows in ``tests/book/numbers/09-frontiers.toml``.
"""

import csv
from importlib.resources import files

import numpy as np
import pytest
from robust_slam_course.pictures.graphs import stored

from tools.data import graduation
from tools.data.graduation import CLAIMS, COLUMNS, KINDS, NOISES, PERCENTS, SEEDS, World

pytestmark = [pytest.mark.long, pytest.mark.rest]

TEXT = files("robust_slam_course.pictures").joinpath("graduation.csv").read_text(encoding="utf-8")
ROWS = list(csv.DictReader(line for line in TEXT.splitlines() if not line.startswith("#")))


def test_every_place_of_the_plan_is_in_the_table():
    assert TEXT.startswith(f"# good maps of {len(SEEDS)}:")
    assert len(ROWS) == len(PERCENTS) * len(KINDS) * len(NOISES) * len(CLAIMS)
    assert tuple(ROWS[0])[4:] == COLUMNS


def test_the_lost_maps_of_the_picture_are_those_of_the_table():
    shown = stored("graduation.json")["lost"]
    for n, noise in enumerate(NOISES):
        place = {"percent": "50", "kind": "consistent", "noise": str(noise), "claim": "1.0"}
        (row,) = (row for row in ROWS if place.items() <= row.items())
        counts = {(c, str(each[n].count(""))) for c, each in zip(COLUMNS, shown, strict=True)}
        assert counts <= set(row.items())
    graph, reference = graduation.make(World(50, "consistent", 0.1, 3))
    for found, each in zip(graduation.solved(graph), shown, strict=True):
        letters = zip(graduation.lost_letters(found, reference), each[-1][3], strict=True)
        assert all(abs(ord(now) - ord(then)) <= 2 for now, then in letters)


@pytest.mark.parametrize(("kind", "noise"), [("consistent", 0.05), ("random", 0.1)])
def test_a_row_is_what_is_computed(kind, noise):
    """A row is ten spoiled graphs, of which each is solved in the eight ways of the columns."""
    counts = np.zeros(len(COLUMNS), dtype=int)
    for seed in SEEDS:
        graph, reference = graduation.make(World(50, kind, noise, seed))
        counts += graduation.good_maps(graph, reference, 1.0)
    place = {"percent": "50", "kind": kind, "noise": str(noise), "claim": "1.0"}
    (row,) = (row for row in ROWS if place.items() <= row.items())
    assert [int(row[column]) for column in COLUMNS] == counts.tolist()
