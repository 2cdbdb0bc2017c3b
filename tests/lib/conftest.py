"""What every test of the library may ask for: both groups, and three seeds."""

from __future__ import annotations

import pytest

from tests.lib.worlds import GROUPS


@pytest.fixture(params=GROUPS.values(), ids=GROUPS)
def group(request: pytest.FixtureRequest):
    """SE(2), then SE(3)."""
    return request.param


@pytest.fixture(params=range(3))
def seed(request: pytest.FixtureRequest) -> int:
    """Another seed each time; a test that needs more of them is parametrised itself."""
    return request.param
