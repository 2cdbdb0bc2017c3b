"""Global optimality: the chordal problem, its certificate and the Riemannian staircase."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
