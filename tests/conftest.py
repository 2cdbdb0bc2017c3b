"""What every test may use: the sandbox, which is never silently left out under STRICT."""

from __future__ import annotations

import os

import pytest
from robust_slam_autograder.sandbox import BACK_ENDS, Bubblewrap, bubblewrap_problem


def leave_out(reason: str) -> None:
    """Skip a test for want of something on this machine; under STRICT=1 fail instead."""
    if os.environ.get("ROBUST_SLAM_STRICT"):
        pytest.fail(f"STRICT: {reason}", pytrace=False)
    pytest.skip(reason)


@pytest.fixture(scope="session")
def bubblewrap() -> Bubblewrap:
    """The bubblewrap back end, working."""
    problem = bubblewrap_problem()
    if problem is not None:
        leave_out(f"no sandbox works here: {problem}")
    return Bubblewrap()


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--soak``: every back end in place of one."""
    parser.addoption("--soak", action="store_true", help="run with every sandbox back end")


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test that asks for ``wall_name`` runs with the first back end that works, or with all."""
    if "wall_name" in metafunc.fixturenames:
        working = [name for name, wall in BACK_ENDS.items() if wall.problem() is None]
        names = list(BACK_ENDS) if metafunc.config.getoption("--soak") else working[:1]
        metafunc.parametrize("wall_name", names or list(BACK_ENDS), scope="session")
