"""Numbers with their noun, for messages."""

from collections.abc import Iterable


def counted(count: int, noun: str, plural: str | None = None) -> str:
    """Return for instance "1 edge" or "1,200 edges"; ``plural`` is by default noun + s.

    >>> counted(1, "edge"), counted(1200, "edge"), counted(0, "matrix", "matrices")
    ('1 edge', '1,200 edges', '0 matrices')
    """
    return f"{count:,} {noun if count == 1 else plural or noun + 's'}"


def few(things: Iterable[object]) -> str:
    """Return the first five things, and "…" if there are more."""
    shown = [str(thing) for thing in things]
    return ", ".join([*shown[:5], *["…"] * (len(shown) > 5)])


def so_do(count: int) -> str:
    """Return the words for ``count`` more things of the kind that a sentence names, or none.

    >>> so_do(0), so_do(1200)
    ('', ' (so do 1,200 more)')
    """
    return f" (so do {count:,} more)" if count else ""
