"""Pose graphs in PyFactorGraph's text format, ``.pyfg``.

Tags: ``VERTEX_SE2 time id x y θ``, ``EDGE_SE2 time i j x y θ`` and 6 numbers of covariance;
``VERTEX_SE3:QUAT time id x y z qx qy qz qw``, ``EDGE_SE3:QUAT time i j x y z qx qy qz qw`` and 21
numbers. Metres, radians and seconds. The covariance, not the information, is the upper
triangle, row by row, in the order of g2o. An edge ``i j`` measures pose j in the frame of pose i.
The vertices are the true poses where the file is a simulation.

An id is a letter, which names the robot, and a number: A7. As a whole number it is GTSAM's key,
letter · 2⁵⁶ + number. Priors, landmarks and ranges are refused or, on demand, skipped.

Source: the module ``pyfg_text`` of PyFactorGraph, the program of the format.
"""

from __future__ import annotations

import re

import numpy as np

from robust_slam._arrays import Indices
from robust_slam.graphs import quaternions
from robust_slam.graphs.graph_file import Names
from robust_slam.graphs.tagged import Format, Layout

_BITS = 56
_ID = re.compile(r"[A-Za-z][0-9]{1,16}", re.ASCII)


def read_id(field: str) -> int | None:
    """Return the key of an id such as A7, or None where the field is not one."""
    return (ord(field[0]) << _BITS) + int(field[1:]) if _ID.fullmatch(field) else None


def _robots(ids: Indices) -> Indices:
    return np.asarray(ids >> _BITS)


def _names(ids: Indices) -> Names:
    words = [f"{chr(key >> _BITS)}{key & (2**_BITS - 1)}" for key in ids.ravel().tolist()]
    return np.array(words).reshape(ids.shape)


PYFG = Format(
    Layout(
        "VERTEX_SE2",
        "EDGE_SE2",
        3,
        3,
        lambda rows: rows.numbers[:, :3],
        covariance=True,
        angles=(2,),
    ),
    Layout("VERTEX_SE3:QUAT", "EDGE_SE3:QUAT", 7, 6, quaternions.poses_of, covariance=True),
    stamps=1,
    read_id=read_id,
    ids_are="a letter and a number, such as A7",
    names=_names,
    robots=_robots,
)
"""What the lines of a .pyfg file mean."""
