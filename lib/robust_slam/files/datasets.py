"""The nine public pose graphs; ``load`` reads local files and never downloads.

``load`` looks in the folder of the environment variable ``ROBUST_SLAM_DATA`` and then in
the user's cache. ``make data``, which is ``python -m robust_slam.files.datasets``, downloads all
of them to the cache. ``make book`` first tries to download the two that the chapters show.

Source: the data folder of SE-Sync (Rosen et al. 2019), pinned to one commit.
"""

import hashlib
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from importlib import import_module
from pathlib import Path
from types import ModuleType

from robust_slam.files.g2o import G2O
from robust_slam.files.tagged import graph_of
from robust_slam.graphs.pose_graph import PoseGraph

URL = (
    "https://raw.githubusercontent.com/david-m-rosen/SE-Sync/"
    "9b631b6b82d8aa7d32ab846412ae1c070412b7b6/data/"
)
"""Where ``download`` finds the files."""
SHA256 = {
    "CSAIL": "66d99ac857a9849d814d214a9ebd0d4876d5d40f0a37be9330c1ff6e6e9daaa6",
    "city10000": "df5988994339e990be198a36e7f640e31a5a1b26df3ed400363fafc49d5ca630",
    "intel": "3e0724c048e0ba524be9dd268a8b78e19a2497043143584cbb61310638b15c4b",
    "manhattan": "6ae8d30971720c1af24a00c4b2dd5c5ddafbbbe488bfc771145c47decbffb248",
    "parking-garage": "3ac0a31bfb601d7455d451e2546655cb5dececf51a7823f57c8a7e0fe1ca6527",
    "smallGrid3D": "9ea56c2ad1ebcc322560eb2f8d83cb3a60f99e2e2acc35e097b1162cdbafd649",
    "sphere2500": "104ab57593394f24351d9f692f3b923f8b98fff1eb638c64356cf5049e06cf3c",
    "tinyGrid3D": "c341eb0d09f7556b337be5a62b9354384885333a25fa718fd699fafb19620493",
    "torus3D": "1ef8831023b372188d33ca63ce0da079d51df89364df71f2bce1c5c7c69ed5ec",
}
"""The SHA-256 of each file ``<name>.g2o``."""
NAMES = tuple(SHA256)
"""The names of the graphs; "M3500" is another name for "manhattan"."""
SHOWN = ("CSAIL", "intel")
"""The graphs that the chapters show where they are on the machine: 0.4 MB together."""
FOLDER = "ROBUST_SLAM_DATA"
"""The environment variable that names a folder with the files."""
_DOWNLOAD = "python -m robust_slam.files.datasets"


class DatasetMissing(FileNotFoundError):
    """A public graph is not on this machine."""


class DatasetChanged(ValueError):
    """A file has the name of a public graph but other content."""


class DownloadFailed(OSError):
    """A public graph could not be downloaded, or its checksum is wrong; no file was kept."""


def load(name: str) -> PoseGraph:
    """Return a public graph, of the ``NAMES``, without a download, or raise what ``find`` does."""
    return graph_of(find(name).read_text("utf-8"), G2O, "raise", "raise").graph


def is_here(name: str) -> bool:
    """Tell whether a public graph is on this machine; other errors are those of ``find``."""
    with suppress(DatasetMissing):
        return find(name).is_file()
    return False


def load_or_generate(name: str, make: Callable[[], PoseGraph]) -> tuple[PoseGraph, str]:
    """Return a public graph, or that of ``make()`` if it is missing, and a sentence of which."""
    with suppress(DatasetMissing):
        return load(name), f"The graph is the public data set {name}."
    return make(), (
        f"The public data set {name} is not on this machine, so the graph here is a generated "
        "one; `make data` downloads the public ones."
    )


