"""Pyodide's files: taken from a folder or downloaded, and each one verified."""

import os
import shutil
from collections.abc import Callable
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


def checksums() -> dict[str, str]:
    """Return the SHA-256 of each file by its name, from the list that ``sha256sum`` wrote."""
    lines = LIST.read_text(encoding="utf-8").splitlines()
    return {name: digest for digest, name in (line.split(maxsplit=1) for line in lines)}


def fetch(target: Path, source: str | None = None) -> None:
    """Put all files into ``target``.

    Correct files that are already there stay, so a second run goes on where the first one
    stopped; what is not listed is deleted. A file gets its name only after its checksum was
    verified. Without a source, a folder with the files, they are downloaded.

    Raises:
        RuntimeUnavailable: a file cannot be had, or its checksum is wrong.
    """
    files = checksums()
    pooch.get_logger().setLevel("ERROR")
    if source and not Path(source).is_dir():
        raise RuntimeUnavailable(f"{FOLDER} names {source}, and there is no such folder.")
    target.mkdir(parents=True, exist_ok=True)
    for path in target.iterdir():
        if path.name not in files:
            path.unlink()
    get = _copy if source else pooch.HTTPDownloader(timeout=SECONDS)
    base = f"{os.path.abspath(source)}/" if source else URL
    for number, (name, digest) in enumerate(files.items(), 1):
        print(f"{number} of {len(files)}: {name}", flush=True)
        _fetch(base + name, digest, target / name, get)


def _fetch(address: str, digest: str, path: Path, get: Callable[..., None]) -> None:
    try:
        pooch.retrieve(address, f"sha256:{digest}", path.name, path.parent, downloader=get)
    except FileNotFoundError as error:
        fix = f"put it there, or unset {FOLDER} to download all files"
        raise RuntimeUnavailable(f"{address}: the file is missing; {fix}.") from error
    # pooch raises ValueError for a wrong checksum, after it has deleted what it fetched.
    except ValueError as error:
        why = f"this is not the file of Pyodide {VERSION}: its SHA-256 is not {digest[:12]}…"
        fix = "get it from Pyodide's release again"
        raise RuntimeUnavailable(f"{address}: {why}; {fix}.") from error
    except OSError as error:
        fix = f"try again, or let {FOLDER} name a folder with Pyodide's files"
        raise RuntimeUnavailable(f"{address}: {error}; {fix}.") from error
    path.chmod(0o644)  # a web server is another user


def _copy(address: str, part: str, _: object) -> None:
    """Copy a file in place of a download, as pooch calls it."""
    shutil.copyfile(address, part)
