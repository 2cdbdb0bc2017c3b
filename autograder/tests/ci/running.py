"""Workflow files as a runner reads them: their steps, run in a fresh clone, home and venv."""

import os
import re
import subprocess
import sys
import sysconfig
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from .. import as_user

PACKAGES = sysconfig.get_path("purelib")
OFFLINE = {
    "PIP_NO_INDEX": "1",
    "PIP_NO_BUILD_ISOLATION": "0",  # pip's word for: do not isolate
    "PIP_DISABLE_PIP_VERSION_CHECK": "1",
    "PYTHONPATH": PACKAGES,
}
"""What a package needs is found here, so that pip installs our own and nothing else."""
NETWORK = ("http_proxy", "https_proxy", "no_proxy", "PIP_CONFIG_FILE", "PIP_INDEX_URL")
LOOK_UP = re.compile(r"\$\{\{ *([\w.]+) *\}\}")


def load(path: Path) -> dict[str, Any]:
    """A workflow file; YAML reads its key ``on`` as true."""
    value: dict[str, Any] = yaml.safe_load(path.read_text("utf-8"))
    return {("on" if key is True else key): part for key, part in value.items()}


def scripts(path: Path, job: str) -> dict[str, dict[str, Any]]:
    """The steps of a job that are shell, by their names."""
    steps = load(path)["jobs"][job]["steps"]
    return {step["name"]: step for step in steps if "run" in step}


@dataclass
class Runner:
    """A machine that has just been started: a home, a Python of its own, and a clone."""

    folder: Path
    offline: bool = True
    with_python: bool = True
    known: dict[str, str] = field(default_factory=dict)
    """What the step's ``${{ … }}`` stand for."""

    def __post_init__(self) -> None:
        self.home, self.temp = self.folder / "home", self.folder / "temp"
        self.clone, self.python = self.folder / "clone", self.folder / "python"
        self.summary = self.folder / "summary.md"
        for path in (self.home, self.temp):
            path.mkdir(parents=True)
        self.summary.touch()
        if self.with_python:
            # Offline it finds pip, too, where all other packages are.
            bare = ["--without-pip"] if self.offline else []
            subprocess.run([sys.executable, "-m", "venv", *bare, str(self.python)], check=True)

    def check_out(self, repository: Path) -> None:
        command = ["git", "clone", "-q", f"file://{repository}", str(self.clone)]
        subprocess.run(command, check=True, env=self.environment())

    def complete(self) -> None:
        """Give its Python what pip took for installed."""
        (site,) = self.python.glob("lib/python*/site-packages")
        if self.offline:
            here = {path.name for path in site.iterdir()}
            for path in Path(PACKAGES).iterdir():
                if path.name not in here and path.suffix != ".pth":
                    (site / path.name).symlink_to(path)
        self.offline = False

    def environment(self) -> dict[str, str]:
        """What a step finds in its environment, and nothing of this process's."""
        of_network = {key: os.environ[key] for key in NETWORK if key in os.environ}
        return {
            "PATH": f"{self.python / 'bin'}:/usr/local/bin:/usr/bin:/bin",
            "HOME": str(self.home),
            "LANG": "C.UTF-8",
            "RUNNER_TEMP": str(self.temp),
            "GITHUB_STEP_SUMMARY": str(self.summary),
            **(OFFLINE if self.offline else of_network),
        }

    def run(self, step: dict[str, Any]) -> subprocess.CompletedProcess[str]:
        """Run a step's script as GitHub does."""
        given = {name: self._value(str(text)) for name, text in step.get("env", {}).items()}
        # Only a step that asks for bash by name fails where the first of a pipe does.
        flags = ["--noprofile", "--norc", "-eo", "pipefail"] if "shell" in step else ["-e"]
        script, variables = self._value(step["run"]), self.environment() | given
        return as_user.ended(["bash", *flags, "-c", script], cwd=self.clone, env=variables)

    def _value(self, text: str) -> str:
        return LOOK_UP.sub(lambda match: self.known[match.group(1)], text)


def repository(folder: Path) -> Path:
    """Make a folder a repository with all that is in it."""
    who = ["-c", "user.name=A", "-c", "user.email=a@example.edu", "-c", "commit.gpgsign=false"]
    for command in (["init", "-q"], ["add", "-A", "-f"], [*who, "commit", "-q", "-m", "All"]):
        subprocess.run(["git", "-C", str(folder), *command], check=True)
    return folder