def find(name: str) -> Path:
    """Return the path of a public graph's file, after a check of its content.

    Raises:
        DatasetMissing: it is not on this machine.
        DatasetChanged: its checksum is wrong.
        ValueError: there is no public graph of that name.
    """
    known = _known(name)
    for folder in _folders():
        path = folder / f"{known}.g2o"
        if path.is_file():
            return _checked(path, SHA256[known])
    raise DatasetMissing(
        f"the public graph {name} is not on this machine; run `{_DOWNLOAD}` (in the course's "
        f"folder `make data` does it), or let {FOLDER} name a folder with {known}.g2o"
    )


def download(names: Iterable[str] = NAMES, base_url: str = URL) -> list[Path]:
    """Download public graphs to the user's cache, and return the paths of their files.

    A correct file that is there is not downloaded again. A bar is shown on the standard error.

    Raises:
        DownloadFailed: a file cannot be downloaded, or its checksum is wrong.
        ImportError, ValueError: pooch or tqdm is missing, or there is no such public graph.
    """
    _needed("tqdm")
    return [_fetch(name, base_url, progressbar=True) for name in [*map(_known, names)]]


def try_download(names: Iterable[str] = SHOWN, base_url: str = URL) -> list[Path]:
    """Download public graphs that are missing, if that is possible, and return their paths.

    Nothing is shown, and the first failure of the network, or 5 s without an answer, ends the
    attempt without an error. Nothing is downloaded where the environment variable ``CI`` is set.
    Other errors are those of ``find`` and ``download``.
    """
    in_ci = os.environ.get("CI", "").lower() not in ("", "0", "false")
    missing = [] if in_ci else [_known(name) for name in names if not is_here(name)]
    fetched: list[Path] = []
    with suppress(DownloadFailed):
        for name in missing:
            _needed("pooch").get_logger().setLevel("ERROR")
            fetched.append(_fetch(name, base_url, timeout=5.0))
    return fetched


def _known(name: str) -> str:
    known = {"M3500": "manhattan"}.get(name, name)
    if known not in SHA256:
        raise ValueError(f"there is no public graph {name!r}; the names are {', '.join(NAMES)}")
    return known


def _folders() -> list[Path]:
    found = [Path(given)] if (given := os.environ.get(FOLDER)) else []
    with suppress(ImportError):
        found.append(Path(_needed("pooch").os_cache("robust-slam")))
    return found


def _needed(module: str) -> ModuleType:
    with suppress(ImportError):
        return import_module(module)
    raise ImportError(f"{module} is missing; install the extra `data`: pip install pooch tqdm")


def _checked(path: Path, sha256: str) -> Path:
    if (found := hashlib.sha256(path.read_bytes()).hexdigest()) == sha256:
        return path
    raise DatasetChanged(
        f"{path}: the content is not that of the public graph (SHA-256 {found[:12]}…, not "
        f"{sha256[:12]}…); delete the file and run `{_DOWNLOAD}`"
    )


def _fetch(name: str, base_url: str, **options: float) -> Path:
    """Return the path of a file in the cache; ``options`` are those of pooch's downloader."""
    pooch, file, known = _needed("pooch"), f"{name}.g2o", f"sha256:{SHA256[name]}"
    load, cache = pooch.HTTPDownloader(**options), pooch.os_cache("robust-slam")
    try:
        return Path(pooch.retrieve(base_url + file, known, file, cache, downloader=load))
    # Errors of the connection are OSErrors; a wrong hash is a ValueError.
    except (OSError, ValueError) as error:
        remedy = f"try again, or put the file into a folder that {FOLDER} names"
        raise DownloadFailed(f"{base_url}{file}: {error}; {remedy}") from error


def main(arguments: Sequence[str] = ()) -> int:
    """Download all public graphs; return 0, or 1 after a message if that fails.

    With ``--try``, try to download those that the chapters show, quietly, and return 0.
    """
    if "--try" in arguments:
        try_download()
        return 0
    try:
        paths = download()
    except (DownloadFailed, ImportError) as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{len(paths)} public graphs are in {paths[0].parent}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
