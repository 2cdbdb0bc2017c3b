"""Measure every page of a built site: bytes, requests and layout shift.

    python -m benchmarks.site                       # build/html
    python -m benchmarks.site BEFORE AFTER          # two sites, one below the other
    python -m benchmarks.site FOLDER --only 03-     # the pages with this in their names

Each page is opened in Chromium on a desk and on a phone without anything in its cache, and
nothing is clicked. Text counts as hosts of pages give it: gzipped.
"""

from __future__ import annotations

import argparse
import functools
import gzip
import http.server
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from urllib.parse import urlsplit

from playwright.sync_api import Browser, sync_playwright
from tqdm import tqdm

TEXT = {".css", ".html", ".js", ".json", ".mjs", ".svg", ".txt", ".xml"}
SCREENS = ({"width": 1280, "height": 900}, {"width": 390, "height": 844})
SETTLE_MILLISECONDS = 500
"""How long a page is watched after its last request."""
LIMIT_MILLISECONDS = 120_000
_WATCH = """
window.shift = 0;
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) if (!entry.hadRecentInput) window.shift += entry.value;
}).observe({type: "layout-shift", buffered: true});
"""


@dataclass(frozen=True)
class Page:
    """What one page took: bytes, requests, and layout shift on each of the ``SCREENS``."""

    name: str
    size: int
    requests: int
    shifts: tuple[float, ...]


@contextmanager
def serving(folder: Path) -> Iterator[str]:
    """Serve a folder until the end of the block, and give its address."""

    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, format: str, *args: object) -> None:
            """Say nothing."""

    handler = functools.partial(Quiet, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def measure(browser: Browser, folder: Path, address: str, name: str) -> Page:
    """Open a page of the site in ``folder``, which ``address`` serves, on every screen."""
    asked: set[str] = set()
    shifts = []
    for viewport in SCREENS:
        with browser.new_context(viewport=viewport) as context:
            context.set_default_timeout(LIMIT_MILLISECONDS)
            context.add_init_script(_WATCH)
            page = context.new_page()
            page.on("request", lambda request: asked.add(request.url))
            page.goto(f"{address}/chapters/{name}.html", wait_until="networkidle")
            page.wait_for_timeout(SETTLE_MILLISECONDS)
            shifts.append(float(page.evaluate("window.shift")))
    paths = [folder / urlsplit(url).path[1:] for url in asked if url.startswith(address)]
    return Page(name, sum(map(size, paths)), len(paths), tuple(shifts))


def size(path: Path) -> int:
    """Return the bytes of a file as a host gives it, 0 where there is none."""
    if not path.is_file():
        return 0
    content = path.read_bytes()
    return len(gzip.compress(content) if path.suffix in TEXT else content)


def table(pages: list[Page]) -> str:
    """Return a line for each page, and the medians."""
    middle = Page(
        "median",
        int(median(page.size for page in pages)),
        int(median(page.requests for page in pages)),
        tuple(median(page.shifts[k] for page in pages) for k in range(len(SCREENS))),
    )
    lines = [f"{'page':<32}{'KB':>8}{'requests':>10}{'shift, desk':>13}{'phone':>8}"]
    for page in [*pages, middle]:
        shifts = f"{page.shifts[0]:13.3f}{page.shifts[1]:8.3f}"
        lines.append(f"{page.name:<32}{page.size / 1e3:8,.0f}{page.requests:10}{shifts}")
    return "\n".join(lines)


def main() -> None:
    """Measure the folders, and print a table of each."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", nargs="*", type=Path, default=[Path("build/html")])
    parser.add_argument("--only", default="", help="only pages with this in their names")
    options = parser.parse_args()
    program = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if program is None:
        raise SystemExit("chromium is not installed; install it with make system-packages")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=["--no-sandbox"])
        for folder in options.folders:
            names = sorted(path.stem for path in folder.glob(f"chapters/*{options.only}*.html"))
            if not names:
                raise SystemExit(f"{folder} has no page chapters/*{options.only}*.html")
            with serving(folder) as address:
                pages = [
                    measure(browser, folder, address, name)
                    for name in tqdm(names, desc=str(folder), leave=False)
                ]
            print(f"{folder}\n{table(pages)}\n")
        browser.close()


if __name__ == "__main__":
    main()
