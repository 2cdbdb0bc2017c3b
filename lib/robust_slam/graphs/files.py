"""A pose graph from a file or from the public graphs, in one call."""

from __future__ import annotations

import logging
import os
from pathlib import Path

from robust_slam._words import counted
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
    replaced or skipped is logged as a warning, and so is odometry across a gap in the ids.

    Raises:
        FileNotFoundError: there is neither such a file nor a public graph of that name.
        DatasetMissing: the public graph is not on this machine.
        DatasetChanged: its checksum is wrong.
        G2oError: as ``read``.
        OSError: the file cannot be read.
    """
    path = find(source)
    content = g2o.read(path, indefinite=indefinite, unknown=unknown)
    if content.repaired.size:
        _LOG.warning(
            "%s: %d of %s not positive definite and replaced (%s)",
            path,
            content.repaired.size,
            counted(len(content.graph.edges), "information matrix", "information matrices"),
            indefinite,
        )
    for tag, count in content.skipped.items():
        _LOG.warning("%s: skipped %s with the tag %s", path, counted(count, "line"), tag)
    if content.leaps.size:
        remedy = (
            "mark it in a copy of graph.is_odometry as False (entry "
            f"{content.leaps[0]}) and call dataclasses.replace(graph, is_odometry=copy)"
        )
        _LOG.warning("%s: %s", path, leap_words(content, remedy))
    return content.graph


def leap_words(content: g2o.G2o, remedy: str) -> str:
    """Return a sentence about the odometry that crosses a gap in the ids; there is some."""
    first, *others = content.leaps
    i, j = content.names[content.graph.edges[first]]
    more = f" (so do {len(others):,} more)" if others else ""
    return (
        f"edge {i}-{j} crosses a gap in the ids{more} and counts as odometry, which is trusted; "
        f"if it is a loop closure, {remedy}"
    )


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
            f"a g2o file or one of {', '.join(datasets.NAMES)}"
        ) from error
