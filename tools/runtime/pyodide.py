"""Pyodide's files: taken from a folder or downloaded, and each one verified."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pooch

VERSION = "0.27.7"
URL = f"https://cdn.jsdelivr.net/pyodide/v{VERSION}/full/"
"""Where Pyodide publishes the files of its release one by one."""
FOLDER = "ROBUST_SLAM_PYODIDE"
"""The environment variable that names a folder with the files."""
LIST = Path(__file__).with_name("pyodide.sha256")
SECONDS = 30.0
"""How long to wait for the server."""


class RuntimeUnavailable(Exception):
    """A file is missing, cannot be downloaded, or is another one; nothing of it was kept."""


def checksums(path: Path = LIST) -> dict[str, str]:
    """Return the SHA-256 of each file by its name, from a list as ``sha256sum`` writes it."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return {name: digest for digest, name in (line.split(maxsplit=1) for line in lines)}


def fetch(
    target: Path,
    source: str | None = None,
    *,
    files: Mapping[str, str] | None = None,
    url: str = URL,
    say: Callable[[str], None] = print,
) -> list[Path]:
    """Put all files into ``target``, and return their paths.

    Correct files that are already there stay, so a second run goes on where the first one
    stopped. A file gets its name only after its checksum was verified.

    Args:
        target: the folder to fill; what is there and not listed is deleted.
        source: a folder with the files; without it they are downloaded.
        files: SHA-256 by name.
        url: the address of the folder to download from.
        say: shows a line of progress.

    Raises:
        RuntimeUnavailable: a file cannot be had, or its checksum is wrong.
    """
    files = checksums() if files is None else files
    pooch.get_logger().setLevel("ERROR")
    if source and not Path(source).is_dir():
        raise RuntimeUnavailable(f"{FOLDER} names {source}, and there is no such folder.")
    target.mkdir(parents=True, exist_ok=True)
    for path in target.iterdir():
        if path.name not in files:
            path.unlink()
    get = _copy if source else pooch.HTTPDownloader(timeout=SECONDS)
    base = f"{os.path.abspath(source)}/" if source else url
    paths = []
    for number, (name, digest) in enumerate(files.items(), 1):
        say(f"{number} of {len(files)}: {name}")
        path = _fetch(base + name, digest, target, get)
        path.chmod(0o644)  # a web server is another user
        paths.append(path)
    return paths


def _fetch(address: str, digest: str, target: Path, get: Callable[..., None]) -> Path:
    name = address.rsplit("/", 1)[1]
    try:
        return Path(pooch.retrieve(address, f"sha256:{digest}", name, target, downloader=get))
    except FileNotFoundError as error:
        why, fix = "the file is missing", f"put it there, or unset {FOLDER} to download all files"
        raise RuntimeUnavailable(f"{address}: {why}; {fix}.") from error
    # pooch raises ValueError for a wrong checksum, after it has deleted what it fetched.
    except ValueError as error:
        why = f"this is not the file of Pyodide {VERSION}: its SHA-256 is not {digest[:12]}…"
        fix = "get it from Pyodide's release again"
        raise RuntimeUnavailable(f"{address}: {why}; {fix}.") from error
    except OSError as error:
        fix = f"try again, or let {FOLDER} name a folder with Pyodide's files"
        raise RuntimeUnavailable(f"{address}: {error}; {fix}.") from error


def _copy(address: str, part: str, _: object) -> None:
    """Copy a file in place of a download, as pooch calls it."""
    shutil.copyfile(address, part)
