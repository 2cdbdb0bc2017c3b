"""Pose graphs: the groups, the arrays, files, generators, wrong closures and metrics.

A file passes these modules: ``files`` finds it, ``reading`` tells its format by its content,
``lines`` makes arrays of its lines, and ``formats``, ``g2o`` and ``trajectories`` say what the
numbers mean. ``tagged`` and ``matrices`` make and check a graph of them, ``quaternions`` the
rotations, ``doubts`` asks whether it was meant so, and a ``graph_file`` holds it all.
"""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
