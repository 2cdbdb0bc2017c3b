"""One page: opened on a desk and on a phone, and judged by axe-core."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from html import unescape
from importlib.resources import files

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
_PARAGRAPH = '(document.querySelector("article p") ?? document.body).textContent'
# This rule is experimental: without being asked for it axe-core leaves it out.
_AXE = """axe.run({
  resultTypes: ["violations"], rules: {"label-content-name-mismatch": {enabled: true}},
}).then((ran) => ran.violations.map(({id, nodes}) => [id, nodes.length]))"""
_DARK = "document.documentElement.dataset.theme = document.documentElement.dataset.mode = 'dark'"
_STILL = "Promise.allSettled(document.getAnimations().map((one) => one.finished)).then(() => 0)"


@dataclass(frozen=True)
class Figures:
    """What was measured at a page; sizes in bytes, times in seconds.

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
    """

    name: str
    given: list[Given]
    tasks: float
    scripts: float
    paint: float
    in_first_response: bool
    shifts: tuple[float, float]
    violations: tuple[Counter[str], Counter[str]]

    @property
    def weight(self) -> int:
        """All bytes that were given."""
        return sum(each.size for each in self.given)


def measure(browser: Browser, served: Served, name: str) -> Figures:
    """Open a page on a desk and on a phone, with nothing in the cache, and measure it."""
    url = f"{served.address}/{name}.html"
    with _opened(browser, url, viewport=DESK) as (page, session):
        given, times = served.take(), _times(session)
        painted, shift = page.evaluate("window.largest"), page.evaluate(_SUM)
        paragraph = page.evaluate(_PARAGRAPH)
        light = violations(page)
        page.evaluate(_DARK)
        dark = violations(page)
        html = page.request.get(url).text()
    with _opened(browser, url, viewport=PHONE, has_touch=True) as (page, _):
        served.take()
        on_phone = page.evaluate(_SUM)
    painted = painted or {"time": 0.0, "tag": "", "text": ""}
    return Figures(
        name=name,
        given=given,
        tasks=times["TaskDuration"],
        scripts=times["ScriptDuration"],
        paint=painted["time"] / 1e3,
        in_first_response=holds(html, painted["text"] or paragraph),
        shifts=(shift, on_phone),
        violations=(light, dark),
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
    """Return how many elements axe-core finds against each of its rules."""
    page.evaluate(_STILL)
    page.evaluate(_axe())
    return Counter(dict(page.evaluate(_AXE)))


@cache
def _axe() -> str:
    return files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")


def holds(html: str, text: str, letters: int = 40) -> bool:
    """Tell whether a page's source has the beginning of a text, whatever the marks between."""
    found = re.sub(r"\s+", "", unescape(re.sub(r"(?s)<[^>]*>", "", html)))
    return re.sub(r"\s+", "", text)[:letters] in found


def asked(browser: Browser, served: Served, word: str) -> Sequence[Given]:
    """Return what a reader who types a word into the search page makes the server give.

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
