"""`tools/quietly.py` keeps everything, shows little, and hides no failure."""

import os
import pty
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
QUIETLY = [sys.executable, str(ROOT / "tools" / "quietly.py"), "book"]
PRINT = [sys.executable, "-c", "import sys; print(sys.argv[1]); sys.exit(int(sys.argv[2]))"]


def test_what_is_printed_is_in_the_log_and_one_line_says_so(tmp_path):
    command = [*QUIETLY, *PRINT, "\x1b[01mone\x1b[39;49;00m\ntwo\nnote: an old Python", "0"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    note, line = done.stdout.splitlines()
    assert note == "note: an old Python"
    assert line.startswith("  book: done in ") and line.endswith("(build/log/book.log)")
    assert (tmp_path / "build" / "log" / "book.log").read_text("utf-8").startswith("one\ntwo\n")


def test_a_failure_shows_early_warnings_the_cells_error_and_the_end(tmp_path):
    report = tmp_path / "03-irls.err.log"
    report.write_text("\x1b[31mZeroDivisionError\x1b[0m: division by zero\n")
    warning = "chapters/03-irls.ipynb:7: WARNING: Unknown target [ref.ref]"
    text = f"{warning}\nWARNING: Notebook exception traceback saved in: {report} [mystnb.exec]\n"
    text += "filler\n" * 100 + "build finished with problems, 2 warnings."
    command = [*QUIETLY, *PRINT, text, "3"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 3
    lines = done.stdout.splitlines()
    assert lines[0] == warning and lines[-1] == "build finished with problems, 2 warnings."
    assert "ZeroDivisionError: division by zero" in lines
    assert any("build/log/book.log" in line for line in lines) and len(lines) < 60


def test_progress_stays_on_one_line_of_a_terminal(tmp_path):
    reader, writer = pty.openpty()
    command = [*QUIETLY, *PRINT, f"1 of 2{' and more' * 100}\n2 of 2\nTCP without encryption", "0"]
    with os.fdopen(writer, "w") as terminal:
        subprocess.run(command, cwd=tmp_path, stdout=terminal, check=True)
        text = os.read(reader, 100_000).decode()
    os.close(reader)
    assert text.count("\n") == 1 and text.count("and more") < 30
    assert "\x1b[K  2 of 2\r\x1b[K  book: done in " in text
