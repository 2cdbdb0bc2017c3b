"""Pose graphs: the arrays, residuals, first poses, generators, wrong closures and metrics.

What is in ``groups`` and ``files`` is offered here as well.
"""

import sys

from robust_slam._names import Moved, attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
_FILES = ("datasets", "formats", "g2o", "graph_file", "gtsam_graph", "trajectories")
_NOW = dict.fromkeys(("se2", "se3", "group"), "groups") | dict.fromkeys(_FILES, "files")
# Modules that programs outside import by the names that they had up to version 0.2.
sys.meta_path.append(Moved({f"{__name__}.{k}": f"robust_slam.{v}.{k}" for k, v in _NOW.items()}))
