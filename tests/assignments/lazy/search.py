"""Looks for lazy answers that pass a case with hidden checks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from robust_slam_autograder.grading.marking import PUBLIC_SEED
from robust_slam_autograder.reading.assignment import Case

from tests.assignments.lazy.guesses import Guess, guesses
from tests.assignments.lazy.memory import Call, Key, Raised, Recorder, give, key_of, named
from tests.assignments.reference import Reference, quiet

OTHER_SEEDS = (101, 102, 103)
"""What the reference returns under two of these, or twice under one, is a constant to guess."""
MOST_CONSTANTS = 40

Path = tuple[Any, ...]
"""Where a part of an answer stands: indexes of tuples and keys of dicts, from the outside in."""
WHOLE: Path = ()


@dataclass(frozen=True)
class Earned:
    """A case with hidden checks that lazy answers pass."""

    case: Case
    how: str
    """The lazy answer of each function and part, or that they are known by heart."""


def earned(solutions: Reference, seed: int, *, thorough: bool = True) -> list[Earned]:
    """The cases of an assignment that lazy answers pass under a seed."""
    return list(_Search(solutions, seed, thorough).earned())


@dataclass(frozen=True)
class _Search:
    reference: Reference
    seed: int
    thorough: bool

    def earned(self) -> Iterator[Earned]:
        for case in self.reference.assignment.cases:
            if case.has_hidden and (how := self._passes(case)) is not None:
                yield Earned(case, how)

    def _passes(self, case: Case) -> str | None:
        """How each function that a case calls may be lazy; None where one may not."""
        recorders = self._recorders()
        self.reference.run(case, self.seed, recorders)
        found = []
        for name, recorder in recorders.items():
            how = _Function(self, case, name, recorder, self._by_heart[name]).passes()
            if how is None:
                return None
            found += [f"{name} {how}"] if how else []
        return "; ".join(found) or "by heart"

    def _recorders(self) -> dict[str, Recorder]:
        return {name: Recorder(item) for name, item in self.reference.functions.items()}

    @cached_property
    def _by_heart(self) -> dict[str, dict[Key, Call]]:
        """The calls of all visible checks, by function."""
        recorders = self._recorders()
        for case in self.reference.assignment.cases:
            for seed in (PUBLIC_SEED, self.seed):
                self.reference.run_visible(case, seed, recorders)
        return {name: recorder.calls for name, recorder in recorders.items()}

    @cached_property
    def constants(self) -> dict[tuple[str, Path], list[Any]]:
        """Values that the reference returns again and again, the most frequent first."""
        counts: Counter[tuple[str, Path, Key]] = Counter()
        values: dict[tuple[str, Path, Key], Any] = {}
        for seed in OTHER_SEEDS:
            recorders = self._recorders()
            for case in self.reference.assignment.cases:
                self.reference.run(case, seed, recorders)
            for name, path, value in _returned(recorders):
                values.setdefault(key := (name, path, _value_key(value)), value)
                counts[key] += 1
        found: dict[tuple[str, Path], list[Any]] = {}
        for key, count in counts.most_common():
            known = found.setdefault(key[:2], [])
            if count > 1 and len(known) < MOST_CONSTANTS:
                known.append(values[key])
        return found


@dataclass(frozen=True)
class _Function:
    """One function that a case calls, while the others are the reference's."""

    search: _Search
    case: Case
    name: str
    recorder: Recorder
    """The reference's function, with the calls of this case."""
    by_heart: Mapping[Key, Call]
    """The calls of the visible checks."""

    @cached_property
    def _calls(self) -> list[Call]:
        return [call for key, call in self.recorder.calls.items() if key not in self.by_heart]

    def passes(self) -> str | None:
        """How it may be lazy: at once in all that it returns, or part by part; "" if by heart."""
        if not self._calls:
            return ""
        values = [call.result for call in self._calls if not isinstance(call.result, Raised)]
        whole = self._first(WHOLE)
        if whole is not None or not values or not all(map(paths, values)):
            return whole
        found = []
        for path in sorted({path for value in values for path in paths(value)}, key=str):
            if (how := self._first(path)) is None:
                return None
            found.append(f"{list(path)} {how}")
        return ", ".join(found)

    def _first(self, path: Path) -> str | None:
        """The name of the first lazy answer that passes in one part of what it returns."""
        known = self.search.constants.get((self.name, path), [])
        tried = guesses(known, self._calls[0].given, thorough=self.search.thorough)
        different = _different(tried, path, self._calls)
        return next((guess.name for guess in different if self._is_enough(path, guess)), None)

    @cached_property
    def _right(self) -> Callable[..., Any]:
        """Gives the right answers again: without effects if the case passes so, which is quick."""
        replay = self.recorder.replay
        return replay if self._case_passes(replay) else self.recorder.recall

    def _is_enough(self, path: Path, guess: Guess) -> bool:
        def student(*args: Any, **kwargs: Any) -> Any:
            known = self.by_heart.get(key_of((args, kwargs)))
            if known:
                return give(deepcopy(known.result))
            return _with_guess(self._right, path, guess, args, kwargs)

        return self._case_passes(student)

    def _case_passes(self, student: Callable[..., Any]) -> bool:
        try:
            self.search.reference.run(self.case, self.search.seed, {self.name: student})
        except Exception:  # a test fails by raising, whatever it raises
            return False
        return True


