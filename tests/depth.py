"""``pytest --depth``: how much is asked, from what a change touched to what takes hours.

Each depth answers a question of its own, which ``tests/README.md`` tells. A test needs no entry in
any list: its marks tell how deep it is, and ``quick`` leaves out a test at the moment when that is
about to start a process or a server.
"""

import subprocess
import sys
from collections.abc import Iterator
from itertools import filterfalse
from pathlib import Path

import grimp
import pytest
from hypothesis import HealthCheck, settings

LEFT_OUT = {
    "quick": ("browser", "sandbox", "long", "rest", "soak"),
    "test": ("rest", "soak"),
    "rest": ("soak",),
    "all": ("soak",),
    "soak": (),
}
"""The marks that a depth leaves out; ``rest`` is what ``all`` has beyond ``test``."""
BROWSER = "chromium"
"""The fixture behind every browser."""
STARTS = frozenset({"subprocess.Popen", "os.fork", "os.posix_spawn", "os.system", "socket.bind"})
"""What Python reports to an audit hook before it starts a process or a server."""
REASON = "quick"
ROOT = Path(__file__).resolve().parents[1]
PACKAGES = (
    *("robust_slam", "robust_slam_course", "robust_slam_autograder", "chapters", "tools"),
    *("benchmarks", "tests", "lib.tests", "autograder.tests"),
    *(["solutions"] if (ROOT / "solutions").is_dir() else []),
)

_SLOW = [HealthCheck.too_slow, HealthCheck.data_too_large]
settings.register_profile("all", deadline=None, derandomize=True, suppress_health_check=_SLOW)
settings.register_profile("test", settings.get_profile("all"))
settings.register_profile("rest", settings.get_profile("all"))
settings.register_profile("quick", settings.get_profile("all"), max_examples=10)
settings.register_profile(
    "soak", settings.get_profile("all"), derandomize=False, max_examples=2000, print_blob=True
)


class Depth:
    """Leaves out what is deeper than asked."""

    def __init__(self, name: str) -> None:
        self.name = name

    def pytest_ignore_collect(self, collection_path: Path) -> bool | None:
        """Import no file of which no test is asked: there are more of them than of the others."""
        is_asked = self.name != "rest" or not collection_path.match("test_*.py")
        return None if is_asked or "mark.rest" in collection_path.read_text("utf-8") else True

    def pytest_collection_modifyitems(self, config: pytest.Config, items: list) -> None:
        """Leave out what is marked; begin with long files, or with what a change touched."""
        config.hook.pytest_deselected(items=list(filter(self._is_left_out, items)))
        items[:] = filterfalse(self._is_left_out, items)
        if self.name == "quick":
            first = touched()
            items.sort(key=lambda item: item.path not in first)
        else:
            # So that no process is left alone with a long file at the end.
            items.sort(key=lambda item: item.get_closest_marker("long") is None)

    def _is_left_out(self, item: pytest.Item) -> bool:
        if self.name == "quick" and BROWSER in getattr(item, "fixturenames", ()):
            return True
        if self.name == "rest" and not item.get_closest_marker("rest"):
            return True
        return any(map(item.get_closest_marker, LEFT_OUT[self.name]))


class Watch:
    """Leaves a test out once it starts more than functions."""

    def __init__(self) -> None:
        self.watching = False
        sys.addaudithook(self._look)

    def _look(self, event: str, _: tuple[object, ...]) -> None:
        if self.watching and event in STARTS:
            pytest.skip(REASON)

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


def touched() -> set[Path]:
    """Return the files of what a change touched: the modules in it, and all that import them.

    The change is what is not committed, or else the last commit.
    """
    changed = _git("diff", "--name-only", "HEAD")
    changed += _git("ls-files", "--others", "--exclude-standard")
    changed = changed or _git("diff", "--name-only", "HEAD~1")
    graph = grimp.build_graph(*PACKAGES, cache_dir=None)
    found = {_module(name) for name in changed if name.endswith(".py")} & graph.modules
    found |= {each for name in found for each in graph.find_downstream_modules(name)}
    return {ROOT / name for name in changed} | {
        ROOT / f"{name.replace('.', '/')}.py" for name in found
    }


def _module(name: str) -> str:
    parts = Path(name).with_suffix("").parts
    start = next((k for k, part in enumerate(parts) if part.startswith("robust_slam")), 0)
    return ".".join(parts[start:]).removesuffix(".__init__")


def _git(*words: str) -> list[str]:
    done = subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True, check=False)
    return done.stdout.splitlines()
