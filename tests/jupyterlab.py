"""A JupyterLab of a user who has nothing set up, and a page that shows it."""

import json
import subprocess
import time
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Locator, Page, Route

from autograder.tests import kernel
from autograder.tests.as_user import SCRIPTS, nothing_set_up
from tests.chromium import page_in

TOKEN = "none-but-the-test"
_OPTIONS = (
    *("--no-browser", "--allow-root", "--ip=127.0.0.1", "--ServerApp.port_retries=0"),
    f"--IdentityProvider.token={TOKEN}",
    "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
)
_START_SECONDS = 300.0
_SETTINGS: dict[str, dict[str, object]] = {
    "notebook-extension/tracker": {"windowingMode": "none"},
    "apputils-extension/notification": {"fetchNews": "false"},  # its question covers the cells
}


def environment(home: Path) -> dict[str, str]:
    """Variables for a user who has nothing set up; cells stay on the page when out of sight."""
    settings = home / "settings"
    for name, values in _SETTINGS.items():
        file = settings / "@jupyterlab" / f"{name}.jupyterlab-settings"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(values), encoding="utf-8")
    return nothing_set_up(home) | {"JUPYTERLAB_SETTINGS_DIR": str(settings)}


@contextmanager
def running(folder: Path, variables: Mapping[str, str]) -> Iterator[str]:
    """Start JupyterLab in a folder, give its address, and stop it in the end.

    Raises:
        RuntimeError: it does not start; with the end of what it said.
    """
    port = kernel.free_port()
    command = [str(SCRIPTS / "jupyter"), "lab", *_OPTIONS, f"--ServerApp.port={port}"]
    log = folder / "lab.log"
    with log.open("w") as said:
        process = subprocess.Popen(command, cwd=folder, env=variables, stdout=said, stderr=said)
    try:
        _wait_for(f"http://127.0.0.1:{port}/api?token={TOKEN}", process, log)
        yield f"http://127.0.0.1:{port}"
    finally:
        process.terminate()
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _wait_for(url: str, process: subprocess.Popen[bytes], log: Path) -> None:
    end = time.monotonic() + _START_SECONDS
    while time.monotonic() < end and process.poll() is None:
        try:
            urllib.request.urlopen(url, timeout=5).close()
        except (urllib.error.URLError, TimeoutError):
            time.sleep(0.2)
        else:
            return
    raise RuntimeError(f"JupyterLab did not start: {log.read_text('utf-8')[-2000:]}")


@contextmanager
def page_of(browser: Browser) -> Iterator[Page]:
    """Give a page in Chromium that reaches this machine alone."""

    def allow(route: Route) -> None:
        own = route.request.url.startswith(("http://127.0.0.1:", "data:", "blob:"))
        route.continue_() if own else route.abort()

    with page_in(browser, viewport={"width": 1400, "height": 1100}) as made:
        made.route("**/*", allow)
        yield made


def write(cell: Locator, text: str) -> None:
    cell.locator(".cm-content").click()
    cell.page.keyboard.press("Control+a")
    cell.page.keyboard.insert_text(text)
    cell.page.keyboard.press("Escape")


def run(cell: Locator, keys: str) -> None:
    """Run the selected code cell with these keys, and wait until it has a new number."""
    prompt = cell.locator(".jp-InputPrompt")
    before = prompt.text_content()
    cell.page.keyboard.press(keys)
    cell.page.wait_for_function(
        "([prompt, before]) => /[0-9]/.test(prompt.textContent) && prompt.textContent !== before",
        arg=[prompt.element_handle(), before],
    )


class Notebook:
    """A notebook that is open in JupyterLab."""

    def __init__(self, page: Page, address: str, path: Path) -> None:
        self.page, self.path = page, path
        page.goto(f"{address}/lab/tree/{path.name}?token={TOKEN}")
        self.cells = page.locator(".jp-Notebook .jp-Cell")
        # Before its kernel is there a notebook looks idle too, and would ask for one.
        page.locator(".jp-Toolbar-kernelName", has_text="Python").wait_for()
        page.locator(".jp-Notebook-ExecutionIndicator[data-status='idle']").wait_for()

    def read(self) -> list[dict[str, Any]]:
        """The cells of the file as it was last saved."""
        return json.loads(self.path.read_text("utf-8"))["cells"]

    def save(self) -> list[dict[str, Any]]:
        with self.page.expect_response(
            lambda answer: answer.request.method == "PUT" and "/api/contents/" in answer.url
        ):
            self.page.keyboard.press("Control+s")
        return self.read()

    def run_all(self) -> list[dict[str, Any]]:
        """Run each cell with Shift and Enter, also past errors; gives the cells.

        One after the other: an error drops the cells that wait behind it.
        """
        self.cells.first.click()
        self.page.keyboard.press("Escape")
        cells = self.read()
        for number, cell in enumerate(cells):
            is_last = number == len(cells) - 1  # it gets no new cell below
            keys = "Control+Enter" if is_last else "Shift+Enter"
            if cell["cell_type"] == "code":
                run(self.cells.nth(number), keys)
            else:
                self.page.keyboard.press(keys)
        return self.save()
