"""The back ends that tests of the sandbox run with."""

from __future__ import annotations

import pytest
from robust_slam_autograder.sandbox import Sandbox

from tests.autograder.sandbox.probing import walls
from tests.conftest import working


@pytest.fixture(scope="module", params=walls())
def wall(request: pytest.FixtureRequest) -> Sandbox:
    """Every back end, working."""
    return working(request.param)
