"""Runs a command as an ordinary user, or as root where every folder on the way is open.

The grader's walls differ between the two. Where the interpreter lies in a folder that
others may not enter (root's home), the command gets a view of the disk in which that
folder holds the interpreter alone, and may be entered.
"""

from __future__ import annotations

import os
import shlex
import stat
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

ORDINARY = 1234
"""A user id without a name."""


def run(
    command: Sequence[str], *, uid: int, **options: object
) -> subprocess.CompletedProcess[str]:
    """Run a command in a mount namespace of its own; for root alone."""
    base = Path(sys.base_prefix).resolve()
    closed = [p for p in reversed(base.parents) if not p.stat().st_mode & stat.S_IXOTH]
    script = [_open_view(closed[0], base)] if closed else []
    drop = ["setpriv", f"--reuid={uid}", f"--regid={uid}", "--clear-groups", "--"] if uid else []
    script.append("exec " + shlex.join([*drop, *command]))
    shell = ["unshare", "--mount", "sh", "-ec", "\n".join(script)]
    return subprocess.run(shell, capture_output=True, text=True, **options)  # type: ignore[call-overload,no-any-return]


def _open_view(closed: Path, base: Path) -> str:
    """Shell commands that put an open folder, the interpreter in it, in a closed one's place."""
    aside, place, over = (shlex.quote(str(path)) for path in ("/mnt", base, closed))
    return "\n".join(
        [
            "mount --make-rprivate /",
            f"mount --rbind {place} {aside}",
            f"mount -t tmpfs -o mode=755 tmpfs {over}",
            f"mkdir -p {place}",
            f"mount --move {aside} {place}",
        ]
    )


def may() -> bool:
    """Whether this process may make such views."""
    return os.getuid() == 0
