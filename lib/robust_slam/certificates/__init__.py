"""Global optimality: the chordal problem, its certificate and the Riemannian staircase."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
