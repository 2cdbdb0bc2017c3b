"""What of a wrong answer is right: seen in one way it returns what it should.

So it is known where the slip is, though not which one: in the second part, in the signs, where an
argument is negative. An aspect counts where it leaves numbers to compare.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from robust_slam_autograder.misconceptions.facts import LIMITS
from robust_slam_autograder.misconceptions.prints import Called, Part, digests, parts_of

View = Callable[[Called], list[Part] | None]
"""What an aspect leaves of a call; None where it has none, and nothing where nothing is in it."""
Compare = Callable[[np.ndarray, Any], np.ndarray]
FEWEST_ALIKE = 3
"""Numbers that must be right up to what they have in common, or that must be left of a row."""
MOST_ARGUMENTS = 5
MOST_PARTS = 5
"""Of a tuple, that are looked at one by one."""


def _numbers(change: Callable[[np.ndarray], np.ndarray], *, shape: bool = True) -> View:
    """See the numbers of a call through a change of each part, and its shape unless not wanted."""

    def view(call: Called) -> list[Part] | None:
        if all(numbers is None for _, numbers in call.parts):
            return None
        return [
            (
                kind if shape else _rank(kind),
                None if numbers is None else np.asarray(change(numbers), dtype=float),
            )
            for kind, numbers in call.parts
        ]

    return view


def _rank(kind: str) -> str:
    """Return a kind without the shape, which an aspect may change."""
    return kind.partition(" (")[0]


def _pieces(parts: Sequence[Part]) -> Iterator[tuple[str, Sequence[Part]]]:
    """Yield the parts of a tuple, the entries of a dict and the columns of a table, by name."""
    (kind, numbers), place = parts[0], 1
    if kind.startswith("row"):
        for n in range(min(MOST_PARTS, int(kind.split()[1]))):
            end = _after(parts, place)
            piece, place = parts[place:end], end
            yield f"the {_PLACES[n]}{_OF_TUPLE}", piece
            if piece and piece[0][0].startswith("dict"):
                yield from _pieces(piece)
    elif kind.startswith("dict"):
        for _ in range(min(MOST_PARTS, int(kind.split()[1]))):
            end = _after(parts, place + 1)
            name = parts[place][0].removeprefix("key ").strip("'")
            yield f"`{name}`", parts[place + 1 : end]
            place = end
    elif numbers is not None and numbers.ndim >= 2 and 2 <= numbers.shape[-1] <= MOST_PARTS:
        for n in range(numbers.shape[-1]):
            yield f"the {_PLACES[n]} column", [(_rank(kind), numbers[..., n])]


def _after(parts: Sequence[Part], place: int) -> int:
    """Return where the value ends that begins at a place, with all that is nested in it."""
    kind, _, count = parts[place][0].partition(" ") if place < len(parts) else ("", "", "")
    place += 1
    nested = {"row": 1, "dict": 2}.get(kind, 0) * (int(count) if kind in ("row", "dict") else 0)
    for _ in range(nested):
        place = _after(parts, place)
    return place


def _where(which: int, compare: Compare, other: int | None = None) -> View:
    """See the entries where an argument of the same shape is as it is compared to be."""

    def view(call: Called) -> list[Part] | None:
        argument = _argument(call, which)
        limit = None if other is None else _argument(call, other)
        is_matrix = argument is not None and argument.ndim == 2 and len(set(argument.shape)) == 1
        if argument is None or is_matrix or (limit is not None and limit.ndim):
            return None  # of a matrix no entry stands for the answer's at the same place
        left: list[Part] = []
        meant = np.asarray(compare(np.abs(argument) if limit is not None else argument, limit))
        for kind, numbers in call.parts:
            if numbers is not None and numbers.shape != argument.shape:
                return None
            left.append((kind, None if numbers is None else numbers[meant]))
        if not meant.any():
            return []
        # Of a pose's three entries none stands for the same entry of an answer.
        return left if FEWEST_ALIKE <= np.sum(meant) < meant.size else None

    return view


def _argument(call: Called, which: int) -> np.ndarray | None:
    if which >= len(call.args) or callable(call.args[which]):
        return None
    parts = list(parts_of(call.args[which]))
    return parts[0][1] if len(parts) == 1 else None


def _unit(numbers: np.ndarray) -> np.ndarray:
    if numbers.size < FEWEST_ALIKE or not np.ptp(numbers):
        raise ValueError("too few")  # a factor or a shift of few numbers says nothing
    size = float(np.linalg.norm(numbers) * np.sign(numbers.flat[np.argmax(np.abs(numbers))]))
    return np.asarray(np.divide(numbers, size))


def _shifted(numbers: np.ndarray) -> np.ndarray:
    if numbers.size < FEWEST_ALIKE or not np.ptp(numbers):
        raise ValueError("too few")
    first = numbers[:1] if numbers.ndim > 1 else numbers.flat[0]
    return np.asarray(np.subtract(numbers, first))


def _turns(numbers: np.ndarray) -> np.ndarray:
    finite = np.where(np.isfinite(numbers), numbers, 0.0)
    return np.stack([np.cos(finite), np.sin(finite)])


def _turned(call: Called) -> list[Part] | None:
    """See the same where an angle may have a turn too many."""
    has_turn = any(np.any(np.abs(one) > np.pi) for _, one in call.parts if one is not None)
    return _OF_VALUES["turns"](call) if has_turn else None


def _as_numbers(call: Called) -> list[Part] | None:
    """See truths as numbers, where there are some."""
    parts = [(kind.replace("truth", "number"), numbers) for kind, numbers in call.parts]
    return parts if _bare(call) is None else None


def _bare(call: Called) -> list[Part] | None:
    """See what holds no truths."""
    return None if any(kind.startswith("truth") for kind, _ in call.parts) else list(call.parts)


def _members(call: Called) -> list[Part] | None:
    """See the places of what is true in a mask."""
    (kind, numbers), *rest = call.parts
    if rest or numbers is None or numbers.ndim != 1 or not kind.startswith("truth"):
        return None
    places = np.flatnonzero(numbers).astype(float)
    return [(f"number {places.shape}", places)]


def _off_diagonal(numbers: np.ndarray) -> np.ndarray:
    is_square = numbers.ndim == 2 and numbers.shape[0] == numbers.shape[1] >= 2
    if not is_square or not np.allclose(numbers, numbers.T):
        raise ValueError("no symmetric matrix")
    return numbers[~np.eye(len(numbers), dtype=bool)]


def _diagonal(numbers: np.ndarray) -> np.ndarray:
    _off_diagonal(numbers)
    return np.diag(numbers)


def _but(which: slice) -> Callable[[np.ndarray], np.ndarray]:
    def rest(numbers: np.ndarray) -> np.ndarray:
        if numbers.ndim < 1 or len(numbers) < 2:
            raise ValueError("too few")
        return numbers[which]

    return rest


def _alone(view: View) -> View:
    """See an answer of one part only."""
    return lambda call: view(call) if len(call.parts) == 1 else None


_OF_VALUES: Mapping[str, View] = {
    "plain": _numbers(np.asarray),
    "shape": _numbers(np.ravel, shape=False),
    "size": _numbers(np.abs),
    "turns": _numbers(_turns),
    "turned": _turned,
    "numbers": _as_numbers,
    "bare": _bare,
    "members": _members,
    "order": _numbers(lambda x: np.sort(x, axis=None)),
    "shift": _numbers(_shifted),
    "factor": _numbers(_unit),
    "beside": _numbers(_off_diagonal),
    "diagonal": _numbers(_diagonal),
    "rest": _alone(_numbers(_but(slice(1, None)), shape=False)),
    "head": _alone(_numbers(_but(slice(None, -1)), shape=False)),
    "all": _alone(_numbers(np.asarray, shape=False)),
}
_COMMON = frozenset({"shift", "factor"})
"""Aspects that take away what all numbers have in common."""
_KINDS = frozenset({"numbers", "bare"})
"""Aspects that say something of 0 and 1 too."""
_SENTENCES: Mapping[str, tuple[str, str]] = {
    "all is right but the shape of what comes back": ("shape", "shape"),
    "all is right but for signs": ("size", "size"),
    "all is right but for whole turns of 2π": ("turned", "turns"),
    "numbers come back where truth values belong": ("bare", "numbers"),
    "truth values come back where numbers belong": ("numbers", "bare"),
    "a mask comes back where indices belong": ("members", "plain"),
    "indices come back where a mask belongs": ("plain", "members"),
    "all is right but for the order": ("order", "order"),
    "all is right but for a common shift": ("shift", "shift"),
    "all is right but for a common factor": ("factor", "factor"),
    "all is right but on the diagonal": ("beside", "beside"),
    "the diagonal is right, and the entries beside it are not": ("diagonal", "diagonal"),
    "the first entry is left out, and all others come back": ("all", "rest"),
    "the last entry is left out, and all others come back": ("all", "head"),
    "one entry too many comes first, and those that follow are right": ("rest", "all"),
    "one entry too many comes last, and those before it are right": ("head", "all"),
    "each entry stands one place too early": ("head", "rest"),
    "each entry stands one place too late": ("rest", "head"),
    "all is right but the first entry": ("rest", "rest"),
    "all is right but the last entry": ("head", "head"),
}
"""By sentence what of the answer is the same as what of the solution."""
_FAR = "only entries where {} is far from 0 are wrong"
_CLOSE = "only entries where {} is near 0 are wrong"
_OF_ARGUMENTS: Mapping[str, Compare] = {
    "only entries where {} is 0 are wrong": lambda x, _: x != 0,
    "only entries where {} is negative are wrong": lambda x, _: x >= 0,
    _FAR: lambda x, _: abs(x) <= np.median(abs(x)),
    _CLOSE: lambda x, _: abs(x) >= np.median(abs(x)),
}
_OF_PAIRS: Mapping[str, Compare] = {
    "only entries where the size of {} is {} are wrong": lambda x, c: np.abs(x) != c,
    "only entries where the size of {} is above {} are wrong": lambda x, c: np.abs(x) < c,
    "only entries where the size of {} is below {} are wrong": lambda x, c: np.abs(x) > c,
}
"""Of an argument's sizes and another one that is a number alone."""
_PLACES = ("first", "second", "third", "fourth", "fifth")
_NEAR, _PART, _OF_TUPLE = "near", "piece ", " part"
_NEARLY = "all is nearly right, and not as exact as it should be"
_RIGHT_BUT = "all that comes back where a test fails is right but"
_NOTHING = ("nothing",)
SCALE = 10.0
"""Numbers below one over this are nearly the same as 0."""
FINE = 2e-4
"""Width of a cell where values are right: a solver's are, up to its tolerance."""
COARSE = 0.02
"""Width of a cell where values are nearly the same, by the root of how many there are."""


