"""Files that are whole or not there, on a disk that may be full and in a run that may be killed.

One process writes at a time: a file that a killed one left half-written has a fixed
name and is written over.
"""

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from robust_slam_autograder.errors import GraderFailure


def part_of(path: Path) -> Path:
    """Return where a file is made before it is renamed into place."""
    return path.with_name(f".{path.name}.part")


def write(path: Path, text: str, *, private: bool = False) -> None:
    """Write a file by renaming a finished one into place, making its folder if need be.

    A private one is for its owner's eyes only.

    Raises:
        GraderFailure: it cannot be written; what was there before still is.
    """
    part = part_of(path)
    with explained(path, part):
        path.parent.mkdir(parents=True, exist_ok=True)
        mode = 0o600 if private else 0o644
        descriptor = os.open(part, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, mode)
        with open(descriptor, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(text)
            file.flush()
            # A power cut after the rename must not leave an empty file under the name.
            os.fsync(file.fileno())
        os.replace(part, path)


def append(path: Path, line: str) -> None:
    """Add a line to a file that is there.

    Raises:
        GraderFailure: it cannot be written.
    """
    with explained(path), open(path, "a", encoding="utf-8") as file:
        file.write(f"{line}\n")


@contextlib.contextmanager
def explained(path: Path, part: Path | None = None) -> Iterator[None]:
    """Say of a write that fails what to do; ``part`` is a half-made file to remove.

    Raises:
        GraderFailure: in place of an OSError.
    """
    try:
        yield
    except OSError as error:
        if part is not None:
            with contextlib.suppress(OSError):
                part.unlink()
        raise GraderFailure(
            f"{path} cannot be written ({error.strerror or error}): make room or make its folder "
            "writable, and give the same command again; it goes on from here."
        ) from error
