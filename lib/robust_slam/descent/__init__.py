"""First poses, and Gauss–Newton and Levenberg–Marquardt from there."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
