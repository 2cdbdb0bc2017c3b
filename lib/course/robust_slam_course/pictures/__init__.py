"""The live pictures of the course: each function returns one for a page or a notebook.

Names load their module when they are first used.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
