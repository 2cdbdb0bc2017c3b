"""``python -m tools.print`` prints the built book, ``build/robust-slam-a4.pdf``; or ``letter``."""

import logging
import shutil
import sys
import tempfile
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import yaml
from playwright.sync_api import Browser, sync_playwright
from pypdf import PdfReader, PdfWriter

from tools.print.book import Book

ROOT = Path(__file__).resolve().parents[2]
PAPERS = {"a4": "A4", "letter": "Letter"}
COPIES = 5
"""How often a book is printed at most; two or three are usual."""
PATIENCE = 600_000
"""Milliseconds that Chromium may take; it lays out some two hundred pages."""
LIVE = "!document.querySelector('[data-picture]:not([data-live])')"
PARTS = """() => {
  dispatchEvent(new Event("beforeprint"));
  return [...document.querySelectorAll(".rs-paper, .rs-answers")].map((part) => part.outerHTML);
}"""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Start Chromium.

    Raises:
        OSError: there is none.
    """
    path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if path is None:
        raise OSError("Chromium is missing: install chromium-headless-shell")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


def drawn(site: Path, pages: Iterable[str]) -> dict[str, list[str]]:
    """Return what each page draws for its own print, as HTML: pictures' states, then answers."""
    with chromium() as browser:
        page, found = browser.new_page(), {}
        page.set_default_timeout(PATIENCE)
        for name in pages:
            page.goto((site / f"{name}.html").as_uri())
            page.wait_for_function(LIVE)
            found[name] = page.evaluate(PARTS)
    return found


def book(
    site: Path, pages: Iterable[str] = (), own: Mapping[str, Sequence[str]] | None = None
) -> Book:
    """Return the book that ``_toc.yml`` lists, or only some of its pages.

    A page whose ``own`` parts are not ``drawn`` has still pictures, and answers in their places.
    """
    toc = yaml.safe_load((ROOT / "_toc.yml").read_text(encoding="utf-8"))
    parts = [("", [toc["root"]])]
    for part in toc["parts"]:
        files = [[each["file"], *(sub["file"] for sub in each.get("sections", ()))]
                 for each in part["chapters"]]  # fmt: skip
        parts.append((part["caption"], [file for group in files for file in group]))
    if chosen := set(pages):
        parts = [(caption, [f for f in files if f in chosen]) for caption, files in parts]
    config = yaml.safe_load((ROOT / "_config.yml").read_text(encoding="utf-8"))
    lib = tomllib.loads((ROOT / "lib" / "pyproject.toml").read_text(encoding="utf-8"))
    about = {"title": config["title"], "author": config["author"]}
    about |= {"version": lib["project"]["version"]}
    drawing = (site / "_static" / "one-lie.svg").read_text(encoding="utf-8")
    about["lead"] = f'<div role="img" aria-label="One drive, drawn three times.">{drawing}</div>'
    style = (Path(__file__).with_name("print.css")).read_text(encoding="utf-8")
    return Book(site, [part for part in parts if part[1]], about, style, own or {})


def write(book: Book, target: Path, paper: str) -> int:
    """Print a book on one of ``PAPERS``, and return the number of its pages.

    The first copy tells on which pages its parts are. A number may move a line, so it is printed
    anew until each is right.

    Raises:
        OSError: there is no Chromium.
    """
    numbers: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder, chromium() as browser:
        page = browser.new_page(java_script_enabled=False)
        page.set_default_timeout(PATIENCE)
        source = Path(folder, "book.html")
        for copy in range(1, COPIES + 1):
            print(f"  copy {copy}, until each page number is right", flush=True)
            source.write_text(book.html(numbers), encoding="utf-8")
            page.goto(source.as_uri())
            page.pdf(
                path=target, format=PAPERS[paper], tagged=True, outline=True,
                print_background=True, prefer_css_page_size=False,
            )  # fmt: skip
            before, numbers = numbers, places(target)
            if numbers == before:
                break
    writer = PdfWriter(clone_from=target)
    writer.add_metadata({"/Title": book.about["title"], "/Author": book.about["author"]})
    writer.page_mode = "/UseOutlines"
    writer.write(target)
    return len(writer.pages)


def places(pdf: Path) -> dict[str, int]:
    """Return the page, counted from 1, of each place to which a link of a PDF leads."""
    reader = PdfReader(pdf)
    return {
        name.removeprefix("/"): (reader.get_destination_page_number(place) or 0) + 1
        for name, place in reader.named_destinations.items()
    }


def main(paper: str = "a4") -> int:
    """Print the built book; return 0, or 1 after a message that says what to do."""
    if paper not in PAPERS:
        print(f"ERROR: the paper {paper!r} is unknown; give one of {sorted(PAPERS)}")
        return 1
    target = ROOT / "build" / f"robust-slam-{paper}.pdf"
    # Chromium counts its objects short by a few, which pypdf corrects, with a warning.
    logging.getLogger("pypdf").setLevel(logging.ERROR)
    site = ROOT / "build" / "html"
    try:
        pages = write(book(site, own=drawn(site, book(site).pages)), target, paper)
    except OSError as error:
        print(f"ERROR: {error}", file=sys.stderr)
        return 1
    print(f"{target.relative_to(ROOT)}: {pages} pages, {target.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
