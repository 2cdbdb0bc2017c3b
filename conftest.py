"""How much is asked of every test, the products' own too: ``--depth``.

Properties are tested on the same inputs each time, with ``--depth quick`` on few of them;
``--depth soak`` tries new ones, twenty times as many.
"""

import gc

import pytest
from hypothesis import settings

from tests import depth

# What is imported and collected stays: to look through it for garbage again and again would take
# a tenth of each process's time.
gc.disable()

pytest_plugins = ["tests.chromium", "tests.page_reads"]


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
