"""What is particular to the calls where an answer goes wrong, and only there.

No value is compared but for words and truths. A trait of a call, such as that an argument holds
integers, says where the slip is if each failed case ended at a call that has it, and no case that
was passed has such a call. What came in is the test's own, so student code cannot change it.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from robust_slam_autograder.misconceptions.prints import Called

FEWEST_PASSED = 4
"""Calls that were accepted, without which nothing can be said of the others."""
MOST_ARGUMENTS = 6
MANY, LARGE = 20, 10.0
"""Entries of a long row, and a number that is large."""
MOST_PLACES = 3
"""Arguments that have the same trait."""
MOST_AT_ONCE = 2
"""Traits that are named together; more of them say nothing."""

_SENTENCES: Mapping[str, str] = {
    "integers": "{} holds integers",
    "alone": "{} is a number alone",
    "table": "{} has more than one dimension",
    "list": "{} is a list",
    "zero": "{} is 0",
    "negative": "{} is negative",
    "not 1": "{} is not 1",
    "below 1": "{} is between 0 and 1",
    "large": "{} is large",
    "many": "{} has many entries",
    "single": "{} has one entry",
    "unequal": "the entries of {} differ",
    "given": "{} is given",
    "none true": "no entry of {} is true",
    "as many": "{} has as many entries as {}",
    "meets": "the size of an entry of {} is {}",
}
_RETURNED: Mapping[str, str] = {
    "nan": "NaN comes back",
    "inf": "an infinite number comes back",
    "negative": "a negative number comes back",
    "above 1": "a number above 1 comes back",
    "whole": "nothing but whole numbers comes back",
    "alike": "the same number comes back in each place",
    "skew": "a matrix comes back that is not symmetric",
    "same": "{} itself comes back",
    "one of": "one of the entries of {} comes back",
}
_LESS: Mapping[str, frozenset[str]] = {
    "alone": frozenset({"not 1"}),
    "not 1": frozenset({"below 1", "zero", "negative", "large"}),
    "integers": frozenset({"list", "zero"}),
    "given": frozenset(_SENTENCES) - {"given"},
    "table": frozenset({"list"}),
}
"""By trait those of the same argument that need not be named beside it."""
_BY_CHANCE = frozenset({"zero", "negative", "below 1"})
"""What a start or a limit may be in one case and no other without a meaning; the first argument
is what the function is about."""
_WEAK = frozenset({"as many", "many", "meets", "not 1", "single", "unequal"})
"""What need not be named beside other traits."""
_TESTS: Mapping[str, Callable[[np.ndarray], Any]] = {
    "nan": lambda x: np.isnan(x).any(),
    "inf": lambda x: np.isinf(x).any(),
    "negative": lambda x: (x < 0).any(),
    "above 1": lambda x: (x > 1).any(),
    "whole": lambda x: x.size > MOST_AT_ONCE and np.isfinite(x).all() and (x == np.round(x)).all(),
    "alike": lambda x: x.size > MOST_AT_ONCE and (x == x.flat[0]).all(),
    "skew": lambda x: x.ndim == 2 and x.shape[0] == x.shape[1] > 1 and not np.allclose(x, x.T),
}
_OF, _SAYS, _RETURNS, _TEXT = "of ", "says ", "returns ", "text:"
_FRACTIONS = "fractions"
_COPIES = (f"{_RETURNS}same", f"{_RETURNS}one of")
FEWEST_ALIKE = 2
"""Failed cases that must have returned what came in: one may do so by chance."""


def word_of(call: Called) -> str:
    """Return the word or truth that came back; empty where it was anything else."""
    if len(call.parts) != 1:
        return ""
    kind, numbers = call.parts[0]
    if kind.startswith("truth ()") and numbers is not None:
        return str(bool(numbers))
    return kind.strip("'") if kind.startswith("'") else ""


def of_call(call: Called) -> frozenset[str]:
    """Return the traits of what came in; each ends in the argument's number, or in its name."""
    given = dict(enumerate(call.args[:MOST_ARGUMENTS])) | dict(call.options)
    found = {f"{_OF}{call.name}"} | ({f"{_SAYS}{word}"} if (word := word_of(call)) else set())
    found.update(_of_pairs(given), (f"{_RETURNS}{one}" for one in _returned(call, given)))
    numbers = (one for _, one in call.parts if one is not None)
    if any(np.any(one != np.round(one)) for one in numbers):
        found.add(_FRACTIONS)
    for place, value in given.items():
        kinds = frozenset(_kinds(value)) - (frozenset() if place == 0 else _BY_CHANCE)
        found |= {f"{kind} {place}" for kind in kinds}
        if value is not None:
            found.add(f"given {place}")
    return frozenset(found)


