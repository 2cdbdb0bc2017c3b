"""One closure at a time: a map that grows, and takes closures back when evidence turns."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
