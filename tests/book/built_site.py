"""The site as `make book` builds it."""

import fcntl
import functools
import json
import os
import re
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

from bs4 import BeautifulSoup

from tools import fonts

ROOT = Path(__file__).parents[2]
DRAWN = re.compile(r"(<(svg|math)\b[^>]*>).*?(?=</\2>)", re.DOTALL)
"""What is drawn is most of a page."""
COLOURED = re.compile(r'<span class="\w{1,3}">([^<]*)</span>')
"""A sign of code in its colour, of which there are thousands."""


@dataclass(frozen=True)
class Site:
    """The built pages: what the build said, its exit status, and their folder."""

    log: str
    status: int
    folder = ROOT / "build" / "_build" / "html"

    def parsed(self, page: str) -> BeautifulSoup:
        """A page without what is in its drawings and formulas and the colours of its code."""
        return _parsed(self.folder / f"{page}.html")


@functools.lru_cache(12)  # the chapters and what leads to them
def _parsed(path: Path) -> BeautifulSoup:
    text = COLOURED.sub(r"\1", DRAWN.sub(r"\1", path.read_text("utf-8")))
    return BeautifulSoup(text, "html.parser")


def built(run: str | None = os.environ.get("PYTEST_XDIST_TESTRUNUID")) -> Site:
    """Build the book in this folder, unless `make book` has, and nothing has changed since.

    Pages that are up to date are reused, which Sphinx decides.

    Args:
        run: names all processes of one run of the tests. The first of them builds, the others
            wait and read what it kept; without a name each builds.
    """
    (ROOT / "build").mkdir(exist_ok=True)
    kept = ROOT / "build" / ".book.tested"
    with (ROOT / "build" / ".book.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        site = _read(kept, run) or _made() or _build()
        kept.write_text(json.dumps({"run": run, **asdict(site)}), encoding="utf-8")
    return site


def _read(kept: Path, run: str | None) -> Site | None:
    if run is None or not kept.exists():
        return None
    found = json.loads(kept.read_text(encoding="utf-8"))
    return Site(found["log"], found["status"]) if found["run"] == run else None


def _made() -> Site | None:
    log = ROOT / "build" / "log" / "book.log"
    # Apart from the make that runs these tests.
    environment = {name: value for name, value in os.environ.items() if "MAKE" not in name}
    asked = ["make", "--question", "build/.book"]
    done = subprocess.run(asked, cwd=ROOT, env=environment, capture_output=True, check=False)
    return Site(log.read_text("utf-8"), 0) if done.returncode == 0 and log.is_file() else None


def _build() -> Site:
    if not (fonts.MADE / fonts.STYLE).is_file():  # `make book` has made them
        fonts.main()
    book = Path(sys.executable).with_name("jupyter-book")
    command = [book, "build", ".", "--path-output", "build", "-W", "-n", "--keep-going"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    return Site(done.stdout + done.stderr, done.returncode)
