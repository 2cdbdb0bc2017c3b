"""What of a wrong answer is right: seen in one way it returns what it should.

So it is known where the slip is, though not which one: in the second part, in the signs, where an
argument is negative. An aspect counts where it leaves numbers to compare.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np

from robust_slam_autograder.misconceptions.prints import Called, Part, digests, parts_of

View = Callable[[Called], list[Part] | None]
"""What an aspect leaves of a call; None where it has none."""
FEWEST = 1
"""Numbers, neither 0 nor 1, that must be left."""
FEWEST_ALIKE = 3
"""Numbers that must be right up to what they have in common."""
FEWEST_SHIFTED = 2
MOST_ARGUMENTS = 4


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
    return kind.partition(" ")[0]


def _part(which: int) -> View:
    """See one part of a tuple alone."""

    def view(call: Called) -> list[Part] | None:
        rows = [kind for kind, _ in call.parts[:1] if kind.startswith("row")]
        rest = call.parts[1:]
        flat = all(not kind.startswith(("row", "dict")) for kind, _ in rest)
        return [rest[which]] if rows and flat and len(rest) >= 2 else None

    return view


def _where(which: int, compare: Callable[[np.ndarray], np.ndarray]) -> View:
    """See the entries where an argument of the same shape is as it is compared to be."""

    def view(call: Called) -> list[Part] | None:
        argument = _argument(call, which)
        if argument is None or not argument.ndim:
            return None
        left: list[Part] = []
        for kind, numbers in call.parts:
            if numbers is not None and numbers.shape != argument.shape:
                return None
            left.append((kind, None if numbers is None else numbers[compare(argument)]))
        # Of a pose's three entries none stands for the same entry of an answer.
        return left if np.sum(compare(argument)) >= FEWEST_ALIKE else None

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
    if numbers.size < FEWEST_SHIFTED:
        raise ValueError("too few")
    first = numbers[:1] if numbers.ndim > 1 else numbers.flat[0]
    return np.asarray(np.subtract(numbers, first))


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
        if numbers.ndim < 1 or len(numbers) < FEWEST_ALIKE:
            raise ValueError("too few")
        return numbers[which]

    return rest


_OF_VALUES: Mapping[str, View] = {
    "all is right but the shape of what comes back": _numbers(np.ravel, shape=False),
    "all is right but for signs": _numbers(np.abs),
    "all is right but for the order": _numbers(lambda x: np.sort(x, axis=None)),
    "the first part of what comes back is right, and what follows is not": _part(0),
    "the last part of what comes back is right, and what comes before is not": _part(-1),
    "the second part of what comes back is right, and the others are not": _part(1),
    "all is right but for a common shift": _numbers(_shifted),
    "all is right but for a common factor": _numbers(_unit),
    "all is right but on the diagonal": _numbers(_off_diagonal),
    "the diagonal is right, and the entries beside it are not": _numbers(_diagonal),
    "all is right but the first entry": _numbers(_but(slice(1, None))),
    "all is right but the last entry": _numbers(_but(slice(None, -1))),
}
_OF_ARGUMENTS: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {
    "all is right but where {} is 0": lambda x: x != 0,
    "all is right but where {} is negative": lambda x: x >= 0,
    "all is right but where {} is positive": lambda x: x <= 0,
}


def seen(calls: Sequence[Called], salt: str) -> dict[str, tuple[str, ...]]:
    """Return by aspect the digests of what the calls of a test cell returned.

    An aspect is left out where it leaves a call nothing that could be compared.
    """
    views = {name: [view] for name, view in _OF_VALUES.items()}
    for n in range(min(MOST_ARGUMENTS, max((len(call.args) for call in calls), default=0))):
        for name, compare in _OF_ARGUMENTS.items():
            views[f"{name} {n}"] = [_where(n, compare)]
    found = {}
    for name, (view,) in views.items():
        parts = _left(calls, view)
        if parts is not None:
            found[name] = digests(parts, f"{salt} {name}")
    return found


def _left(calls: Sequence[Called], view: View) -> list[Part] | None:
    parts: list[Part] = []
    left: list[Part] | None = []
    try:
        for call in calls:
            left = view(call)
            if left is None:
                return None
            parts += [(call.name, None), *left]
    except (ValueError, TypeError, IndexError, FloatingPointError):
        return None
    last = [numbers for _, numbers in left or () if numbers is not None]
    telling = sum(int(np.sum((one != 0) & (one != 1) & np.isfinite(one))) for one in last)
    return parts if telling >= FEWEST else None


def sentence(name: str, arguments: Sequence[str]) -> str:
    """Return what goes on after "It looks as if", with the argument's name in its place."""
    plain, _, number = name.rpartition(" ")
    if not number.isdigit():
        return name
    argument = arguments[int(number)] if int(number) < len(arguments) else "an argument"
    return plain.format(f"`{argument}`")


def names(arguments: int) -> Iterator[str]:
    """Yield the aspects in the order in which they count."""
    for n in range(min(arguments, MOST_ARGUMENTS)):
        yield from (f"{name} {n}" for name in _OF_ARGUMENTS)
    yield from _OF_VALUES
