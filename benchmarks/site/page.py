"""One page: opened on a desk and on a phone, printed, and judged by axe-core."""

from __future__ import annotations

import re
import statistics
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from html import unescape
from importlib.resources import files
from typing import Any

from playwright.sync_api import Browser, CDPSession, Page

from benchmarks.site.server import Given, Served

DESK = {"width": 1280, "height": 900}
PHONE = {"width": 390, "height": 844}
SETTLE_MILLISECONDS = 500
"""How long a page is watched after its last request."""
LIMIT_MILLISECONDS = 120_000

_WATCH = """
window.shifts = [];
window.largest = null;
new PerformanceObserver((list) => {
  const shifts = list.getEntries().filter((entry) => !entry.hadRecentInput);
  window.shifts.push(...shifts.map((entry) => entry.value));
}).observe({type: "layout-shift", buffered: true});
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) window.largest = {
    time: entry.startTime, tag: entry.element?.tagName ?? "",
    text: entry.element?.textContent ?? "",
  };
}).observe({type: "largest-contentful-paint", buffered: true});
"""
_DRAWN = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
_SHOWN = """() => {
  const article = document.querySelector("article") ?? document.body;
  const bare = article.cloneNode(true);
  const without = "script, style, svg, math, mjx-container, .math";
  for (const each of bare.querySelectorAll(without)) each.remove();
  for (const each of bare.querySelectorAll("div, h1, h2, h3, li, p, td, th")) each.append(" ");
  const pictures = [...document.querySelectorAll(".rs-picture")];
  const scripts = (picture) => {
    const next = picture.nextElementSibling;
    return picture.outerHTML + (next?.tagName === "SCRIPT" ? next.outerHTML : "");
  };
  return {
    height: document.documentElement.scrollHeight,
    words: bare.textContent.split(/\\s+/).filter(Boolean).length,
    first: pictures.length ? pictures[0].getBoundingClientRect().top + scrollY : null,
    pictures: pictures.map((picture) => new Blob([scripts(picture)]).size),
    paragraph: article.querySelector("p")?.textContent ?? "",
    image: Boolean(document.querySelector('meta[property="og:image"]')),
    logo: Boolean(document.querySelector(".logo img, .logo__image, .navbar-brand svg")),
  };
}"""
# An image is put in line for a moment, so that its letters can be asked for their size.
_LABELS = """async () => {
  const article = document.querySelector("article") ?? document.body;
  const sizes = (within) => [...within.querySelectorAll("text")].filter((text) => {
    const box = text.getBoundingClientRect();
    return box.width && box.height && text.textContent.trim();
  }).map((text) => {
    const {a, b, c, d} = text.getScreenCTM();
    return parseFloat(getComputedStyle(text).fontSize) * Math.sqrt(Math.abs(a * d - b * c));
  });
  const found = sizes(article);
  for (const image of article.querySelectorAll("img")) {
    const {width} = image.getBoundingClientRect();
    if (!width || !/\\.svg|image\\/svg/.test(image.src)) continue;
    const source = await (await fetch(image.src)).text();
    const svg = new DOMParser().parseFromString(source, "image/svg+xml").documentElement;
    const place = document.createElement("div");
    const [, , wide, high] = (svg.getAttribute("viewBox") ?? "0 0 1 1").split(/[ ,]+/);
    svg.setAttribute("width", width);
    svg.setAttribute("height", width * high / wide);
    place.attachShadow({mode: "open"}).append(document.importNode(svg, true));
    image.after(place);
    found.push(...sizes(place.shadowRoot));
    place.remove();
  }
  return found;
}"""
_WIDE = """() => [...document.querySelectorAll("article pre")].filter(
  (code) => code.clientWidth && code.scrollWidth > code.clientWidth + 1).length"""
# This rule is experimental: without being asked for it axe-core leaves it out.
_AXE = """axe.run({
  resultTypes: ["violations"], rules: {"label-content-name-mismatch": {enabled: true}},
}).then((ran) => ran.violations.map(({id, nodes}) => [id, nodes.length]))"""
_DARK = "document.documentElement.dataset.theme = document.documentElement.dataset.mode = 'dark'"
_STILL = "Promise.allSettled(document.getAnimations().map((one) => one.finished)).then(() => 0)"


