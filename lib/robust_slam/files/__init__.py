"""Files of pose graphs and trajectories: read, checked for what they hardly meant, and written.

A file passes these modules: ``reading`` finds it and tells its format by its content, ``lines``
makes arrays of its lines, and ``formats``, ``g2o`` and ``trajectories`` say what the numbers mean.
``tagged`` and ``matrices`` make a graph of them, ``doubts`` asks whether it was meant so, and a
``graph_file`` holds it all.
"""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
