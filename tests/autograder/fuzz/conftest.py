"""Each test's report says how many inputs it tried."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.autograder.fuzz import running


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Count from 0, and hand the number on with the report."""
    running.tried = 0
    yield
    item.user_properties.append(("fuzz inputs", running.tried))
