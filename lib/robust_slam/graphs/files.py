"""A pose graph from a file or from the public graphs, in one call."""

from __future__ import annotations

import logging
import os
from pathlib import Path

from robust_slam.graphs import datasets
from robust_slam.graphs.lines import Unknown
from robust_slam.graphs.matrices import Indefinite
from robust_slam.graphs.pose_graph import PoseGraph
from robust_slam.graphs.reading import read

_LOG = logging.getLogger(__name__)


def load(
    source: str | os.PathLike[str],
    *,
    indefinite: Indefinite = "raise",
    unknown: Unknown = "raise",
    odometry: tuple[float, float] | None = None,
    closures: str | os.PathLike[str] | None = None,
) -> PoseGraph:
    """Return the graph of a file in any format that ``read`` knows, or a public graph.

    ``source`` is a path, or one of ``datasets.NAMES`` where no such file exists. The other
    arguments are those of ``read``, which also returns the file's poses and ids. What was
    replaced, skipped, assumed or looks wrong is logged as a warning.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing: the public graph is not on this machine.
        DatasetChanged: its checksum is wrong.
        GraphFileError, ValueError: as ``read``.
        OSError: the file cannot be read.
    """
    path = find(source)
    content = read(
        path, indefinite=indefinite, unknown=unknown, odometry=odometry, closures=closures
    )
    for words in content.remarks():
        _LOG.warning("%s: %s", path, words)
    return content.graph


def find(source: str | os.PathLike[str]) -> Path:
    """Return the path of a file, or of a public graph by its name.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing: the public graph is not on this machine.
        DatasetChanged: its checksum is wrong.
    """
    path, name = Path(source), os.fspath(source)
    if path.exists():
        return path
    try:
        return datasets.find(name)
    except (datasets.DatasetMissing, datasets.DatasetChanged):
        raise
    except ValueError as error:
        raise FileNotFoundError(
            f"{name}: there is no such file, nor a public graph of that name; give the path of "
            f"a file or one of {', '.join(datasets.NAMES)}"
        ) from error
