"""Measure every page of a built site: weight, requests, time, layout shift, what axe-core finds.

    python -m benchmarks.site                       # build/html
    python -m benchmarks.site BEFORE AFTER          # two sites, side by side
    python -m benchmarks.site FOLDER --only 03-     # the pages with this in their names

A server on this machine gives the files, text gzipped; each page is opened in Chromium without
anything in its cache, and nothing is clicked. Times are CPU seconds of the main thread, so they
are those of this machine.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright
from tqdm import tqdm

from benchmarks.site import page, tables
from benchmarks.site.server import LEVEL, serving

WORD = "huber"
"""What is searched for."""
HEAD = (
    f"Chromium {{version}}, headless; gzip level {LEVEL}; {page.DESK['width']} × "
    f"{page.DESK['height']} and {page.PHONE['width']} × {page.PHONE['height']} px; watched for "
    f"{page.SETTLE_MILLISECONDS} ms after the last request; the search is for “{WORD}”."
)


def names(folder: Path, only: str) -> list[str]:
    """Return the pages of the contents, the front page first, whose name has these letters."""
    found = [path.relative_to(folder).with_suffix("") for path in folder.glob("chapters/*.html")]
    return sorted(
        (str(name) for name in found if only in name.name),
        key=lambda name: (not name.endswith("/index"), name),
    )


def measured(browser: Browser, folder: Path, only: str) -> tables.Site:
    """Measure a site.

    Raises:
        FileNotFoundError: the folder has no such page.
    """
    chosen = names(folder, only)
    if not chosen:
        raise FileNotFoundError(f"{folder} has no page chapters/*{only}*.html")
    with serving(folder) as served:
        figures = [
            page.measure(browser, served, name)
            for name in tqdm(chosen, desc=str(folder), leave=False)
        ]
        return tables.Site(
            folder=str(folder),
            pages=figures,
            query=page.asked(browser, served, WORD),
        )


def main() -> None:
    """Measure the folders, and print a table of each one's pages and one that sums them up."""
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
        print(HEAD.format(version=browser.version))
        sites = [measured(browser, folder, options.only) for folder in options.folders]
        browser.close()
    for site in sites:
        print(f"\n{site.folder}\n\n{tables.of_pages(site)}")
    print(f"\n{tables.summary(sites)}")


if __name__ == "__main__":
    main()
