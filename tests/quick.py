"""``pytest --quick``: the tests that start no process and no server, found out by watching them.

Nothing lists them. A test that is about to start one is left out at that moment; those marked as
``browser``, ``sandbox`` or ``long`` are left out before they begin.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator

import pytest

MARKED = ("browser", "sandbox", "long")
BROWSER = "chromium"
"""The fixture behind every browser."""
STARTS = frozenset({"subprocess.Popen", "os.fork", "os.posix_spawn", "os.system", "socket.bind"})
"""What Python reports to an audit hook before it starts a process or a server."""
REASON = "quick"


class Quick:
    """Leaves a test out once it starts more than functions."""

    def __init__(self) -> None:
        self.watching = False
        sys.addaudithook(self._look)

    def _look(self, event: str, _: tuple[object, ...]) -> None:
        if self.watching and event in STARTS:
            pytest.skip(REASON)

    def pytest_collection_modifyitems(
        self, config: pytest.Config, items: list[pytest.Item]
    ) -> None:
        """Leave out what is marked."""
        left = [item for item in items if _is_left_out(item)]
        config.hook.pytest_deselected(items=left)
        items[:] = [item for item in items if item not in left]

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self) -> Iterator[None]:
        """Watch a test with its fixtures."""
        self.watching = True
        try:
            return (yield)
        finally:
            self.watching = False

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Count what was left out, and do not name each."""
        skipped = terminalreporter.stats.get("skipped", [])
        kept = [report for report in skipped if REASON not in str(report.longrepr)]
        terminalreporter.stats["skipped"] = kept


def _is_left_out(item: pytest.Item) -> bool:
    fixtures = getattr(item, "fixturenames", ())
    return BROWSER in fixtures or any(map(item.get_closest_marker, MARKED))
