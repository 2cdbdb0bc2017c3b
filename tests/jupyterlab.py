"""A JupyterLab of a user who has nothing set up, and a page that shows it."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from playwright.sync_api import Browser, Page, Route

SCRIPTS = Path(sys.executable).parent
TOKEN = "none-but-the-test"
_OPTIONS = (
    "--no-browser",
    "--allow-root",
    "--ip=127.0.0.1",
    "--ServerApp.port_retries=0",
    f"--IdentityProvider.token={TOKEN}",
    "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
)
_START_SECONDS = 60.0
_SETTINGS: dict[str, dict[str, object]] = {
    "notebook-extension/tracker": {"windowingMode": "none"},
    "apputils-extension/notification": {"fetchNews": "false"},  # its question covers the cells
}


def environment(home: Path) -> dict[str, str]:
    """Variables for a user who has nothing set up; cells stay on the page when out of sight."""
    own = {f"JUPYTER_{name}_DIR": str(home / name) for name in ("CONFIG", "DATA", "RUNTIME")}
    settings = home / "settings"
    for name, values in _SETTINGS.items():
        file = settings / "@jupyterlab" / f"{name}.jupyterlab-settings"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(values), encoding="utf-8")
    return {
        **os.environ,
        **own,
        "HOME": str(home),
        "IPYTHONDIR": str(home / "ipython"),
        "JUPYTERLAB_SETTINGS_DIR": str(settings),
        "PATH": os.pathsep.join([str(SCRIPTS), os.environ.get("PATH", "")]),
    }


@contextmanager
def running(folder: Path, variables: Mapping[str, str]) -> Iterator[str]:
    """Start JupyterLab in a folder, give its address, and stop it in the end.

    Raises:
        RuntimeError: it does not start; with the end of what it said.
    """
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
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

    context = browser.new_context(viewport={"width": 1400, "height": 1100})
    made = context.new_page()
    made.route("**/*", allow)
    yield made
    context.close()
