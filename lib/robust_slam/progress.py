"""How a long computation shows where it is: a bar, a function, and the log."""

import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

Progress: TypeAlias = Callable[[str], None]
"""Is told in a few words what is computed now."""
_LOG = logging.getLogger("robust_slam")


@contextmanager
def stages(progress: bool | Progress) -> Iterator[Progress]:
    """Yield a function that tells the user what is computed now, and logs it.

    True shows it on the standard error, in one line if tqdm is installed and else in a line
    each; False shows nothing, and a function is called with the words.

    Raises:
        TypeError: ``progress`` is not one of these.
    """
    if callable(progress):
        yield lambda words: _told(words, progress)
        return
    if not isinstance(progress, bool):
        raise TypeError(f"progress is {progress!r}; give True, False or a function of one string")
    if not progress:
        yield lambda words: _told(words, None)
        return
    try:
        from tqdm.auto import tqdm
    except ImportError:
        yield lambda words: _told(words, lambda line: print(line, file=sys.stderr))
        return
    with tqdm(bar_format="{desc} [{elapsed}]") as bar:
        yield lambda words: _told(words, bar.set_description_str)


def _told(words: str, show: Callable[[str], object] | None) -> None:
    _LOG.info("%s", words)
    if show is not None:
        show(words)
