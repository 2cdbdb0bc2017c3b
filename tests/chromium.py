"""One browser for all tests of a process, and visits of pages that note what goes wrong.

It is Chromium's headless shell, which draws the same pages with half of the CPU time. What a test
that fails has before it, and what its pages complained of, is kept in ``build/failed``.
"""

import functools
import http.server
import os
import re
import shutil
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from weakref import WeakKeyDictionary

import pytest
from playwright import sync_api
from playwright.sync_api import Browser, BrowserContext, Page, expect

from autograder.tests.kernel import leave_out

CHROMIUM = (
    *("--no-sandbox", "--disable-gpu", "--disable-software-rasterizer", "--disable-sync"),
    *("--disable-background-networking", "--disable-component-update", "--no-first-run"),
)


@dataclass
class Patience:
    """How long tests of this process wait for a page."""

    milliseconds: float = 300_000
    """Much longer than a busy machine takes."""
    when_lost: float = 20_000
    """Once a test has waited in vain: what broke one page may have broken all."""
    contexts: list[BrowserContext] = field(default_factory=list)
    """In which pages are open."""

    @contextmanager
    def applied(self, context: BrowserContext) -> Iterator[None]:
        """Let pages in this context be waited for so long."""
        context.set_default_timeout(self.milliseconds)
        self.contexts.append(context)
        yield
        self.contexts.remove(context)

    def lose(self) -> None:
        """From here on wait little."""
        self.milliseconds = min(self.milliseconds, self.when_lost)
        expect.set_options(timeout=self.milliseconds)
        for context in self.contexts:
            context.set_default_timeout(self.milliseconds)


FAILED = Path(__file__).resolve().parents[1] / "build" / "failed"
COMPLAINTS: WeakKeyDictionary[Page, list[str]] = WeakKeyDictionary()
"""What the open pages complained of."""
PATIENCE = Patience()
expect.set_options(timeout=PATIENCE.milliseconds)


def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[object]) -> None:
    """Keep what a test that failed saw; lose patience where it took as long as it may wait."""
    if call.excinfo is None or call.excinfo.errisinstance(pytest.skip.Exception):
        return
    for context in PATIENCE.contexts:
        for number, page in enumerate(context.pages):
            keep(page, item.nodeid, number)
    if call.duration * 1000 >= PATIENCE.milliseconds:
        PATIENCE.lose()


def keep(page: Page, test: str, number: int = 0) -> None:
    """Keep a picture of a page, its address and what its console said, under the test's name."""
    name = re.sub(r"\W+", "-", test).strip("-")[-150:]
    path = FAILED / f"{name}-{number}"
    FAILED.mkdir(parents=True, exist_ok=True)
    said = [page.url, *COMPLAINTS.get(page, [])]
    path.with_suffix(".txt").write_text("\n".join(said) + "\n", encoding="utf-8")
    # A page that hangs has no picture, and its console is what counts.
    with suppress(sync_api.Error):
        page.screenshot(path=path.with_suffix(".png"), timeout=5_000)


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves files and writes no log."""

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@contextmanager
def served(
    folder: Path, handler: type[http.server.SimpleHTTPRequestHandler] = QuietHandler
) -> Iterator[str]:
    """Serve a folder on this machine; gives its address."""
    of_folder = functools.partial(handler, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), of_folder) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


@pytest.fixture(scope="session")
def chromium():
    """Playwright's Chromium, of which there is one in a process, and the system's program."""
    path = shutil.which("chromium-headless-shell") or shutil.which("chromium")
    if path is None:
        leave_out("chromium-headless-shell is not installed; the pages cannot be looked at")
    with sync_api.sync_playwright() as playwright:
        yield playwright.chromium, path


@pytest.fixture(scope="session")
def browser(chromium):
    kind, path = chromium
    running = kind.launch(executable_path=path, args=list(CHROMIUM))
    yield running
    running.close()


@dataclass
class Visit:
    """A page in the browser, and all that went wrong with it."""

    page: Page
    complaints: list[str] = field(default_factory=list)
    outside: list[str] = field(default_factory=list)


Opener = Callable[..., Visit]


@contextmanager
def page_in(browser: Browser, **options: object) -> Iterator[Page]:
    """Give a page in a context of its own, and close it in the end."""
    with browser.new_context(**options) as context, PATIENCE.applied(context):
        page = context.new_page()
        try:
            yield page
        except Exception:
            keep(page, os.environ.get("PYTEST_CURRENT_TEST", "page"))
            raise


@contextmanager
def visiting(browser: Browser, url: str, **options: object) -> Iterator[Visit]:
    """Open an address in a context of its own, without network, and close it in the end."""
    with page_in(browser, **options) as page:
        visit = Visit(page)
        watch(visit)
        visit.page.goto(url)
        yield visit


@pytest.fixture
def open_page(browser):
    """Return a function that visits an address; all visits end with the test."""
    with ExitStack() as visits:
        yield lambda url, **options: visits.enter_context(visiting(browser, url, **options))


def watch(visit: Visit) -> None:
    """Let the visit keep what fails, and what asks for the network; the latter is refused."""
    page, complaints = visit.page, visit.complaints
    COMPLAINTS[page] = complaints

    def allow(route: sync_api.Route) -> None:
        url = route.request.url
        if url.startswith(("file:", "data:", "http://127.0.0.1:")):
            route.continue_()
        else:
            visit.outside.append(url)
            route.abort()

    page.route("**/*", allow)
    wrong = ("error", "warning")
    page.on("console", lambda said: complaints.extend([said.text] * (said.type in wrong)))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("requestfailed", lambda request: complaints.extend(_failed(request)))
    page.on("response", lambda got: complaints.extend([got.url] * (got.status >= 400)))


def _failed(request: sync_api.Request) -> list[str]:
    """Return the complaint about a request that failed; one that a page leaves behind did not."""
    if request.failure in ("net::ERR_ABORTED", "NS_BINDING_ABORTED"):
        return []
    return [f"failed: {request.url}"]
