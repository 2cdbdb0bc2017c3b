"""The appendix *How large a map can be* says what the measured table says."""

from __future__ import annotations

import math
import os
from types import SimpleNamespace

import matplotlib
import numpy as np
import pytest
from robust_slam_course.plots.growth import fitted_exponent

from tests.book.prose import CHAPTERS, Chapter, Numbers

CHAPTER = Chapter("how-large-a-map")


@pytest.fixture(scope="module")
def page() -> SimpleNamespace:
    """The columns of the table, as the page reads it from its own folder."""
    before = os.getcwd()
    os.chdir(CHAPTERS)
    try:
        with matplotlib.rc_context():
            return SimpleNamespace(**CHAPTER.run("imports", "growth-table"))
    finally:
        os.chdir(before)


FORMULAS = {
    "0.0112 2.82": lambda page: page.step[[0, -1]],
    "by a factor of 252, while $n$ grows by 100": lambda page: [
        page.step[-1] / page.step[0],
        page.poses[-1] / page.poses[0],
    ],
    "1.20": lambda page: math.log(page.step[-1] / page.step[0]) / math.log(100),
    "1.19": lambda page: fitted_exponent(page.poses, page.step),
    "0.97": lambda page: fitted_exponent(page.poses, page.memory - page.base),
    "5.85": lambda page: page.start[-1],
    "1.32": lambda page: fitted_exponent(page.poses, page.start),
    "29.4": lambda page: math.log(2 * 100**2) / math.log(1.4),
    "5.00": lambda page: 1e5 * (1e5 - 1) / 2 / 1e9,
    "1.2": lambda page: fitted_exponent(page.poses, page.step),
}


class TestNumbers(Numbers):
    chapter, formulas = CHAPTER, FORMULAS
    given = "1.4 1.5"


def test_what_is_said_in_words(page) -> None:
    assert "about 10 kB a pose" in CHAPTER.text
    assert np.all(np.abs((page.memory - page.base) / page.poses * 1e3 - 10) < 2)
    assert "two steps' worth" in CHAPTER.text
    assert round(page.start[-1] / page.step[-1]) == 2
    assert "30 steps: a minute and a half" in CHAPTER.text
    assert 80 < 30 * page.step[-1] < 100
    assert "seconds and a gigabyte" in CHAPTER.text
    assert 900 < page.memory[-1] - page.base[-1] < 1100
    assert "a factor of a million" in CHAPTER.text
    assert (page.poses[-1] / page.poses[0]) ** 3 == 1e6
