"""The site as `make book` builds it, a server for it, and a browser without network."""

from __future__ import annotations

import fcntl
import functools
import http.server
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
import yaml
from playwright.sync_api import Browser, BrowserContext, Page, Route, sync_playwright

from tests.conftest import leave_out

ROOT = Path(__file__).parents[2]
TOC = yaml.safe_load((ROOT / "_toc.yml").read_text(encoding="utf-8"))
PAGES = [TOC["root"], *(entry["file"] for entry in TOC["chapters"])]
NOTEBOOKS = [page for page in PAGES if (ROOT / f"{page}.ipynb").exists()]

CHROMIUM = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-first-run",
)


@dataclass(frozen=True)
class Site:
    """The folder of the built pages, and what the build said."""

    folder: Path
    log: str
    status: int


@pytest.fixture(scope="session")
def site() -> Site:
    """The book, built here; pages that are up to date are reused, which Sphinx decides.

    A lock lets one of several test processes build while the others wait.
    """
    book = Path(sys.executable).with_name("jupyter-book")
    command = [book, "build", ".", "--path-output", "build", "-W", "-n", "--keep-going"]
    (ROOT / "build").mkdir(exist_ok=True)
    with (ROOT / "build" / ".book.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return Site(ROOT / "build" / "_build" / "html", done.stdout + done.stderr, done.returncode)


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files and writes no log."""

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@pytest.fixture(scope="session")
def address(site: Site) -> Iterator[str]:
    """The address of a server on this machine that serves the site."""
    handler = functools.partial(QuietHandler, directory=site.folder)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """Chromium, as the system has it."""
    path = shutil.which("chromium")
    if path is None:
        leave_out("chromium is not installed; the pages cannot be looked at")
    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=path, args=list(CHROMIUM))
        yield running
        running.close()


@dataclass
class Visit:
    """A page in the browser, and all that went wrong with it."""

    page: Page
    complaints: list[str] = field(default_factory=list)
    outside: list[str] = field(default_factory=list)


Opener = Callable[..., Visit]


@pytest.fixture(scope="session")
def open_page(browser: Browser) -> Iterator[Opener]:
    """Return a function that opens an address in a context of its own, without network."""
    contexts: list[BrowserContext] = []

    def open_it(url: str, **options: object) -> Visit:
        context = browser.new_context(**options)
        contexts.append(context)
        visit = Visit(context.new_page())
        watch(visit)
        visit.page.goto(url)
        return visit

    yield open_it
    for context in contexts:
        context.close()


def watch(visit: Visit) -> None:
    """Let the visit keep what fails, and what asks for the network; the latter is refused."""
    page, complaints = visit.page, visit.complaints

    def allow(route: Route) -> None:
        url = route.request.url
        if url.startswith(("file:", "data:", "http://127.0.0.1:")):
            route.continue_()
        else:
            visit.outside.append(url)
            route.abort()

    page.route("**/*", allow)
    page.on(
        "console",
        lambda said: complaints.append(said.text) if said.type in ("error", "warning") else None,
    )
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("requestfailed", lambda request: complaints.append(f"failed: {request.url}"))
    page.on(
        "response",
        lambda got: complaints.append(f"{got.status}: {got.url}") if got.status >= 400 else None,
    )