def _of_pairs(given: Mapping[Any, object]) -> Iterator[str]:
    """Yield what two arguments have in common."""
    arrays = {place: one for place, value in given.items() if (one := _row(value)) is not None}
    for (n, one), (m, other) in itertools.permutations(arrays.items(), 2):
        if one.ndim and other.ndim:
            if str(n) < str(m) and 1 < len(one) == len(other):
                yield f"as many {n}&{m}"
        elif one.ndim and other != 1 and np.any(np.abs(one) == np.abs(other)):
            yield f"meets {n}&{m}"


def of_solution(calls: Sequence[Called]) -> frozenset[str]:
    """Return the words that a solution says, and what it returns at all, or as a rule."""
    words = {word for call in calls if (word := word_of(call))}
    back = Counter(one for call in calls for one in of_call(call) if one.startswith(_RETURNS))
    usual = {one for one, n in back.items() if 2 * n > len(calls) or not one.startswith(_COPIES)}
    return frozenset(words | usual)


def _returned(call: Called, given: Mapping[Any, object]) -> Iterator[str]:
    """Yield what came back in place of an answer."""
    found = (one for one in call.parts if not one[0].startswith("truth"))
    numbers = [one for _, one in found if one is not None]
    yield from (f"{kind} " for kind, test in _TESTS.items() if any(map(test, numbers)))
    if len(call.parts) != 1 or not numbers or np.all(np.isin(numbers[0], (-1, 0, 1))):
        return
    for place, value in given.items():
        array = _row(value)
        if array is not None and np.array_equal(array, numbers[0]):
            yield f"same {place}"
        elif array is not None and array.ndim and not numbers[0].ndim:
            yield from [f"one of {place}"] if np.any(array == numbers[0]) else ()


def _row(value: object, kinds: str = "iuf") -> np.ndarray | None:
    """Return a value as an array of these kinds of numbers, where it is one."""
    if value is None or callable(value) or isinstance(value, str | dict):
        return None
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        return None
    return array if array.dtype.kind in kinds else None


def _kinds(value: object) -> Iterable[str]:
    if isinstance(value, str):
        return {f"{_TEXT}{value}"} if value.isidentifier() else ()
    array = _row(value, "biuf")
    if array is None:
        return ()
    if array.dtype.kind == "b":
        return () if array.any() else ("none true",)
    is_one = array.ndim == 0
    kinds = {
        "integers": array.dtype.kind in "iu" and not is_one and array.size > 0,
        "alone": is_one,
        "table": array.ndim >= 2,
        "list": isinstance(value, list | tuple),
        # Of a row's entries the answer's own ones say where it goes wrong: see aspects.
        "zero": is_one and array == 0,
        "negative": is_one and array < 0,
        "not 1": is_one and array != 1,
        "below 1": is_one and 0 < array < 1,
        "large": is_one and abs(array) > LARGE,
        "many": not is_one and len(array) > MANY,
        "single": not is_one and array.size == 1,
        "unequal": array.ndim == 1 and array.size > 1 and bool(np.ptp(array)),
    }
    return [kind for kind, holds in kinds.items() if holds]


