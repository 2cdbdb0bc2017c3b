"""Robust estimators: kernels, and the loop that reweights, graduates and switches."""

from robust_slam._names import attach

__getattr__, __dir__, __all__ = attach(__name__, __file__)
