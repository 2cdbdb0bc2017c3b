"""Live pictures: CPU milliseconds of a drag, and what they add to a page in bytes.

Run `python -m benchmarks.pictures`. A closure of the opening map is dragged across maps of 20,
60 and 100 poses in Chromium, by least squares and by GNC, and each movement of the pointer is
timed with the processor time of the page's main thread: events, solve, drawing and layout. A
page's bytes are those of its pictures (script, data, still picture) after gzip; the limit is
60 KB a page.
"""

from __future__ import annotations

import gzip
import json
import re
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from playwright.sync_api import CDPSession, Page, sync_playwright
from robust_slam_course import pictures
from robust_slam_course.style import figure_style

ROOT = Path(__file__).parents[1]
POSES = (20, 60, 100)
MOVES = 200
LIMIT_BYTES = 60_000
LIMIT_MILLISECONDS = 16.0
_FRAME = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def main() -> int:
    """Print both tables; 1 if a page or a drag of 60 poses is above its limit."""
    print(f"A drag of {MOVES} movements in Chromium, CPU ms a movement")
    print(f"{'poses':>6}  {'estimator':<14}{'median':>8}{'95th percentile':>17}")
    slow = False
    for poses, robust, times in drags():
        median, most = np.percentile(times, [50, 95])
        slow |= poses == 60 and most > LIMIT_MILLISECONDS
        print(f"{poses:>6}  {'GNC' if robust else 'least squares':<14}{median:>8.1f}{most:>17.1f}")
    print(f"\n{'page':<38}{'pictures':<28}{'bytes, gzipped':>14}")
    large = False
    for page, names in used():
        size = len(gzip.compress("".join(map(html, names)).encode()))
        large |= size > LIMIT_BYTES
        print(f"{page:<38}{', '.join(names):<28}{size:>14,}")
    return int(slow or large)


def drags() -> Iterator[tuple[int, bool, list[float]]]:
    """Yield the number of poses, whether GNC solves, and CPU milliseconds of each movement."""
    path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if path is None:
        raise SystemExit("chromium is not installed; install it with make system-packages")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        for poses in POSES:
            for robust in (False, True):
                page = browser.new_page(reduced_motion="reduce")
                page.set_content(f"<!doctype html><body>{html('opening', poses)}")
                if robust:
                    page.locator("[data-control=robust]").click()
                yield poses, robust, _timed(page)
                page.close()
        browser.close()


def _timed(page: Page) -> list[float]:
    """Return CPU milliseconds of each movement of a circular drag."""
    session = page.context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    handle = page.locator("[data-handle]").first
    handle.scroll_into_view_if_needed()
    box = handle.bounding_box()
    stage = page.locator(".rs-stage").bounding_box()
    assert box is not None and stage is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    times = []
    for angle in np.linspace(0.0, 4 * np.pi, MOVES):
        before = _spent(session)
        x = stage["x"] + stage["width"] * (0.5 + 0.35 * np.cos(angle))
        y = stage["y"] + stage["height"] * (0.5 + 0.35 * np.sin(angle))
        page.mouse.move(float(x), float(y))
        page.evaluate(_FRAME)
        times.append(1e3 * (_spent(session) - before))
    page.mouse.up()
    return times


def _spent(session: CDPSession) -> float:
    metrics = session.send("Performance.getMetrics")["metrics"]
    return float(next(m["value"] for m in metrics if m["name"] == "TaskDuration"))


def used() -> Iterator[tuple[str, list[str]]]:
    """Yield each page that has pictures, and their names."""
    yield (
        "index",
        re.findall(r"\{picture\} (\w+)", (ROOT / "chapters/index.md").read_text("utf-8")),
    )
    for path in sorted((ROOT / "chapters").glob("*.ipynb")):
        cells = json.loads(path.read_text("utf-8"))["cells"]
        source = "".join(line for cell in cells for line in cell["source"])
        names = re.findall(r"\bpictures\.(\w+)\(", source)
        if names:
            yield path.stem, names


def html(name: str, *arguments: int) -> str:
    """Return a picture as a page has it."""
    with figure_style():
        return str(getattr(pictures, name)(*arguments).static_html())


if __name__ == "__main__":
    sys.exit(main())