def told(
    ends: Iterable[Iterable[str]],
    passed: Mapping[str, int],
    arguments: Sequence[str],
    words: Collection[str] = (),
    *,
    has_cut: bool = True,
) -> str:
    """Return what goes on after "It looks as if"; empty where no trait says where it goes wrong.

    Args:
        ends: of each failed case, the traits of its last call.
        passed: by trait, how many calls of passed cases have it.
        arguments: the names of the function's arguments.
        words: what the solution says, where it says words or truths, and what it returns else.
        has_cut: whether the solution returns fractions where a case failed: they may be cut off.
    """
    cases = [frozenset(one) for one in ends]
    shared = frozenset.intersection(*cases)
    back = [one for one in shared if one.startswith(_RETURNS) and one not in words]
    if len(cases) < FEWEST_ALIKE:
        back = [one for one in back if not one.startswith(_COPIES)]
    found = (one.removeprefix(_RETURNS).rpartition(" ") for one in back)
    kinds = {kind: _RETURNED[kind].format(_name(place, arguments)) for kind, _, place in found}
    first = next((kinds[kind] for kind in ("nan", "inf", "same", "one of") if kind in kinds), "")
    first = first or _place(shared, passed, arguments, has_cut=has_cut)
    return first or next(iter(kinds.values()), "") or _word(shared, passed, words)


def _word(shared: Collection[str], passed: Mapping[str, int], words: Collection[str]) -> str:
    said = [one for one in words if not one.startswith(("!", _RETURNS))]
    word = next((one for one in said if f"{_SAYS}{one}" in shared), "")
    if not word or len(said) < 2:
        return ""
    others = [one for one in passed if one.startswith(_SAYS) and one != f"{_SAYS}{word}"]
    how = "comes back where another answer belongs" if others else "is the only answer"
    return f"“{word}” {how}"


def _place(
    shared: Collection[str],
    passed: Mapping[str, int],
    arguments: Sequence[str],
    *,
    has_cut: bool,
) -> str:
    (function,) = [one for one in shared if one.startswith(_OF)] or [""]
    if passed.get(function, 0) < FEWEST_PASSED:
        others = sum(times for one, times in passed.items() if one.startswith(_OF))
        is_other = function and not passed.get(function) and others >= FEWEST_PASSED
        return f"all is right but what `{function[3:]}` returns" if is_other else ""
    said = (_SAYS, _RETURNS, _FRACTIONS)
    only = {one for one in shared if not passed.get(one) and not one.startswith(said)}
    for one in list(only):
        kind, _, place = one.rpartition(" ")
        only -= {f"{less} {place}" for less in _LESS.get(kind, ())}
    strong = {one for one in only if one.rpartition(" ")[0] not in _WEAK}
    parted = [one.rpartition(" ") for one in strong or only]
    kinds = sorted({kind for kind, _, _ in parted})
    # Integers are to blame where fractions are cut off; else what they came with may be.
    is_raised = any(one.startswith(f"{_SAYS}!") for one in shared)
    if "integers" in kinds and (_FRACTIONS in shared or is_raised or not has_cut):
        return ""
    # Many slips show only where there is much to compute.
    if not kinds or kinds == ["many"] or len(kinds) > MOST_AT_ONCE:
        return ""
    places = {kind: sorted(p for k, _, p in parted if k == kind) for kind in kinds}
    if any(len(some) > MOST_PLACES for some in places.values()):
        return ""
    told = (_said(kind, place, arguments) for kind in kinds for place in places[kind])
    return f"only tests in which {' and '.join(told)} fail"


def _said(kind: str, place: str, arguments: Sequence[str]) -> str:
    names = [_name(one, arguments) for one in place.split("&")]
    if kind.startswith(_TEXT):
        return f"{names[0]} is “{kind.removeprefix(_TEXT)}”"
    return _SENTENCES[kind].format(*names)


def _name(place: str, arguments: Sequence[str]) -> str:
    if not place.isdigit():
        return f"`{place}`"
    return f"`{arguments[int(place)]}`" if int(place) < len(arguments) else "an argument"
