"""What is particular to the calls where an answer goes wrong, and only there.

No value is compared but for words and truths. A trait of a call, such as that an argument holds
integers, says where the slip is if each failed case ended at a call that has it, and no case that
was passed has such a call. What came in is the test's own, so student code cannot change it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence

import numpy as np

from robust_slam_autograder.misconceptions.prints import Called

FEWEST_PASSED = 4
"""Calls that were accepted, without which nothing can be said of the others."""
MOST_ARGUMENTS = 6
MANY, LARGE = 20, 10.0
"""Entries of a long row, and a number that is large."""
MOST_AT_ONCE = 2
"""Traits of one argument that are named together; more of them say nothing."""

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
}
_LESS: Mapping[str, frozenset[str]] = {
    "not 1": frozenset({"below 1", "zero", "negative", "large"}),
    "integers": frozenset({"list", "zero"}),
    "given": frozenset(_SENTENCES) - {"given"},
    "table": frozenset({"list"}),
}
"""By trait those of the same argument that need not be named beside it."""
_BY_CHANCE = frozenset({"zero", "negative", "below 1", "many", "single"})
"""What a start or a limit may be in one case and no other without a meaning; the first argument
is what the function is about."""
_OF, _SAYS, _TEXT = "of ", "says ", "text:"


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
    for place, value in given.items():
        kinds = frozenset(_kinds(value)) - (frozenset() if place == 0 else _BY_CHANCE)
        found |= {f"{kind} {place}" for kind in kinds}
        if value is not None:
            found.add(f"given {place}")
    return frozenset(found)


def shown(found: Iterable[str], texts: Sequence[str]) -> Iterator[str]:
    """Yield the traits that hold no word but those of some texts."""
    for trait in found:
        word = trait.rpartition(" ")[0].partition(_TEXT)[2]
        if not word or any(word in text for text in texts):
            yield trait


def _kinds(value: object) -> Iterable[str]:
    if isinstance(value, str):
        return {f"{_TEXT}{value}"} if value.isidentifier() else ()
    if callable(value) or value is None or isinstance(value, dict):
        return ()
    try:
        array = np.asarray(value)
    except ValueError:  # rows of different lengths
        return ()
    if array.dtype.kind == "b":
        return () if array.any() else ("none true",)
    if array.dtype.kind not in "iuf":
        return ()
    is_one = array.ndim == 0
    kinds = {
        "integers": array.dtype.kind in "iu" and array.size > 0,
        "alone": is_one,
        "table": array.ndim >= 2,
        "list": isinstance(value, list | tuple),
        "zero": (is_one or array.dtype.kind == "f") and bool(np.any(array == 0)),
        "negative": bool(np.any(array < 0)),
        "not 1": is_one and array != 1,
        "below 1": is_one and 0 < array < 1,
        "large": bool(np.any(np.abs(array) > LARGE)),
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
) -> str:
    """Return what goes on after "It looks as if"; empty where no trait says where it goes wrong.

    Args:
        ends: of each failed case, the traits of its last call.
        passed: by trait, how many calls of passed cases have it.
        arguments: the names of the function's arguments.
        words: what the solution says, where it says words or truths.
    """
    shared = frozenset.intersection(*map(frozenset, ends))
    return _place(shared, passed, arguments) or _word(shared, passed, words)


def _word(shared: Collection[str], passed: Mapping[str, int], words: Collection[str]) -> str:
    word = next((one for one in words if f"{_SAYS}{one}" in shared), "")
    if not word or len(words) < 2:
        return ""
    others = [one for one in passed if one.startswith(_SAYS) and one != f"{_SAYS}{word}"]
    how = "comes back where another answer belongs" if others else "is the only answer"
    return f"“{word}” {how}"


def _place(shared: Collection[str], passed: Mapping[str, int], arguments: Sequence[str]) -> str:
    (function,) = [one for one in shared if one.startswith(_OF)] or [""]
    if passed.get(function, 0) < FEWEST_PASSED:
        others = sum(times for one, times in passed.items() if one.startswith(_OF))
        is_other = function and not passed.get(function) and others >= FEWEST_PASSED
        return f"all is right but what `{function[3:]}` returns" if is_other else ""
    only = {one for one in shared if not passed.get(one) and not one.startswith(_SAYS)}
    for one in list(only):
        kind, _, place = one.rpartition(" ")
        only -= {f"{less} {place}" for less in _LESS.get(kind, ())}
    places = {one.rpartition(" ")[2] for one in only}
    if len(places) != 1 or len(only) > MOST_AT_ONCE:
        return ""
    return "all is right but where " + " and ".join(_said(one, arguments) for one in sorted(only))


def _said(trait: str, arguments: Sequence[str]) -> str:
    kind, _, place = trait.rpartition(" ")
    name = f"`{place}`"
    if place.isdigit():
        name = f"`{arguments[int(place)]}`" if int(place) < len(arguments) else "an argument"
    if kind.startswith(_TEXT):
        return f"{name} is “{kind.removeprefix(_TEXT)}”"
    return _SENTENCES[kind].format(name)
