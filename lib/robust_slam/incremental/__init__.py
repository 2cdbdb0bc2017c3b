"""One closure at a time: a map that grows, and takes closures back when evidence turns."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
