"""Runs a command, keeps all that it prints in a log file, and shows how far it is.

``python tools/quietly.py STEP COMMAND…`` writes ``build/log/STEP.log``. On a terminal one line
follows the command's last one; elsewhere a line appears every half minute. Where the command
fails, its errors and warnings and the end of the log are shown, and the exit status is its own.
"""

import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

LOGS = Path("build/log")
SECONDS_BETWEEN_LINES = 30.0
TAIL_LINES = 20
_COLOUR = re.compile(r"\x1b\[[0-9;]*m")
_PROBLEM = re.compile(r"\b(WARNING|ERROR|error):|Error\b|Traceback")
_NOTE = re.compile("note: ")
"""What a command says to who called it, though all went well."""
_REPORT = re.compile(r"traceback saved in: (\S+)")
"""Where Jupyter Book puts the error of a cell."""


def run(command: list[str], log: Path) -> int:
    """Run a command, follow it, and return its exit status."""
    log.parent.mkdir(parents=True, exist_ok=True)
    pipe = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    last = time.monotonic()
    with (
        log.open("w", encoding="utf-8") as kept,
        subprocess.Popen(command, encoding="utf-8", errors="replace", **pipe) as process,
    ):
        for raw in process.stdout or ():
            line = _COLOUR.sub("", raw)
            kept.write(line)
            kept.flush()
            if "TCP without encryption" in line:  # as each kernel says
                continue
            if sys.stdout.isatty():
                width = shutil.get_terminal_size().columns - 1
                print(f"\r\x1b[K{f'  {line.rstrip()}'[:width]}", end="", flush=True)
            elif time.monotonic() - last >= SECONDS_BETWEEN_LINES:
                last = time.monotonic()
                print(f"  {line.rstrip()}", flush=True)
    if sys.stdout.isatty():
        print("\r\x1b[K", end="")
    return process.returncode


def explanation(log: Path) -> list[str]:
    """Return why a command failed: its problems, the errors of cells, and the log's end."""
    lines = log.read_text(encoding="utf-8").splitlines()
    shown = [line for line in lines[:-TAIL_LINES] if _PROBLEM.search(line)][-TAIL_LINES:]
    for report in filter(Path.is_file, map(Path, _REPORT.findall("\n".join(lines)))):
        text = _COLOUR.sub("", report.read_text(encoding="utf-8", errors="replace"))
        shown += [f"--- {report}:", *text.splitlines()[-TAIL_LINES:]]
    return [*shown, f"--- The end of {log}, which has all that it printed:", *lines[-TAIL_LINES:]]


if __name__ == "__main__":
    step, *command = sys.argv[1:]
    log = LOGS / f"{step}.log"
    began = time.monotonic()
    if status := run(command, log):
        print("\n".join(explanation(log)))
    else:
        notes = filter(_NOTE.match, log.read_text(encoding="utf-8").splitlines())
        print("\n".join([*notes, f"  {step}: done in {time.monotonic() - began:.0f} s ({log})"]))
    sys.exit(status)
