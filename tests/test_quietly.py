"""`tools/quietly.py` keeps everything, shows little, and hides no failure."""

from __future__ import annotations

import io
import os
import pty
import subprocess
import sys
from pathlib import Path

import pytest

from tools import quietly
from tools.quietly import Screen, Shown

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOK = "/somewhere/chapters/03-irls.ipynb"
BUILD = f"""\
\x1b[01mreading sources... \x1b[39;49;00m[ 25%] \x1b[35mchapters/03-irls\x1b[39;49;00m
{NOTEBOOK}: Executing notebook using local CWD [mystnb]
[IPKernelApp] WARNING | Kernel is running over TCP without encryption.
{NOTEBOOK}: Executed notebook in 10.59 seconds [mystnb]
\x1b[01mwriting output... \x1b[39;49;00m[100%] \x1b[35mchapters/03-irls\x1b[39;49;00m
"""


def run(folder: Path, step: str, script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", script, *arguments]
    return subprocess.run(
        [sys.executable, str(ROOT / "tools" / "quietly.py"), step, *command],
        cwd=folder, capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip


def test_a_chapter_takes_a_line_and_the_rest_is_in_the_log(tmp_path: Path) -> None:
    done = run(tmp_path, "book", "import sys; print(sys.argv[1])", BUILD)
    chapter, end = done.stdout.splitlines()
    assert chapter.split() == ["chapters/03-irls", "10.6", "s"]
    assert end.startswith("  book: done in ") and end.endswith("(build/log/book.log)")
    kept = (tmp_path / "build" / "log" / "book.log").read_text("utf-8")
    assert "IPKernelApp" in kept and "[ 25%] chapters/03-irls" in kept


def test_a_failure_shows_early_warnings_the_cells_error_and_the_end(tmp_path: Path) -> None:
    report = tmp_path / "03-irls.err.log"
    report.write_text("\x1b[31mZeroDivisionError\x1b[0m: division by zero\n")
    text = f"{NOTEBOOK}:7: WARNING: Unknown target [ref.ref]\n"
    text += f"{NOTEBOOK}: WARNING: Notebook exception traceback saved in: {report} [mystnb.exec]\n"
    text += "filler\n" * 100 + "build finished with problems, 2 warnings.\n"
    done = run(tmp_path, "book", "import sys; print(sys.argv[1]); sys.exit(3)", BUILD + text)
    assert done.returncode == 3
    for shown in (
        f"{NOTEBOOK}:7: WARNING: Unknown target [ref.ref]",
        "\nZeroDivisionError: division by zero\n",
        "build finished with problems, 2 warnings.",
        "All that it printed: build/log/book.log",
    ):
        assert shown in done.stdout
    assert "IPKernelApp" not in done.stdout
    assert len(done.stdout.splitlines()) < 60


def test_the_environments_packages_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "some.lock").write_text("a==1 \\\n    --hash=x\nb==2 \\\n    --hash=y\n")
    text = (
        "Collecting a==1\n  Using cached a\nProcessing ./b\nInstalling collected packages: a, b\n"
    )
    monkeypatch.chdir(tmp_path)
    read = quietly.setup("some.lock")
    shown = [read(line) for line in text.splitlines()]
    assert [item.now for item in shown if item.now] == ["1 of 2 packages", "2 of 2 packages"]
    assert "installing" in shown[-1].stays


def test_progress_takes_a_line_now_and_then_where_there_is_no_terminal() -> None:
    now = 0.0
    file = io.StringIO()
    screen = Screen(file, clock=lambda: now)
    for now in range(0, 100, 10):
        screen.show(Shown(now=f"at {now}"))
    assert file.getvalue().split() == ["at", "30", "at", "60", "at", "90"]


def test_progress_stays_on_one_line_of_a_terminal() -> None:
    reader, writer = pty.openpty()
    with os.fdopen(writer, "w") as terminal:
        screen = Screen(terminal)
        screen.show(Shown(now="1 of 2" + " and more" * 100))
        screen.show(Shown(now="2 of 2"))
        screen.line("done")
        text = ""
        while not text.endswith("\n"):
            text += os.read(reader, 100_000).decode()
    os.close(reader)
    assert text.count("\n") == 1 and text.endswith("\r\x1b[Kdone\r\n")
    assert text.count("and more") < 30


@pytest.mark.parametrize("step", [*quietly.READERS, "release"])
def test_a_step_without_output_ends_well(tmp_path: Path, step: str) -> None:
    for lock in ("requirements.lock", "requirements-dev.lock"):
        (tmp_path / lock).touch()
    done = run(tmp_path, step, "pass")
    assert (done.returncode, len(done.stdout.splitlines())) == (0, 1)
