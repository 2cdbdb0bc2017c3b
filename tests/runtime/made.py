"""What `make runtime` made, and a site of it."""

from __future__ import annotations

import functools
import http.server
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.chromium import QuietHandler
from tests.conftest import leave_out

ROOT = Path(__file__).resolve().parents[2]
RUNTIME = ROOT / "build" / "runtime"


def look_for_the_runtime() -> None:
    """Leave a test out where there is no runtime."""
    if not (RUNTIME / ".ready").is_file():
        leave_out("there is no Python for the pages: make runtime")


@pytest.fixture(scope="session")
def made_runtime() -> None:
    """The runtime is there."""
    look_for_the_runtime()


needs_runtime = pytest.mark.usefixtures("made_runtime")


@contextmanager
def served(folder: Path) -> Iterator[str]:
    """Serve a folder on this machine; gives its address."""
    handler = functools.partial(QuietHandler, directory=str(folder))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
