"""Commands that run as an ordinary user, or as root where every folder on the way is open.

The grader's walls differ between the two. Where the interpreter or the course lies in a
folder that others may not enter (root's home), the command gets a view of the disk in
which that folder holds them alone, and may be entered.
"""

import os
import shlex
import stat
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

GRADER = Path(__file__).resolve().parents[1]
ROOT = Path(__file__).resolve().parents[__name__.count(".")]
"""From where tests are imported: the course, or the grader where it is alone."""
SCRIPTS = Path(sys.executable).parent
ORDINARY = 59_990
"""A user id without a name, which owns nothing."""
ASIDE = "/mnt"
NEEDED = {Path(sys.base_prefix).resolve(), Path(sys.prefix).resolve(), ROOT}
"""What others have to reach."""


def nothing_set_up(home: Path) -> dict[str, str]:
    """Variables for a user who has nothing set up."""
    own = {f"JUPYTER_{name}_DIR": str(home / name) for name in ("CONFIG", "DATA", "RUNTIME")}
    return {
        **os.environ,
        **own,
        "HOME": str(home),
        "IPYTHONDIR": str(home / "ipython"),
        "PATH": os.pathsep.join([str(SCRIPTS), os.environ.get("PATH", "")]),
    }


def ended(words: Sequence[object], **options: Any) -> subprocess.CompletedProcess[str]:
    """Run a command to its end, and keep what it says."""
    return subprocess.run([*map(str, words)], capture_output=True, text=True, **options)


def may() -> bool:
    """Whether this process may become others."""
    return os.getuid() == 0


def command(words: Sequence[str], uid: int) -> list[str]:
    """The command that runs a command as a user, with the open view; for root alone."""
    drop = ["setpriv", f"--reuid={uid}", f"--regid={uid}", "--clear-groups", "--"] if uid else []
    script = [*_open_view(), "exec " + shlex.join([*drop, *words])]
    return ["unshare", "--mount", "sh", "-ec", "\n".join(script)]


def _open_view() -> list[str]:
    """Shell commands that put open folders, with what is needed in them, in closed ones' place."""
    outer = sorted(path for path in NEEDED if not NEEDED.intersection(path.parents))
    ways = {path: way for path in outer if (way := closed(path))}
    if not ways:
        return []
    aside = {path: f"{ASIDE}/{number}" for number, path in enumerate(ways)}
    lines = ["mount --make-rprivate /", f"mount -t tmpfs tmpfs {ASIDE}"]
    lines += [f"mkdir {aside[p]}; mount --rbind {shlex.quote(str(p))} {aside[p]}" for p in ways]
    for way in sorted(set(ways.values())):
        lines.append(f"mount -t tmpfs -o mode=755 tmpfs {shlex.quote(str(way))}")
    for path in ways:
        place = shlex.quote(str(path))
        lines.append(f"mkdir -p {place}; mount --move {aside[path]} {place}")
    return lines


def closed(path: Path) -> Path | None:
    """The first folder on the way to a path that others may not enter."""
    ways = [way for way in reversed(path.parents) if not way.stat().st_mode & stat.S_IXOTH]
    return ways[0] if ways else None
