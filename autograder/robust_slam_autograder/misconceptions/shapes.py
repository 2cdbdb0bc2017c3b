"""How the failed cases of an exercise ended, as digests by which a label may be found."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from robust_slam_autograder.misconceptions import aspects, traits
from robust_slam_autograder.misconceptions.prints import Called, Part, Trace, digests

MOST_KEYS = 64
"""Of one exercise: with more numbers beside the edge of a cell than give so many, none fits."""
MOST_SEEN = 60
"""Calls of one test cell, of which aspects are taken."""
WHOLE = ""
"""The aspect that leaves all."""
ENTRIES = "entries "
"""Before the number of a call: the entries that it returned, each by itself."""
AROUND = "around "
"""The same, with the neighbours' cells."""
MOST_ENTRIES = 400
COUNT = "count "
"""Before the number of a call and their kind: how many entries it returned."""
CALLS, RAISED, FRACTIONS = "calls", "raised", "fractions"
"""The number of the last call, and the same where it raised or returned fractions."""

Digests = dict[str, tuple[str, ...]]
"""By aspect, the digest of what a test cell saw, and those of neighbouring cells."""


@dataclass(frozen=True)
class Seen:
    """What a case saw of the functions that it called.

    Without digests it hung, died, or cannot be compared.
    """

    digests: Digests = field(default_factory=dict)
    told: bool = False
    """Whether a value ended it, and not an exception."""
    real: bool = False
    """Whether it ended at numbers that are not whole."""
    end: tuple[str, ...] = ()
    """The traits of its last call."""
    passed: Mapping[str, int] = field(default_factory=dict)
    """Of a case that passed, by trait how many calls have it."""


@dataclass
class Shape:
    """What the failed cases of an exercise saw.

    Attributes:
        failed: by grade id; a case that passed is not there.
        told: whether a value ended one of them, and not an exception.
        lost: whether one of them cannot be compared.
    """

    failed: dict[str, Digests] = field(default_factory=dict)
    told: bool = False
    lost: bool = False
    real: bool = False
    """Whether one of them ended at numbers that are not whole, and so hardly by chance alike."""
    ends: dict[str, list[str]] = field(default_factory=dict)
    """By grade id the traits of the call at which a case failed; none where it hung or died."""
    passed: dict[str, int] = field(default_factory=dict)
    """By trait, how many calls of the cases that passed have it."""

    def add(self, grade_id: str, seen: Seen) -> None:
        """Note a case that failed."""
        self.real |= seen.real
        self.ends[grade_id] = sorted(seen.end)
        self.failed[grade_id] = seen.digests
        self.lost |= WHOLE not in seen.digests
        self.told |= seen.told

    def accept(self, passed: Mapping[str, int]) -> None:
        """Note a case that passed, by the traits of its calls."""
        for trait, times in passed.items():
            self.passed[trait] = self.passed.get(trait, 0) + times

    @property
    def is_known(self) -> bool:
        """Tell whether a label may fit."""
        return self.told and not self.lost

    @property
    def has_ends(self) -> bool:
        """Tell whether it is known at which call each of its cases failed."""
        return bool(self.ends) and all(self.ends.values())

    def keys(self) -> tuple[str, ...]:
        """Return the key of all that came back, and then those of its neighbours."""
        if not self.is_known:
            return ()
        names = sorted(self.failed)
        ways = itertools.product(*(self.failed[name][WHOLE] for name in names))
        found = list(itertools.islice(ways, MOST_KEYS + 1))
        return tuple(_key(names, one) for one in found) if len(found) <= MOST_KEYS else ()


def _key(names: Sequence[str], found: Sequence[str]) -> str:
    text = " ".join(f"{name}={one}" for name, one in zip(names, found, strict=True))
    return hashlib.sha256(text.encode()).hexdigest()


def _of(calls: Sequence[Called], with_aspects: bool) -> Digests:
    parts: Iterator[Part] = (part for one in calls for part in ((one.name, None), *one.parts))
    found = {WHOLE: digests(parts, WHOLE)}
    if with_aspects and len(calls) <= MOST_SEEN:
        found |= aspects.seen(calls[-1], f"{len(calls)}")
        found |= _entries(calls) | _ended(calls)
    return found


def _ended(calls: Sequence[Called]) -> Digests:
    """Return the last call's number and whether it raised, and how many entries came back."""
    place, (kind, numbers), found = f"{len(calls)}", calls[-1].parts[0], Digests()
    if kind.startswith("'! NotImplementedError"):
        return {}  # it is not written yet
    if kind.startswith("'! "):
        found[RAISED] = (place,)
    elif len(calls[-1].parts) == 1 and numbers is not None and numbers.ndim == 1:
        count = np.count_nonzero(numbers) if kind.startswith("truth") else numbers.size
        found[f"{COUNT}{place} {kind[0]}"] = (str(count),)
    if any(one is not None and np.any(one != np.round(one)) for _, one in calls[-1].parts):
        found[FRACTIONS] = (place,)
    return {**found, CALLS: (place,)}


def _entries(calls: Sequence[Called]) -> Digests:
    """Return the digests of what the last call found: numbers in a row, or what is true."""
    parts = calls[-1].parts
    numbers = parts[0][1] if len(parts) == 1 else None
    if numbers is None or not 1 <= numbers.ndim <= 2 or numbers.size > MOST_ENTRIES:
        return {}
    if parts[0][0].startswith("truth"):
        numbers = np.flatnonzero(numbers).astype(float)
    if numbers.ndim != 1 or len(np.unique(numbers)) != len(numbers):
        return {}
    name = f"{ENTRIES}{len(calls)}"
    found = [aspects.near([("", one)], name) for one in numbers[:, None]]
    around = tuple(itertools.chain.from_iterable(found))
    return {name: tuple(one[0] for one in found), f"{AROUND}{len(calls)}": around}


def seen_by(trace: Trace, *, with_aspects: bool = True) -> Seen:
    """Return what a test cell saw that failed; the traits of its last call are aspects too."""
    found = _of(trace.calls, with_aspects) if trace.calls else {}
    end = traits.of_call(trace.calls[-1]) if with_aspects and trace.calls else ()
    return Seen(found, not trace.raised, trace.is_real, tuple(end))


def passed_by(trace: Trace) -> Mapping[str, int]:
    """Return by trait how many calls of a test cell have it."""
    return Counter(trait for call in trace.calls for trait in traits.of_call(call))


def of_beginnings(trace: Trace, *, with_aspects: bool) -> Mapping[str, frozenset[str]]:
    """Return by aspect the digests after each call of a test cell; or of all that came alone."""
    found: dict[str, set[str]] = {}
    for number in range(1, len(trace.calls) + 1):
        for aspect, some in _of(trace.calls[:number], with_aspects).items():
            found.setdefault(aspect, set()).update(some)
    return {aspect: frozenset(some) for aspect, some in found.items()}
