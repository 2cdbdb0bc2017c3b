"""Access times that student code could move: a file that one run reads tells the next that it did.

Only where a sandbox has no mounts of its own, which are read-only and so keep them as they are.
Linux moves a file's access time at most once a day, or once after each change of the file
(``relatime``, the default). So what is read once ahead of student code stays as it is for a day.
On a disk that is mounted with ``strictatime`` it moves with each reading.
"""

import contextlib
import os
import stat
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

LASTS_SECONDS = 12 * 3600.0
"""A batch's longest night; an access time that is older is moved ahead of it."""


def settle(readable: Iterable[tuple[Path, bool]]) -> None:
    """Read ahead what, of ``view.readable``, has an access time that a reading would move."""
    latest = time.time() - LASTS_SECONDS
    for path, whole in readable:
        with contextlib.suppress(OSError):  # what cannot be read cannot be moved either
            if os.statvfs(path).f_flag & (os.ST_NOATIME | os.ST_RDONLY):
                continue
            for one in _within(path) if whole else [path]:
                _read(one, latest)


def _within(path: Path) -> Iterator[Path]:
    """Yield a file, or a folder with all that is in it."""
    yield path
    for top, folders, files in os.walk(path):
        yield from (Path(top, name) for name in (*folders, *files))


def _read(path: Path, latest: float) -> None:
    with contextlib.suppress(OSError):
        facts = path.lstat()
        if facts.st_atime > max(facts.st_mtime, facts.st_ctime, latest):
            return
        if stat.S_ISLNK(facts.st_mode):
            os.readlink(path)
        elif stat.S_ISDIR(facts.st_mode):
            os.listdir(path)
        elif stat.S_ISREG(facts.st_mode):
            with open(path, "rb", buffering=0) as file:
                file.read(1)
