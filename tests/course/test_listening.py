"""The edges of a map as tones: who hears them, and sees nothing, finds the outlier."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot as plt
from playwright.sync_api import Locator, expect
from robust_slam.graphs.generate import manhattan
from robust_slam_course import pictures
from robust_slam_course.canvas.picture import Picture
from robust_slam_course.pictures.graphs import graph_data
from robust_slam_course.style import figure_style

from tests.book.taking_hold import FRAMES
from tests.book.test_accessible import complaints
from tests.chromium import page_in

pytestmark = [pytest.mark.browser, pytest.mark.rest]

TOWNS = range(10)
RECORDER = """
window.tones = [];
window.AudioContext = class {
  get currentTime() { return performance.now() / 1000; }
  createGain() {
    this.loud = 0;
    const level = (value) => { this.loud = Math.max(this.loud, value); };
    return { gain: { setValueAtTime: level, linearRampToValueAtTime: level }, connect() {} };
  }
  createOscillator() {
    const source = { frequency: {}, connect: (next) => next, stop() {} };
    source.start = (from) => tones.push([source.frequency.value, from, this.loud]);
    return source;
  }
  close() {}
};
const every = window.setInterval;
window.setInterval = (step) => every(step, 0);"""
"""Web Audio that keeps of each tone its frequency (Hz), its time (s) and how loud it gets. What
plays does so without pause."""
LINE = re.compile(r"from pose (\d+) to pose (\d+), residual ([\d.]+)\xa0σ, weight ([\d.]+)$")


class Listener:
    """Who has only the keys of a picture, its tones, and what its slider says."""

    def __init__(self, picture: Locator) -> None:
        self.page, self.picture = picture.page, picture
        self.slider = picture.get_by_role("slider", name="Edge", exact=True)

    def press(self, part: Locator, key: str) -> list[list[float]]:
        """Press a key, and return the tones until the picture is drawn and plays no more."""
        self.page.evaluate("tones.length = 0")
        part.press(key)
        self.page.evaluate(f"{FRAMES}.then(() => 0)")
        expect(self.picture.get_by_text("Pause")).to_have_count(0)
        return self.page.evaluate("tones")

    def edge(self) -> list[float]:
        """Return the poses, the residual and the weight that the slider says."""
        found = LINE.search(self.slider.get_attribute("aria-valuetext") or "")
        assert found
        return [float(number) for number in found.groups()]

    def outlier(self) -> list[float]:
        """Play all edges, walk back to the one with the highest tone, and return its poses."""
        self.slider.press("End")
        self.slider.press("Home")
        tones = [tone for tone, _, _ in self.press(self.slider, "Space")]
        for _ in tones[tones.index(max(tones)) + 1 :]:
            self.page.keyboard.press("ArrowLeft")
        return self.edge()[:2]


def town(opening: Picture, seed: int) -> Picture:
    """Return the picture with another town and a wrong closure of poses 3 m or more apart."""
    rng = np.random.default_rng(seed)
    graph, truth = manhattan(60, rng, side=8, turn=0.4, closures=10)
    i, j = 0, 0
    while j - i < 10 or np.linalg.norm(truth[i, :2] - truth[j, :2]) < 3.0:
        i, j = sorted(rng.choice(60, 2, replace=False).tolist())
    state = {"robust": False, "wrong": [[i, j]], "joined": True}
    data = graph_data(graph, truth)
    return replace(opening, state=state, data=data, still=plt.figure(), answer={})


@pytest.fixture(scope="module")
def towns():
    with figure_style():
        opening = pictures.opening()
    return [town(opening, seed) for seed in TOWNS]


@pytest.fixture(scope="module")
def page(towns, browser, tmp_path_factory):
    path: Path = tmp_path_factory.mktemp("towns") / "page.html"
    shown = "".join(picture.static_html() for picture in towns)
    path.write_text(f'<!doctype html><meta charset="utf-8">{shown}', "utf-8")
    with page_in(browser, reduced_motion="reduce") as page:
        page.add_init_script(RECORDER)
        page.goto(path.as_uri())
        yield page


def test_a_listener_finds_the_outlier_of_a_robust_map(page, towns):
    """Ten towns by keys, each twice: least squares often has its highest tone at another edge."""
    found = np.zeros(2, int)
    for picture, shown in zip(towns, page.locator(".rs-picture").all(), strict=True):
        listener, wrong = Listener(shown), picture.state["wrong"][0]
        listener.press(shown.get_by_role("button", name="Listen to the edges"), "Enter")
        at_once = listener.outlier()
        listener.press(shown.get_by_label("Reject outliers (GNC)"), "Space")
        found += [at_once == wrong, listener.outlier() == wrong]
    assert found[1] >= 9 > found[0], found


def test_a_tone_is_higher_for_a_residual_and_softer_without_weight(page):
    """On the robust map, from the last edge back over all closures, one of them rejected."""
    listener = Listener(page.locator(".rs-picture").first)
    listener.slider.press("Home")
    weights = set()
    for key in ("End", *["ArrowLeft"] * 10):
        [(tone, _, loud)] = listener.press(listener.slider, key)
        *_, residual, weight = listener.edge()
        lowest, highest = (220 * max(residual + slack, 0.25) ** 0.5 for slack in (-0.06, 0.06))
        assert lowest <= tone <= highest
        assert loud == pytest.approx(0.06 + 0.24 * weight)
        weights.add(weight)
    assert weights == {0.0, 1.0}


def test_the_keys_are_open_to_all_and_go_where_nothing_can_sound(towns, open_page, tmp_path):
    path = tmp_path / "page.html"
    head = '<!doctype html><html lang="en"><meta charset="utf-8"><title>Town</title><main>'
    path.write_text(f"{head}<h1>Town</h1>{towns[0].static_html()}</main>", "utf-8")
    page = open_page(path.as_uri(), reduced_motion="reduce").page
    page.locator(".rs-listen").click()
    expect(page.locator(".rs-hearing [aria-live]")).to_have_text(LINE)
    assert complaints(page) == set()
    page.locator(".rs-listen").click()
    expect(page.locator(".rs-hearing")).to_have_count(0)
    page.add_init_script("delete window.AudioContext")
    page.reload()
    expect(page.locator(".rs-folded")).to_have_count(1)
    assert page.locator(".rs-listen").count() == 0
