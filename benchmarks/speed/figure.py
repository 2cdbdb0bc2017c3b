"""A figure: a ratio, and what is worth knowing about it."""

from __future__ import annotations

from dataclasses import dataclass

from benchmarks.speed.clock import Spent


@dataclass(frozen=True)
class Figure:
    """Other ÷ ours in CPU seconds.

    Attributes:
        other: the best of the other side.
        ours: our side.
        remark: settings and results of both, for the reader.
    """

    other: Spent
    ours: Spent
    remark: str

    @property
    def ratio(self) -> str:
        """The ratio; a lower bound, `> VALUE`, where the other side was stopped."""
        bound = "> " if self.other.stopped else ""
        return f"{bound}{self.other.seconds / self.ours.seconds:.2f}"


def shown(spent: Spent) -> str:
    """Return seconds for the reader, such as `41.2 ms` or `3.4 s (once)`."""
    if spent.stopped:
        return f"stopped after {spent.seconds:.0f} s"
    number = f"{1e3 * spent.seconds:.1f} ms" if spent.seconds < 1.0 else f"{spent.seconds:.2f} s"
    return number if spent.runs > 1 else f"{number} (once)"
