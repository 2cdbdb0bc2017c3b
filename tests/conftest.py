"""What every test may use: the sandbox, which is never silently left out under STRICT.

Properties are tested on the same inputs each time, with ``--quick`` on few of them; ``--soak``
tries new ones, twenty times as many.
"""

from __future__ import annotations

import gc
import os

import pytest
from hypothesis import HealthCheck, settings
from robust_slam_autograder.sandbox import BACK_ENDS, Sandbox

from tests import kernel
from tests.quick import Quick

# What is imported and collected stays: to look through it for garbage again and again would take
# a tenth of each process's time.
gc.disable()

pytest_plugins = ["tests.chromium"]

_SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile("normal", deadline=None, derandomize=True, suppress_health_check=_SLOW)
settings.register_profile("quick", settings.get_profile("normal"), max_examples=10)
settings.register_profile(
    "soak", settings.get_profile("normal"), derandomize=False, max_examples=2000, print_blob=True
)


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
    """``--soak``: every back end in place of one, and many more inputs."""
    parser.addoption(
        "--soak", action="store_true", help="run with every sandbox back end, and fuzz for longer"
    )
    parser.addoption(
        "--quick", action="store_true", help="leave out what starts a process or takes long"
    )


def pytest_configure(config: pytest.Config) -> None:
    """Choose how many inputs properties are tested on."""
    quick = config.getoption("--quick")
    settings.load_profile("soak" if config.getoption("--soak") else "quick" if quick else "normal")
    if quick:
        config.pluginmanager.register(Quick(), "quick")


def pytest_collection_finish() -> None:
    """From here on collect garbage, of what comes to be from here on."""
    gc.freeze()
    gc.enable()


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begin with long files; keep for ``--soak`` what takes minutes and is tested elsewhere."""
    # Long files begin first, so that no process is left alone with one at the end.
    items.sort(key=lambda item: item.get_closest_marker("long") is None)
    if not config.getoption("--soak"):
        long = [item for item in items if item.get_closest_marker("soak")]
        config.hook.pytest_deselected(items=long)
        items[:] = [item for item in items if item not in long]


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """A test that asks for ``wall_name`` runs with the first back end of this machine, or all."""
    if "wall_name" in metafunc.fixturenames:
        usable = kernel.usable()
        names = usable if metafunc.config.getoption("--soak") else usable[:1]
        metafunc.parametrize("wall_name", names or list(BACK_ENDS), scope="session")
