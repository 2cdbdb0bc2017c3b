"""Imported once, by the server that trusted processes are forked from: makes it ready.

That server is ``multiprocessing``'s. It takes its settings from the environment, for
it takes nothing else but names of modules.
"""

import atexit
import contextlib
import gc
import importlib
import json
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

from robust_slam_autograder import temporary

VARIABLE = "AUTOGRADER_TRUSTED_SERVER"


@contextlib.contextmanager
def told(modules: Sequence[str], folder: str) -> Iterator[None]:
    """Tell a server that is started within this context.

    Args:
        modules: to import, where that works.
        folder: the batch's temporary one. The server outlives a batch that is killed, and
            removes it.
    """
    os.environ[VARIABLE] = json.dumps([list(modules), folder])
    try:
        yield
    finally:
        del os.environ[VARIABLE]


def make_ready(modules: Sequence[str], folder: str) -> None:
    """See to the folder's end, and import."""
    # First: the batch may be killed during the imports. Forked processes end without this.
    atexit.register(temporary.remove, Path(folder))
    # Each of its processes has a core to itself; the buffers of more threads count as memory.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    gc.disable()  # what is imported stays, and to look through it again and again takes time
    for module in modules:
        # A module that fails will fail again where it is wanted, and be told of there.
        with contextlib.suppress(Exception):
            importlib.import_module(module)
    # A collection would touch, and so copy, every object that the processes share.
    gc.collect()
    gc.freeze()
    gc.enable()


if VARIABLE in os.environ:
    make_ready(*json.loads(os.environ.pop(VARIABLE)))
