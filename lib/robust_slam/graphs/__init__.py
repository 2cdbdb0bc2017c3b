"""Pose graphs: the groups, the arrays, files, generators, wrong closures and metrics."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
