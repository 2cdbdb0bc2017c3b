"""Tries mutants: small changes of the product, each with the test that must then fail.

A list of them is a command: ``python -m tests.grader.mutants [WORD…]``, and likewise
``tests.course.mutants``. It says first which mutants no longer fit what is there. Then it
changes a copy of the project, one mutant at a time, and runs its test, which must fail or take
longer than ``SECONDS``. Before, every test must pass on the project as it is. With words, only
mutants whose file or test contains one of them are tried.
"""

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SECONDS = 240
"""For one test. A mutant may hang: that counts as caught."""
PYTEST = (sys.executable, "-Bm", "pytest", "-qc", "pyproject.toml", "-p", "no:cacheprovider")


@dataclass(frozen=True)
class Mutant:
    """A text that occurs once in a file, its replacement, and the test that then fails."""

    file: str
    old: str
    new: str
    caught_by: str


def stale(mutants: Sequence[Mutant]) -> list[str]:
    """Say which mutants do not change one place of their file, or name a test that is gone."""
    problems = []
    for one in mutants:
        path = ROOT / one.file
        times = path.read_text("utf-8").count(one.old) if path.is_file() else 0
        if times != 1:
            told = f"{one.file} has {one.old.strip()!r} {times} times"
            problems.append(f"{told}: repair its mutant.")
    tests = sorted({mutant.caught_by for mutant in mutants})
    listing = subprocess.run(
        [*PYTEST, "--collect-only", *tests], cwd=ROOT, capture_output=True, text=True
    )
    lines = (listing.stdout + listing.stderr).splitlines() if listing.returncode else []
    return problems + [line for line in lines if line.startswith("ERROR")]


def fails(tests: Sequence[str], folder: Path, seconds: float) -> bool:
    """Whether a test fails in a copy of the project, or takes too long.

    Raises:
        RuntimeError: no test was run.
    """
    places = os.pathsep.join(str(folder / name) for name in ("autograder", "lib", "lib/course"))
    pytest = subprocess.Popen(
        [*PYTEST, "-x", *tests], cwd=folder, env={**os.environ, "PYTHONPATH": places}, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True,
    )  # fmt: skip
    try:
        said, _ = pytest.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        return True
    finally:
        with contextlib.suppress(ProcessLookupError):  # what the mutant let live on
            os.killpg(pytest.pid, signal.SIGKILL)
        pytest.wait()
    if pytest.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(tests)}: {said[-2000:]}")
    return pytest.returncode == 1


def copy(folder: Path) -> Path:
    """Copy what git tracks of the project."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(ROOT / name, folder / name)
    return folder


def main(mutants: Iterable[Mutant], words: Sequence[str]) -> int:
    """Try mutants; exit status 1 where one is not caught, 2 where one is stale or none named."""
    chosen = [
        mutant
        for mutant in mutants
        if not words or any(word in f"{mutant.file} {mutant.caught_by}" for word in words)
    ]
    problems = stale(chosen) if chosen else [f"No mutant has {' or '.join(words)} in its names."]
    if problems:
        print("\n".join(problems), file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as name:
        Path(name).chmod(0o755)  # student code is another user
        folder = copy(Path(name))
        tests = list(dict.fromkeys(mutant.caught_by for mutant in chosen))
        if fails(tests, folder, SECONDS * len(tests)):
            print("A test fails on the project as it is.")
            return 1
        left = 0
        for mutant in chosen:
            path = folder / mutant.file
            before = path.read_text("utf-8")
            path.write_text(before.replace(mutant.old, mutant.new), "utf-8")
            caught = fails([mutant.caught_by], folder, SECONDS)
            path.write_text(before, "utf-8")
            left += not caught
            sign = "✓ caught" if caught else "✗ NOT caught"
            print(f"{sign}  {mutant.file}: {mutant.old.strip()}", flush=True)
    print(f"{len(chosen) - left} of {len(chosen)} mutants are caught.")
    return 1 if left else 0
