"""Runs a command, keeps all that it prints in a log file, and shows how far it is.

``python tools/quietly.py STEP COMMAND…`` writes ``build/log/STEP.log``. On a terminal one line
follows the progress; elsewhere such a line appears every few seconds. Where the command fails, its
errors and warnings, the failing cell's traceback and the end of the log are shown, and the exit
status is the command's.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import time
from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import TextIO

LOGS = Path("build/log")
SECONDS_BETWEEN_LINES = 30.0
TAIL_LINES = 20
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_PROBLEM = re.compile(r"\b(WARNING|ERROR|error):|Error:|Traceback")
_REPORT = re.compile(r"traceback saved in: (?P<path>\S+)")


@dataclass
class Shown:
    """What a reader makes of a line: text that stays, or how far the command is."""

    stays: str = ""
    now: str = ""


Reader = Callable[[str], Shown]


def book() -> Reader:
    """What Jupyter Book prints: a line for each notebook that was executed."""
    executed = re.compile(r"(?P<page>chapters/\S+)\.ipynb: Executed notebook in (?P<took>\S+) sec")
    phase = re.compile(r"(?P<phase>reading|writing)[^.]*\.\.\. \[ *(?P<part>\d+%)\] (?P<page>\S+)")

    def read(line: str) -> Shown:
        if match := executed.search(line):
            return Shown(stays=f"{match['page']:<44} {float(match['took']):5.1f} s")
        if match := phase.search(line):
            return Shown(now=f"{match['phase']} {match['page']} ({match['part']})")
        return Shown()

    return read


def setup(lock: str) -> Reader:
    """What pip prints: how many of a lock file's packages it has collected."""
    requirements = Path(lock).read_text(encoding="utf-8")
    total = len(re.findall(r"^[\w.-]+==", requirements, re.M))
    count = 0

    def read(line: str) -> Shown:
        nonlocal count
        if line.startswith("Installing collected"):
            return Shown(stays="all packages are here; installing them takes about a minute")
        if not line.startswith(("Collecting", "Processing", "Ignoring")):
            return Shown()
        count += 1
        return Shown(now=f"{count} of {total} packages")

    return read


def lines() -> Reader:
    """Any other command: its last line is its progress."""
    return lambda line: Shown(now=line)


def sample() -> Reader:
    """What the grader prints of the sample class: how many submissions it has graded."""
    return lambda line: Shown(now=line if line.endswith(" graded") else "")


READERS: dict[str, Callable[[], Reader]] = {
    "book": book,
    "sample": sample,
    "shown": sample,
    "setup": partial(setup, "requirements.lock"),
    "setup-dev": partial(setup, "requirements-dev.lock"),
}


@dataclass
class Screen:
    """Shows progress on one line of a terminal, or now and then on a line of its own."""

    file: TextIO
    clock: Callable[[], float] = time.monotonic
    _last: float = field(init=False)

    def __post_init__(self) -> None:
        self._last = self.clock()

    def show(self, shown: Shown) -> None:
        """Show what a line says."""
        if shown.stays:
            self.line(f"  {shown.stays}")
        elif shown.now and self.file.isatty():
            width = shutil.get_terminal_size().columns - 1
            self._write(f"\r\x1b[K{f'  {shown.now}'[:width]}")
        elif shown.now and self.clock() - self._last >= SECONDS_BETWEEN_LINES:
            self.line(f"  {shown.now}")

    def line(self, text: str) -> None:
        """Write a line that stays, in place of the progress."""
        self._last = self.clock()
        self._write(("\r\x1b[K" if self.file.isatty() else "") + text + "\n")

    def _write(self, text: str) -> None:
        self.file.write(text)
        self.file.flush()


def run(step: str, command: list[str], screen: Screen) -> int:
    """Run a command and follow it; gives its exit status."""
    log = LOGS / f"{step}.log"
    log.parent.mkdir(parents=True, exist_ok=True)
    read = READERS.get(step, lines)()
    began = screen.clock()
    with (
        log.open("w", encoding="utf-8") as kept,
        subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            encoding="utf-8",
            errors="replace",
        ) as process,
    ):
        assert process.stdout is not None
        for raw in process.stdout:
            line = _COLOUR.sub("", raw)
            kept.write(line)
            kept.flush()
            screen.show(read(line.rstrip()))
    if process.returncode:
        explain(log, screen)
    else:
        screen.line(f"  {step}: done in {screen.clock() - began:.0f} s ({log})")
    return process.returncode


def explain(log: Path, screen: Screen) -> None:
    """Show why a command failed: its problems, the tracebacks of cells, and the log's end."""
    text = log.read_text(encoding="utf-8").splitlines()
    tail = text[-TAIL_LINES:]
    earlier = [line for line in text[:-TAIL_LINES] if _PROBLEM.search(line)]
    reports = [Path(match["path"]) for line in text for match in _REPORT.finditer(line)]
    _block(screen, "Earlier errors and warnings", earlier[-TAIL_LINES:])
    for path in filter(Path.is_file, reports):
        _block(screen, str(path), _last_lines(path))
    _block(screen, f"The end of {log}", tail)
    screen.line(f"It failed. All that it printed: {log}")


def _last_lines(path: Path) -> Iterable[str]:
    with path.open(encoding="utf-8", errors="replace") as file:
        return deque((_COLOUR.sub("", line).rstrip() for line in file), TAIL_LINES)


def _block(screen: Screen, title: str, lines: Iterable[str]) -> None:
    shown = list(lines)
    if shown:
        screen.line(f"--- {title}:")
        for line in shown:
            screen.line(line)


def main(arguments: list[str]) -> int:
    """Run the command after the step's name."""
    step, *command = arguments
    try:
        return run(step, command, Screen(sys.stdout))
    except KeyboardInterrupt:
        return 130


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
