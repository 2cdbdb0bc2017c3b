"""What every test may use: the sandbox, which is never silently left out under STRICT.

Properties are tested on the same inputs each time, with ``--depth quick`` on few of them;
``--depth soak`` tries new ones, twenty times as many.
"""

import gc
import os

import pytest
from hypothesis import settings
from robust_slam_autograder.sandbox import BACK_ENDS, Sandbox

from tests import depth, kernel

# What is imported and collected stays: to look through it for garbage again and again would take
# a tenth of each process's time.
gc.disable()

pytest_plugins = ["tests.chromium"]


def leave_out(reason: str) -> None:
    """Skip a test for want of something on this machine; under STRICT=1 fail instead."""
    if os.environ.get("ROBUST_SLAM_STRICT"):
        pytest.fail(f"STRICT: {reason}", pytrace=False)
    pytest.skip(reason)


def working(back_end: str) -> Sandbox:
    """A back end that works; where the kernel supports it and it does not, the test fails."""
    wall = BACK_ENDS[back_end]
    problem = wall.problem()
    if problem is not None and kernel.supports(back_end):
        pytest.fail(f"The kernel supports {back_end}, but it does not work: {problem}", False)
    if problem is not None:
        leave_out(f"{back_end} does not work here: {problem}")
    return wall


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--depth``, which is everything but what takes hours unless it is given."""
    parser.addoption(
        "--depth", choices=list(depth.LEFT_OUT), default="all", help="how much is asked"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Choose the tests, and on how many inputs properties are tested."""
    name = config.getoption("depth")
    settings.load_profile(name)
    config.pluginmanager.register(depth.Depth(name))
    if name == "quick":
        config.pluginmanager.register(depth.Watch())


def pytest_collection_finish() -> None:
    """From here on collect garbage, of what comes to be from here on."""
    gc.freeze()
    gc.enable()


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test that asks for ``wall_name`` runs with the first back end of this machine, or all."""
    if "wall_name" in metafunc.fixturenames:
        usable = kernel.usable()
        names = usable if depth.is_soak(metafunc.config) else usable[:1]
        metafunc.parametrize("wall_name", names or list(BACK_ENDS), scope="session")