def seen(call: Called, salt: str) -> dict[str, tuple[str, ...]]:
    """Return by aspect the digests of what a call returned.

    An aspect is left out where it leaves nothing that could be compared.
    """
    count = min(MOST_ARGUMENTS, len(call.args))
    views: dict[str, View] = dict(_OF_VALUES)
    for n in range(count):
        views |= {f"{name} {n}": _where(n, one) for name, one in _OF_ARGUMENTS.items()}
        for m in range(count):
            if m != n:
                views |= {f"{name} {n} {m}": _where(n, one, m) for name, one in _OF_PAIRS.items()}
    found = {}
    for name, view in views.items():
        try:
            parts = view(call)
        except (ValueError, TypeError, IndexError, FloatingPointError):
            continue
        is_free = name in _KINDS or (
            name not in _OF_VALUES and not name.startswith((_FAR, _CLOSE))
        )
        if parts is not None and (is_free or _telling(parts)):
            found[name] = near(parts, f"{salt} {call.name}") if parts else _NOTHING
    for name, piece in _pieces(call.parts):
        found[f"{_PART}{name}"] = near(piece, f"{salt} {call.name} {name}")
    numbers = sum(one.size for _, one in call.parts if one is not None)
    if numbers >= FEWEST_ALIKE and _telling(call.parts, 1 / SCALE):
        found[_NEAR] = near(call.parts, f"{salt} {_NEAR}", COARSE * numbers**0.5)
    return found


