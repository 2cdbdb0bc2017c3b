"""The back ends that tests of the sandbox run with."""

import pytest

from ..kernel import working
from .probing import walls


@pytest.fixture(scope="module", params=walls())
def wall(request):
    return working(request.param)
