"""How the failed cases of an exercise ended, as digests by which a label may be found."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

from robust_slam_autograder.misconceptions.prints import Called, Trace, digests

MOST_KEYS = 64
"""Of one exercise: with more numbers beside the edge of a cell than give so many, none fits."""


@dataclass(frozen=True)
class Seen:
    """What a case that failed saw of the functions that it called.

    Without digests it hung, died, or cannot be compared.
    """

    digests: tuple[str, ...] = ()
    """Of all that came back, and then those of neighbouring cells."""
    told: bool = False
    """Whether a value ended it, and not an exception."""
    real: bool = False
    """Whether it ended at numbers that are not whole, and so hardly by chance alike."""


@dataclass
class Shape:
    """What the failed cases of an exercise saw, by grade id."""

    failed: dict[str, Seen] = field(default_factory=dict)

    @property
    def lost(self) -> bool:
        """Tell whether a case cannot be compared."""
        return not all(seen.digests for seen in self.failed.values())

    @property
    def real(self) -> bool:
        """Tell whether a case ended at numbers that are not whole."""
        return any(seen.real for seen in self.failed.values())

    def keys(self) -> tuple[str, ...]:
        """Return the key of all that came back, and then those of its neighbours.

        There is none where a case cannot be compared, or each ended in an exception.
        """
        if self.lost or not any(seen.told for seen in self.failed.values()):
            return ()
        names = sorted(self.failed)
        ways = itertools.product(*(self.failed[name].digests for name in names))
        found = list(itertools.islice(ways, MOST_KEYS + 1))
        return tuple(_key(names, one) for one in found) if len(found) <= MOST_KEYS else ()


def _key(names: Sequence[str], found: Sequence[str]) -> str:
    text = " ".join(f"{name}={one}" for name, one in zip(names, found, strict=True))
    return hashlib.sha256(text.encode()).hexdigest()


def digests_of(calls: Sequence[Called]) -> tuple[str, ...]:
    """Return the digests of what some calls returned together."""
    return digests(part for one in calls for part in ((one.name, None), *one.parts))


def seen_by(trace: Trace) -> Seen:
    """Return what a test cell saw that failed."""
    found = digests_of(trace.calls) if trace.calls else ()
    return Seen(found, not trace.raised, trace.is_real)


def of_beginnings(trace: Trace) -> frozenset[str]:
    """Return the digests of what had come back after each call of a test cell."""
    ends = range(1, len(trace.calls) + 1)
    return frozenset(one for end in ends for one in digests_of(trace.calls[:end]))
