"""What `make runtime` made, and what tests of it need."""

from __future__ import annotations

from pathlib import Path

import pytest

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
