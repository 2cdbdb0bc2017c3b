"""The groups of poses in the plane and in space, SE(2) and SE(3), and their rotations."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
