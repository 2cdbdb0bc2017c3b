"""No wall at all."""

from __future__ import annotations

import tempfile

from robust_slam_autograder.sandbox import terms
from robust_slam_autograder.sandbox.process import Process, popen
from robust_slam_autograder.sandbox.terms import ENVIRONMENT, Launch


class Unsandboxed:
    """No wall: the process has the user's own rights. For one's own code only."""

    name = "none"

    def problem(self) -> str | None:
        """Return None: it works everywhere, and guards nothing."""
        return None

    def start(self, launch: Launch) -> Process:
        """Start it in an empty folder of its own, with a clean environment."""
        scratch = tempfile.TemporaryDirectory(prefix="autograder-", ignore_cleanup_errors=True)
        environment = ENVIRONMENT | {"HOME": scratch.name, "MPLCONFIGDIR": scratch.name}
        process = popen(
            terms.python_command(launch, None, walled=False),
            cwd=scratch.name,
            environment=environment,
        )
        return Process(process, scratch)
