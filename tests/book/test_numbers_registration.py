"""The appendix *Two scans and their matches* prints the numbers that its code computes."""

from __future__ import annotations

from math import comb

import numpy as np
import pytest
from robust_slam.consistency import max_clique
from robust_slam.estimators import gnc

from tests.book.prose import Chapter, Numbers

pytestmark = pytest.mark.long

CHAPTER = Chapter("registration")
CHANCE = 1 - 0.99**2
"""That two wrong matches agree, if distances are spread evenly."""


class Page:
    """The names that the page's own cells define, and its experiments."""

    def __init__(self) -> None:
        names = CHAPTER.run(
            *("imports", "scene", "graph", "rotation-run", "twenty", "relaxation"),
            *("certificate-run", "break-run"),
        )
        vars(self).update(names)

    def ten_scenes(self) -> np.ndarray:
        """GNC's cost, that of the relaxation's rotation, and the bound, in ten scenes."""
        rows = []
        for seed in range(10):
            problem = self.ten(*self.scene(seed), *self.half)
            bound, Z = self.relaxation(problem)
            norms = problem.residual_norms(self.rounded(Z))
            rows.append([gnc(problem, 1.0).cost, np.minimum(norms**2, 1).sum() / 2, bound])
        return np.array(rows)


@pytest.fixture(scope="module")
def page() -> Page:
    return Page()


FORMULAS = {
    "0.0199": lambda page: CHANCE,
    "0.00327": lambda page: comb(190, 4) * CHANCE**6,
    "at most 0.1 m": lambda page: 2 * page.BETA,
    "about 357 agree": lambda page: 190 * 189 / 2 * CHANCE,
    "412 pairs of wrong matches": lambda page: np.triu(page.among, 1).sum(),
    "This one is 8 cm off": lambda page: (
        100 * np.linalg.norm(page.b[94] - page.TURN @ page.a[94] - page.SHIFT)
    ),
    "a residual of 8 cm, and the worst of the right ones 6 cm": lambda page: [
        100 * page.residual[94],
        100 * page.residual[:10].max(),
    ],
    "0.226": lambda page: 100 * comb(10, 2) / comb(200, 2),
    "in 2 of 20 scenes; after the clique it does in all 20, to 0.25": lambda page: [
        np.sum(np.array(page.alone) < 1),
        len(page.alone),
        np.sum(np.array(page.after) < 1),
        max(page.after),
    ],
    "156° off": lambda page: page.degrees_off(gnc(page.problem, 1.0).x),
    "1.70": lambda page: gnc(page.problem, 1.0).cost - page.bound,
    "0.19": lambda page: page.degrees_off(page.rounded(page.Z)),
    "2.665 instead of 2.855": lambda page: [
        page.naive,
        page.relaxation(page.ten(*page.scene(0), *page.half))[0],
    ],
    "44 for ten differences, 4004 for 1000": lambda page: [4 * (10 + 1), 4 * (1000 + 1), 1000],
    "2.47": lambda page: comb(990, 4) * 0.0199**6,
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    given = "0.99 6.21 5.26 3.98 7.85 7.64"


def test_powers_of_ten_are_computed_too() -> None:
    for number, value in (
        (r"6.21\cdot10^{-11}", CHANCE**6),
        (r"5.26\cdot10^7", comb(190, 4)),
        (r"3.98\cdot10^{10}", comb(990, 4)),
        (r"7.85\cdot10^{12}", comb(990, 5)),
        (r"7.64\cdot10^{-5}", comb(990, 5) * CHANCE**10),
    ):
        assert number in CHAPTER.text
        digits, power = number.replace("{", "").replace("}", "").split(r"\cdot10^")
        assert value / 10.0 ** int(power) == pytest.approx(float(digits), abs=0.005)


def test_pairs_are_counted() -> None:
    for number, count in (("17\\,955", 190), ("19 900", 200), ("45 are right", 10)):
        assert number in CHAPTER.text
        assert int(number.split(" a")[0].replace("\\,", "").replace(" ", "")) == comb(count, 2)


def test_the_clique_has_all_right_matches_and_one_wrong_one(page) -> None:
    np.testing.assert_array_equal(page.members, [*range(10), 94])
    assert page.clique.proven
    assert max_clique(page.among).members.size == 3
    i, j = page.pairs(page.members)
    touched = (i == 94) | (j == 94)
    assert (i.size, touched.sum()) == (55, 10)
    assert np.sum(~page.found.kept) == np.sum(~page.found.kept & touched) == 3


@pytest.mark.filterwarnings("ignore:Solution may be inaccurate")  # the tolerance is enough
def test_the_relaxation_is_exact_in_ten_scenes_and_gnc_finds_seven(page) -> None:
    cost, least, bound = page.ten_scenes().T
    assert np.sum(cost - bound < 1e-3) == 7
    np.testing.assert_allclose(least, bound, atol=1e-3)
    assert "exact ten times, and GNC reached it seven times" in CHAPTER.text


def test_the_quaternion_form_is_the_residual(page) -> None:
    problem = page.problem
    rotation = page.Rotation.from_euler("zyx", [0.3, -1.0, 2.0])
    q = np.roll(rotation.as_quat(), 1)
    expected = problem.residual_norms(rotation.as_matrix()) ** 2
    np.testing.assert_allclose(q @ page.forms(problem) @ q, expected, rtol=1e-9)


def test_constraints_are_three_million_for_a_thousand() -> None:
    count = 1 + 10 * 1000 + 6 * comb(1001, 2)
    assert round(count / 1e6) == 3


def test_a_house_without_chimney_and_garage_is_the_same_after_half_a_turn(page) -> None:
    """Each face of the body has its twin."""
    corner, along, up = np.array(page.BODY, dtype=float).transpose(1, 0, 2)
    faces = np.stack([corner, corner + along, corner + along + up, corner + up], axis=1)

    def corners(faces):
        return {frozenset(map(tuple, face + 0.0)) for face in faces}

    assert len(corners(faces)) == 6
    assert corners(faces * [-1, -1, 1]) == corners(faces)


def test_the_turned_set_wins_and_its_rotation_is_certified(page) -> None:
    np.testing.assert_array_equal(page.chosen, np.arange(10, 24))
    assert page.degrees_off(page.wrong_way.x) > 179
    problem = page.ten(page.p, page.q, np.arange(5), np.arange(10, 17))
    result, (bound, Z) = gnc(problem, 1.0), page.relaxation(problem)
    assert result.cost == pytest.approx(bound, abs=1e-4)
    values = np.linalg.eigvalsh(Z)
    assert values[-2] < 1e-4 * values[-1]
    np.testing.assert_array_equal(result.kept, np.arange(10) >= 4)
