"""A pose graph from a file or from the public graphs, in one call."""

from __future__ import annotations

import logging
import os
from pathlib import Path

from robust_slam.graphs import datasets, g2o
from robust_slam.graphs.g2o import Indefinite, Unknown
from robust_slam.graphs.pose_graph import PoseGraph

_LOG = logging.getLogger(__name__)


def load(
    source: str | os.PathLike[str],
    *,
    indefinite: Indefinite = "raise",
    unknown: Unknown = "raise",
) -> PoseGraph:
    """Return the graph of a g2o file, or a public graph by its name.

    ``source`` is a path, or one of ``datasets.NAMES`` where no such file exists. The other
    arguments are those of ``read``, which also returns the file's poses and ids. What was
    replaced or skipped is logged as a warning.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing: the public graph is not on this machine.
        DatasetChanged: its checksum is wrong.
        G2oError: as ``read``.
        OSError: the file cannot be read.
    """
    path = Path(source)
    if not path.exists():
        path = _public(os.fspath(source))
    content = g2o.read(path, indefinite=indefinite, unknown=unknown)
    if content.repaired.size:
        _LOG.warning(
            "%s: %d of %d information matrices were not positive definite and were replaced (%s)",
            path,
            content.repaired.size,
            len(content.graph.edges),
            indefinite,
        )
    for tag, count in content.skipped.items():
        _LOG.warning("%s: %d lines with the tag %s were skipped", path, count, tag)
    return content.graph


def _public(name: str) -> Path:
    try:
        return datasets.find(name)
    except datasets.DatasetMissing:
        raise
    except ValueError as error:
        raise FileNotFoundError(
            f"{name}: there is no such file, nor a public graph of that name; give the path of "
            f"a g2o file or one of {', '.join(datasets.NAMES)}"
        ) from error
