"""The cheat sheet has a row for every topic of the lessons, and the library has its kernels.

What it says of graduation and switches, ``lib/tests/estimators`` asks of the library.
"""

import io
import re

import numpy as np
import pytest
from pypdf import PdfReader
from robust_slam.estimators import kernels

from tests.book.prose import CHAPTERS

PAGE = (CHAPTERS / "cheat-sheet.md").read_text(encoding="utf-8")
ROWS = re.findall(r"^\| (L\d+) \| (.+?)<br>(.+) \|$", PAGE, re.M)

TOPICS = {
    "L1": "SO(3) SE(3)",
    "L2": "Exp Log BCH Retraction",
    "L3": "PID LQR Riccati attitude",
    "L4": "snap QP flatness",
    "L5": "Pinhole",
    "L6": "Harris SIFT KLT",
    "L7": "Epipolar Eight-point Triangulation",
    "L8": "RANSAC front-end",
    "L9": "Gauss–Newton LM",
    "L10": "manifolds",
    "L11": "Preintegration fusion",
    "L12": "TF-IDF Vocabulary RANSAC positive",
    "L13": "Factor Cholesky iSAM2 Schur",
}


@pytest.mark.parametrize("lesson", TOPICS)
def test_every_topic_of_the_lessons_stands_in_its_row(lesson):
    said = " ".join(idea for number, idea, _ in ROWS if number == lesson)
    assert not [topic for topic in TOPICS[lesson].split() if topic not in said]


def test_the_topics_of_robust_slam_lead_to_their_chapters():
    rows = PAGE.partition("## Robust SLAM: L14")[2]
    for topic in ("M-estimator", "IRLS", "GNC", "Switchable", "SE-Sync"):
        assert re.search(rf"^\| .*{topic}.*<br>.* \| \[\d\]\(\d\d-", rows, re.M), topic


@pytest.mark.browser
def test_it_is_cards_that_chips_lead_to_and_two_sides_of_paper(site, open_page):
    page = open_page((site.folder / "chapters/cheat-sheet.html").as_uri()).page
    chips = page.locator(".rs-chips a")
    assert chips.all_inner_texts() == [f"L{number}" for number in range(1, 15)]
    for chip in chips.all():  # opens what is folded
        chip.click()
        page.locator(f"li{chip.get_attribute('href')} .rs-formula").wait_for()
    lists = page.locator(".rs-cards-of-ideas")
    lefts = "all => all.map(list => new Set([...list.children].map(li => li.offsetLeft)).size)"
    assert lists.locator("> li").count() == len(ROWS) + len(re.findall(r"<br>.* \| \[", PAGE))
    for width, columns in ((1280, 2), (390, 1)):
        page.set_viewport_size({"width": width, "height": 800})
        assert set(lists.evaluate_all(lefts)) == {columns}
    for paper, wide in (("A4", 595), ("Letter", 612)):
        sides = PdfReader(io.BytesIO(page.pdf(format=paper, prefer_css_page_size=True))).pages
        assert (len(sides), int(sides[0].mediabox.width)) == (2, wide)


def test_l11_noisy_headings_let_odometry_drift_as_printed():
    assert "this is 12 m after 100 steps and 92 m after 400" in PAGE
    rng = np.random.default_rng(11)
    for n, printed in ((100, 12), (400, 92)):
        assert round(0.02 * n**1.5 / 3**0.5) == printed
        headings = np.cumsum(rng.normal(0.0, 0.02, (2000, n)), axis=1)
        assert np.std(np.sin(headings).sum(axis=1)) == pytest.approx(printed, rel=0.08)


def test_l14_the_kernels_as_printed():
    u, k, c = np.linspace(1.1, 9, 80), 1.0, 2.0
    table = [  # beyond Huber's threshold
        (k * u - k**2 / 2, k / u, kernels.huber(k)),
        (c**2 / 2 * np.log(1 + u**2 / c**2), 1 / (1 + u**2 / c**2), kernels.cauchy(c)),
        (c**2 * u**2 / (c**2 + u**2) / 2, c**4 / (c**2 + u**2) ** 2, kernels.geman_mcclure(c)),
        (c**2 / 2 * (1 - np.exp(-(u**2) / c**2)), np.exp(-(u**2) / c**2), kernels.welsch(c)),
        (np.minimum(u**2, c**2) / 2, np.where(u <= c, 1.0, 0.0), kernels.tls(c)),
    ]
    for rho, weight, kernel in table:
        np.testing.assert_allclose(rho, kernel.rho(u))
        np.testing.assert_allclose(weight, kernel.weight(u))
        np.testing.assert_allclose(weight, kernel.psi(u) / u)
    slope = np.gradient(kernels.cauchy(c).psi(u), u)
    np.testing.assert_array_equal((slope < 0)[np.abs(u - c) > 0.2], (u > c)[np.abs(u - c) > 0.2])
