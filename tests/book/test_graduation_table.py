"""The table of starts and graduation: as committed, and as computed anew."""

from __future__ import annotations

import csv
from importlib.resources import files

import numpy as np
import pytest

from tools.data import graduation
from tools.data.graduation import CLAIMS, COLUMNS, KINDS, NOISES, PERCENTS, SEEDS, World

pytestmark = pytest.mark.long

TEXT = files("robust_slam_course.pictures").joinpath("graduation.csv").read_text(encoding="utf-8")
ROWS = list(csv.DictReader(line for line in TEXT.splitlines() if not line.startswith("#")))


def test_every_place_of_the_plan_is_in_the_table() -> None:
    assert TEXT.startswith(f"# good maps of {len(SEEDS)}:")
    assert len(ROWS) == len(PERCENTS) * len(KINDS) * len(NOISES) * len(CLAIMS)
    assert tuple(ROWS[0])[4:] == COLUMNS


@pytest.mark.parametrize(("kind", "noise"), [("consistent", 0.05), ("random", 0.1)])
def test_a_row_is_what_is_computed(kind: str, noise: float) -> None:
    counts = np.zeros(len(COLUMNS), dtype=int)
    for seed in SEEDS:
        graph, reference = graduation.make(World(50, kind, noise, seed))
        counts += graduation.good_maps(graph, reference, 1.0)
    (row,) = (
        row
        for row in ROWS
        if (row["percent"], row["kind"], row["noise"], row["claim"])
        == ("50", kind, str(noise), "1.0")
    )
    assert [int(row[column]) for column in COLUMNS] == counts.tolist()


def total(column: str, claim: float, kind: str) -> int:
    """The good maps of a column over all noises and shares of outliers."""
    return sum(
        int(row[column])
        for row in ROWS
        if float(row["claim"]) == claim and row["kind"] in kind.split()
    )


def test_tls_needs_graduation_and_gm_a_start() -> None:
    """What chapter 9 says of the table."""
    of_all = 10 * len(PERCENTS) * len(NOISES)
    odometry = {name: total(f"{name} from odometry", 1.0, "consistent") for name in METHODS}
    squares = {name: total(f"{name} from least squares", 1.0, "consistent") for name in METHODS}
    assert odometry["IRLS-TLS"] + squares["IRLS-TLS"] < 0.02 * of_all
    assert min(odometry["GNC-TLS"], odometry["IRLS-GM"]) > 0.8 * of_all
    assert abs(odometry["GNC-TLS"] - odometry["IRLS-GM"]) < 0.05 * of_all
    assert max(squares.values()) < 0.6 * of_all
    assert abs(odometry["GNC-GM"] - squares["GNC-GM"]) <= 1
    assert odometry["GNC-GM"] < 0.3 * of_all
    assert total("IRLS-TLS from odometry", 8.0, "consistent") > 0.8 * of_all


def test_the_best_method_from_odometry_depends_on_sigma() -> None:
    """What chapter 9 says of all 240 towns at each claimed σ."""
    best = {}
    for claim in CLAIMS:
        good = {name: total(f"{name} from odometry", claim, " ".join(KINDS)) for name in METHODS}
        best[claim] = max(good, key=good.__getitem__)
        if claim == 1.0:
            assert (good["IRLS-TLS"], good["GNC-TLS"], good["IRLS-GM"]) == (0, 222, 200)
        if claim == 2.0:
            assert (good["GNC-TLS"], good["IRLS-GM"]) == (179, 232)
        if claim == 8.0:
            assert (good["IRLS-TLS"], good["GNC-TLS"]) == (208, 24)
    assert [best[claim] for claim in (0.5, 1.0)] == ["GNC-TLS"] * 2
    assert [best[claim] for claim in (2.0, 4.0)] == ["IRLS-GM"] * 2
    assert best[8.0] == "IRLS-TLS"


def test_the_first_question_of_the_picture_is_answered_in_numbers() -> None:
    """What chapter 9 says of half of the closures, noise of 0.05 rad and the true σ."""
    asked = {"kind": "consistent", "percent": "50", "noise": "0.05", "claim": "1.0"}
    (row,) = (row for row in ROWS if asked.items() <= row.items())
    found = {
        name: [int(row[f"{name} from {start}"]) for start in ("odometry", "least squares")]
        for name in METHODS
    }
    assert (found["GNC-TLS"], found["IRLS-GM"]) == ([10, 2], [8, 3])
    assert (found["IRLS-TLS"][0], found["GNC-GM"][0]) == (0, 2)


METHODS = tuple(graduation.METHODS)
