"""Factors beyond relative poses: priors, GPS, landmarks and ranges, and a robust solve of them."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
