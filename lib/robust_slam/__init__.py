"""Robust estimation on pose graphs: the reference library of the Robust SLAM course.

The short way::

    import robust_slam as rs

    graph = rs.load("my.g2o")  # or the name of a public graph, such as "intel"
    answer = rs.solve(graph)
    print(graph.summary(), answer.summary(), sep="\\n\\n")

The folders follow the course:

- ``estimators``: kernels, and the loop that reweights, graduates and switches
- ``graphs``: pose graphs, their groups, files, generators, outliers and metrics
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
- ``breaking``: the game of fooling a solver with few outliers
- ``cli``: the command ``robust-slam``

Each folder offers its main functions under short names: ``rs.estimators.gnc`` or
``from robust_slam.estimators import gnc, irls``. A module loads when first used.
"""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version

import lazy_loader

_load, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
_FOLDERS = ("estimators", "graphs", "descent", "consistency", "certificates", "factors", "fleet")


def __getattr__(name: str) -> object:
    try:
        return _load(name)
    except AttributeError:
        for folder in (f"{__name__}.{folder}" for folder in _FOLDERS):
            if name in import_module(folder).__all__:
                raise AttributeError(
                    f"{__name__} has no {name}; it is {folder}.{name}", name=name
                ) from None
        raise


try:
    __version__ = version("robust-slam")
except PackageNotFoundError:  # run from a folder that was never installed
    __version__ = "unknown"
del PackageNotFoundError, version