def _with_guess(
    right: Callable[..., Any],
    path: Path,
    guess: Guess,
    args: Sequence[Any],
    kwargs: dict[str, Any],
) -> Any:
    """The right answer with a guess in one part; the guess alone where there is none."""
    given = named(args, kwargs)
    try:
        answer = right(*args, **kwargs)
    except Exception:
        return guess.answer(given, None)
    return with_part(answer, path, guess.answer(given, part_of(answer, path)))


def paths(value: Any) -> list[Path]:
    """Where the parts of an answer stand, to the innermost; none where it has no parts."""
    if isinstance(value, tuple):
        parts = list(enumerate(value))
    elif isinstance(value, dict):
        parts = list(value.items())
    else:
        return []
    return [(place, *rest) for place, part in parts for rest in paths(part) or [WHOLE]]


def part_of(value: Any, path: Path) -> Any:
    """The part of an answer that stands there."""
    for place in path:
        value = value[place]
    return value


def with_part(value: Any, path: Path, new: Any) -> Any:
    """The answer with another value in that part."""
    if not path:
        return new
    place, *rest = path
    inner = with_part(value[place], tuple(rest), new)
    if isinstance(value, tuple):
        return (*value[:place], inner, *value[place + 1 :])
    return {**value, place: inner}


def _different(guesses: Iterable[Guess], path: Path, calls: list[Call]) -> Iterator[Guess]:
    """The guesses without those that say in all these calls what an earlier one says."""
    seen: set[Key] = set()
    for guess in guesses:
        key = tuple(_value_key(_answer(guess, path, call)) for call in calls)
        if key not in seen:
            seen.add(key)
            yield guess


def _answer(guess: Guess, path: Path, call: Call) -> Any:
    right = None if isinstance(call.result, Raised) else part_of(call.result, path)
    try:
        with quiet():
            return guess.answer(call.given, right)
    except Exception as error:
        return Raised(error)


def _returned(recorders: Mapping[str, Recorder]) -> Iterable[tuple[str, Path, Any]]:
    for name, recorder in recorders.items():
        for call in recorder.calls.values():
            inside = [] if isinstance(call.result, Raised) else paths(call.result)
            for path in {WHOLE, *inside}:
                yield name, path, part_of(call.result, path)


def _value_key(value: Any) -> Key:
    return ("raised", type(value.error).__name__) if isinstance(value, Raised) else key_of(value)
