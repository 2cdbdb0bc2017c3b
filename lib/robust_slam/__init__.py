"""Robust estimation on pose graphs: the reference library of the Robust SLAM course.

The short way::

    import robust_slam as rs

    graph = rs.load("my.g2o")  # or the name of a public graph, such as "intel"
    answer = rs.solve(graph)
    print(graph.summary(), answer.summary(), sep="\\n\\n")

The folders follow the course:

- ``estimators``: kernels, and the loop that reweights, graduates and switches
- ``groups``: poses in the plane and in space, SE(2) and SE(3)
- ``graphs``: pose graphs, their residuals, generators, outliers and metrics
- ``files``: formats of graphs and trajectories, doubts about a file, public graphs
- ``descent``: first poses, then Gauss-Newton or Levenberg-Marquardt from there
- ``consistency``: loop closures that agree in pairs, and the largest set of them
- ``certificates``: whether a map is globally optimal, and the way out of a local minimum
- ``factors``: priors, GPS, landmarks and ranges beside relative poses
- ``fleet``: GNC by several robots, each with its own part of the graph
- ``problems``: what the loop can solve: a location, a linear problem, a rotation, a pose graph
- ``solver``: several starts, the noise, the best map and its certificate in one function
- ``incremental``: a map that grows, one closure at a time
- ``drawing``: a map in one line; ``palette``: its colours
- ``progress``: how long computations show where they are
- ``cli``: the command ``robust-slam``

Each folder offers its main functions under short names: ``rs.estimators.gnc`` or
``from robust_slam.estimators import gnc, irls``. A module loads when first used.
"""

from importlib.metadata import PackageNotFoundError, version

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)


try:
    __version__ = version("robust-slam")
except PackageNotFoundError:  # run from a folder that was never installed
    __version__ = "unknown"
del PackageNotFoundError, version
