"""A figure: a ratio, and what is worth knowing about it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from benchmarks.speed.clock import Side, Spent


@dataclass(frozen=True)
class Figure:
    """Other ÷ ours in CPU seconds.

    Attributes:
        other: the best of the other side.
        ours: our side, by name each way to do it.
        remark: settings and results of both, for the reader.
    """

    other: Spent
    ours: dict[str, Spent]
    remark: str

    @property
    def ratios(self) -> dict[str, str]:
        """The ratio of each way; a lower bound, `> VALUE`, where the other was stopped."""
        bound = "> " if self.other.stopped else ""
        return {
            way: f"{bound}{self.other.seconds / spent.seconds:.2f}"
            for way, spent in self.ours.items()
        }


def named(sides: Sequence[Side], spent: Sequence[Spent]) -> dict[str, Spent]:
    """Return what each side spent, by its name."""
    return {side.name: own for side, own in zip(sides, spent, strict=True)}


def told(spent: dict[str, Spent]) -> str:
    """Return the times of several sides for the reader."""
    return ", ".join(f"{name} {shown(own)}" for name, own in spent.items())


def shown(spent: Spent) -> str:
    """Return seconds for the reader, such as `41.2 ms` or `3.4 s (once)`."""
    if spent.stopped:
        return f"stopped after {spent.seconds:.0f} s"
    number = f"{1e3 * spent.seconds:.1f} ms" if spent.seconds < 1.0 else f"{spent.seconds:.2f} s"
    return number if spent.runs > 1 else f"{number} (once)"
