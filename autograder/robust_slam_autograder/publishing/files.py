"""Which of a course's files git tracks, and which of these the public may have."""

import os
import subprocess
from collections.abc import Iterable
from pathlib import Path

from robust_slam_autograder.errors import WrongUse
from robust_slam_autograder.publishing.course import Public


def tracked(root: Path) -> list[str]:
    """Paths below a folder that git tracks and that are there.

    Raises:
        WrongUse: git is missing, or the folder is no part of a repository.
    """
    command = ["git", "-C", str(root), "ls-files", "-z", "--cached"]
    try:
        done = subprocess.run(command, capture_output=True, check=True)
    except FileNotFoundError as error:
        raise WrongUse("git is not installed: it says which files are the course's.") from error
    except subprocess.CalledProcessError as error:
        why = error.stderr.decode(errors="replace").strip().removeprefix("fatal: ")
        raise WrongUse(f"git cannot say which files are the course's: {why}.") from error
    names = done.stdout.decode(errors="surrogateescape").split("\0")
    return sorted(name for name in names if name and os.path.lexists(root / name))


def chosen(public: Public, names: Iterable[str], source: Path) -> list[str]:
    """Of these paths those that the public may have.

    Raises:
        WrongUse: an entry of the list, in the file ``source``, stands for no path.
    """
    known = list(names)
    for entry in (*public.files, *public.without):
        if not any(_stands_for(entry, name) for name in known):
            raise WrongUse(f"{source}: [public] lists {entry}, and git tracks no such file.")
    taken = [name for name in known if any(_stands_for(entry, name) for entry in public.files)]
    return [n for n in taken if not any(_stands_for(entry, n) for entry in public.without)]


def _stands_for(entry: str, name: str) -> bool:
    return name.startswith(entry) if entry.endswith("/") else name == entry
