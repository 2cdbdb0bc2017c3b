"""Closures that agree in pairs, and the largest set of them."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
