"""The back ends that tests of the sandbox run with."""

import pytest

from tests.autograder.sandbox.probing import walls
from tests.conftest import working


@pytest.fixture(scope="module", params=walls())
def wall(request):
    return working(request.param)
