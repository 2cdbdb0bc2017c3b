"""The directions of imports that pyproject.toml states are kept, and a wrong one is found."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def lint(folder: Path) -> subprocess.CompletedProcess[str]:
    """What import-linter says of the packages in a folder laid out like the project."""
    path = os.pathsep.join(str(folder / name) for name in ("lib", "autograder"))
    command = ["lint-imports", "--config", str(ROOT / "pyproject.toml"), "--no-cache", "--no-logo"]
    environment = {**os.environ, "PYTHONPATH": path}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)


def test_the_directions_are_kept() -> None:
    done = lint(ROOT)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    ("module", "line", "said"),
    [
        ("lib/robust_slam/graphs/se2.py", "from robust_slam import pipeline", "graphs.se2"),
        (
            "lib/robust_slam/drawing.py",
            "from robust_slam_course.style import LOOKS",
            "robust_slam.drawing",
        ),
        ("lib/robust_slam/errors.py", "import robust_slam_autograder", "robust_slam.errors"),
        (
            "autograder/robust_slam_autograder/sandbox/view.py",
            "from robust_slam_autograder.executor import session",
            "sandbox.view",
        ),
        (
            "autograder/robust_slam_autograder/grading/batch.py",
            "import distributed",
            "grading.batch",
        ),
    ],
)
def test_a_wrong_direction_is_found(module: str, line: str, said: str, tmp_path: Path) -> None:
    for name in ("lib", "autograder"):
        shutil.copytree(ROOT / name, tmp_path / name)
    path = tmp_path / module
    path.write_text(f"{path.read_text('utf-8')}\n{line}\n", "utf-8")
    done = lint(tmp_path)
    assert done.returncode == 1
    assert said in done.stdout.partition("Broken contracts")[2]