@dataclass(frozen=True)
class Figures:
    """What was measured at a page; sizes in bytes and pixels, times in seconds.

    Attributes:
        name: the page's path in the site, without its ending.
        given: what the server gave until the page was quiet.
        tasks: CPU time of the main thread until then.
        scripts: of it, in scripts.
        paint: until the largest contentful paint, on this machine and without a network.
        in_first_response: whether the HTML holds the words of that paint, or, where it is a
            picture, those of the first paragraph.
        shifts: layout shift on a desk and on a phone.
        violations: elements by axe-core's rule, in the light and in the dark.
        shown: height on a desk, words, pixels above the first live picture (None where there
            is none), bytes of each live picture, and what the page's head has.
        labels: the size of every letter in figures and live pictures on a phone.
        wide: code boxes on a phone that are narrower than their code.
        printed: pages on paper.
    """

    name: str
    given: list[Given]
    tasks: float
    scripts: float
    paint: float
    in_first_response: bool
    shifts: tuple[float, float]
    violations: tuple[Counter[str], Counter[str]]
    shown: dict[str, Any]
    labels: list[float]
    wide: int
    printed: int

    @property
    def weight(self) -> int:
        """All bytes that were given."""
        return sum(each.size for each in self.given)

    @property
    def smallest_label(self) -> float | None:
        """The smallest letter in its figures, None where they have no letters."""
        return min(self.labels, default=None)

    @property
    def median_label(self) -> float | None:
        """The median of the letters in its figures."""
        return statistics.median(self.labels) if self.labels else None


def measure(browser: Browser, served: Served, name: str) -> Figures:
    """Open a page on a desk and on a phone, with nothing in the cache, and measure it."""
    url = f"{served.address}/{name}.html"
    with _opened(browser, url, viewport=DESK) as (page, session):
        given, times = served.take(), _times(session)
        painted, shift = page.evaluate("window.largest"), page.evaluate(_SUM)
        shown = page.evaluate(_SHOWN)
        printed = pages_of(page.pdf())
        light = violations(page)
        page.evaluate(_DARK)
        dark = violations(page)
        html = page.request.get(url).text()
    with _opened(browser, url, viewport=PHONE, has_touch=True) as (page, _):
        served.take()
        on_phone = page.evaluate(_SUM)
        labels, wide = page.evaluate(_LABELS), page.evaluate(_WIDE)
    painted = painted or {"time": 0.0, "tag": "", "text": ""}
    return Figures(
        name=name,
        given=given,
        tasks=times["TaskDuration"],
        scripts=times["ScriptDuration"],
        paint=painted["time"] / 1e3,
        in_first_response=holds(html, painted["text"] or shown["paragraph"]),
        shifts=(shift, on_phone),
        violations=(light, dark),
        shown=shown,
        labels=labels,
        wide=wide,
        printed=printed,
    )


_SUM = "window.shifts.reduce((sum, value) => sum + value, 0)"


@contextmanager
def _opened(browser: Browser, url: str, **options: object) -> Iterator[tuple[Page, CDPSession]]:
    with browser.new_context(color_scheme="light", **options) as context:
        context.set_default_timeout(LIMIT_MILLISECONDS)
        context.add_init_script(_WATCH)
        page = context.new_page()
        session = context.new_cdp_session(page)
        session.send("Performance.enable", {"timeDomain": "threadTicks"})
        page.goto(url)
        quiet(page)
        yield page, session


def quiet(page: Page) -> None:
    """Wait until the page asks for nothing more, and a moment longer."""
    page.wait_for_load_state("networkidle")
    page.wait_for_timeout(SETTLE_MILLISECONDS)
    page.evaluate(_DRAWN)


def _times(session: CDPSession) -> dict[str, float]:
    metrics = session.send("Performance.getMetrics")["metrics"]
    return {metric["name"]: metric["value"] for metric in metrics}


def violations(page: Page) -> Counter[str]:
    """How many elements axe-core finds against each of its rules."""
    page.evaluate(_STILL)
    page.evaluate(_axe())
    return Counter(dict(page.evaluate(_AXE)))


@cache
def _axe() -> str:
    return files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")


def pages_of(document: bytes) -> int:
    """How many pages Chromium's PDF has."""
    return len(re.findall(rb"/Type\s*/Page\b", document))


def holds(html: str, text: str, letters: int = 40) -> bool:
    """Whether a page's source has the beginning of a text, whatever the marks between."""
    found = re.sub(r"\s+", "", unescape(re.sub(r"(?s)<[^>]*>", "", html)))
    return re.sub(r"\s+", "", text)[:letters] in found


def asked(browser: Browser, served: Served, word: str) -> Sequence[Given]:
    """What a reader who types a word into the search page makes the server give.

    The page itself is not counted; what its scripts fetch for the query is.
    """
    with _opened(browser, f"{served.address}/search.html", viewport=DESK) as (page, _):
        served.take()
        fields = page.locator("input[type=search], input[name=q], input[type=text]")
        field = fields.locator("visible=true").first
        if not field.count():
            page.keyboard.press("Control+k")
        field.click()
        field.press_sequentially(word)
        field.press("Enter")
        page.wait_for_timeout(SETTLE_MILLISECONDS)
        quiet(page)
    return served.take()
