"""What `make runtime` made, and what tests of it need."""

import re
from pathlib import Path

import pytest
from robust_slam_autograder import self_check

from autograder.tests.kernel import leave_out

ROOT = Path(__file__).resolve().parents[2]
RUNTIME = ROOT / "build" / "runtime"


def look_for_the_runtime() -> None:
    """Leave a test out where there is no runtime."""
    if not (RUNTIME / ".ready").is_file():
        leave_out("there is no Python for the pages: make runtime")


@pytest.fixture(scope="session")
def made_runtime():
    look_for_the_runtime()


def without_hints(said: str) -> str:
    """What the command prints without the way to hints, which in the page are behind a click."""
    return re.sub(re.escape(self_check.HINTS).replace(r"\{\}", r"\d+") + r"\n", "", said)


needs_runtime = pytest.mark.usefixtures("made_runtime")