def near(parts: Sequence[Part], salt: str, cell: float = FINE) -> tuple[str, ...]:
    """Return digests of parts that others have in common which differ by less than half a cell."""
    return digests(parts, salt, cell, 0.5, SCALE)


def _telling(parts: Sequence[Part], least: float = 50 * FINE) -> bool:
    """Tell whether a number is left that is neither 0 nor 1, and so hardly right by chance."""
    numbers = [one for _, one in parts if one is not None]
    return any(np.any((np.abs(one) > least) & (one != 1) & np.isfinite(one)) for one in numbers)


Digests = Mapping[str, Collection[str]]
Cases = Sequence[tuple[Digests, Digests]]
"""Of each failed case the digests of its last call, and those of the solution's."""


def _same(cases: Cases, mine: str, right: str) -> bool:
    shared = [set(one.get(mine, ())) & set(other.get(right, ())) for one, other in cases]
    return all(shared) and any(one != {*_NOTHING} for one in shared)


def told(cases: Cases, arguments: Sequence[str]) -> str:
    """Return what goes on after "It looks as if"; empty where nothing is right in all cases.

    Args:
        cases: those that failed by a value.
        arguments: the names of the function's arguments.
    """
    same = functools.partial(_same, cases)
    if same("plain", "plain"):
        return _NEARLY
    for sentence, (mine, right) in _SENTENCES.items():
        if same(mine, right):
            # What has not converged differs by nearly one factor too.
            return _NEARLY if mine in _COMMON and same(_NEAR, _NEAR) else sentence
    shown = [f"`{name}`" for name in arguments[:MOST_ARGUMENTS]]
    for n, name in enumerate(shown):
        for m, other in enumerate(shown):
            for sentence in _OF_PAIRS if arguments[m] not in LIMITS else ():
                if same(key := f"{sentence} {n} {m}", key):
                    return sentence.format(name, other)
        for sentence in _OF_ARGUMENTS:
            if same(key := f"{sentence} {n}", key):
                return sentence.format(name)
    return ""


def told_at_last(cases: Cases) -> str:
    """Say less: which piece is not right, or that all is nearly right.

    A piece has the solution's own name, for a student may call one by what a hidden test says.
    """
    if not cases:
        return ""
    names = set.intersection(*({key for key in one if key.startswith(_PART)} for _, one in cases))
    right = sorted(key.removeprefix(_PART) for key in names if _same(cases, key, key))
    wrong = [name for key in names if (name := key.removeprefix(_PART)) not in right]
    smallest = [name for name in wrong if not name.endswith(_OF_TUPLE)]
    parts = [[one for one in some if one.endswith(_OF_TUPLE)] for some in (right, wrong)]
    if right and len(wrong) - len(smallest) <= 1 and 1 in (len(smallest), len(wrong)):
        return f"{_RIGHT_BUT} {(smallest or wrong)[0]}"
    # Of a dict that holds what is drawn a count is right, and the rest may be as well.
    if all(parts):
        return f"{_RIGHT_BUT} {' and '.join(sorted(parts[1]))}"
    return _NEARLY if _same(cases, _NEAR, _NEAR) else ""
