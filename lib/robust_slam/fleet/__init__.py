"""GNC by several robots, each with its own part of the graph."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
