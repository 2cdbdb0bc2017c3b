"""What a wrong answer may be: one that was written down, a mutant, or a fact of the values.

Where several fit, the first kind counts: an author's sentence names the misconception, a mutant
says what was changed, and a fact says what the values are.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace

from robust_slam_autograder.misconceptions import slips, wider
from robust_slam_autograder.misconceptions.bench import Bench, Names
from robust_slam_autograder.misconceptions.slips import Slip
from robust_slam_autograder.reading.labelled import Answer

WRITTEN, OF_SOLUTION, OF_ANSWER, FACT = range(4)
"""Where a candidate comes from; the first that fits and says something counts."""
MOST_RIGHT = 4
"""Right answers of which mutants are made."""


@dataclass(frozen=True)
class Candidate:
    """One way to be wrong."""

    origin: int
    sentence: str
    """What goes on after "It looks as if"."""
    source: str = ""
    """Text of the solution cell; empty for a fact."""
    fact: str = ""
    """The number and the sentence of a fact."""
    about: str = field(default="", compare=False)
    """The argument that a fact is about, where it is not about what comes back."""
    slip: Slip | None = field(default=None, compare=False)

    def names(self, bench: Bench, exercise: str) -> Names:
        """Return what test cells see where this is the answer.

        Raises:
            Exception: what the cell raises.
        """
        if self.source:
            return bench.with_cell(exercise, self.source)
        found = bench.facts(exercise)[self.fact]
        return {**bench.names, **found.functions}


def candidates(bench: Bench, exercise: str, answers: Sequence[Answer]) -> Iterator[Candidate]:
    """Yield the ways to be wrong in an exercise, of which there are answers, right and wrong."""
    cell = bench.setting.assignment.owner(exercise)
    mine = [one for one in answers if one.exercise == exercise]
    for answer in mine:
        if not answer.is_right:
            yield Candidate(WRITTEN, answer.label, answer.source)
    for key, fact in bench.facts(exercise).items():
        yield Candidate(FACT, fact.sentence, fact=key, about=fact.argument)
    seen: set[str] = set()
    right = [one.source for one in mine if one.is_right][:MOST_RIGHT]
    for source in (bench.cells[cell], *right):
        origin = OF_ANSWER if seen else OF_SOLUTION
        for mutant in wider.mutants(source):
            if mutant.source not in seen:
                seen.add(mutant.source)
                yield Candidate(origin, mutant.slip.sentence, mutant.source, slip=mutant.slip)


def chosen(alike: Iterable[Candidate]) -> Candidate | None:
    """Return the one that names all candidates which cannot be told apart; None where none does.

    Two sentences of authors say different things: then there is no name. Two slips have the one
    that is declared for both of them, if one is. Of what comes back each fact is true; of what
    was done to an argument only one can be, so several say no more than which argument it is.
    """
    by_origin = defaultdict(list)
    for one in alike:
        by_origin[one.origin].append(one)
    if written := by_origin[WRITTEN]:
        return written[0] if len({one.sentence for one in written}) == 1 else None
    mutants = by_origin[OF_SOLUTION] or by_origin[OF_ANSWER]
    sentence = slips.common([one.slip for one in mutants if one.slip])
    if sentence and (not by_origin[FACT] or sentence not in slips.GENERAL):
        return replace(mutants[0], sentence=sentence)
    return _of_facts(by_origin[FACT])


def _of_facts(facts: Sequence[Candidate]) -> Candidate | None:
    for one in facts:
        if not one.about:
            return one
    if len({one.about for one in facts}) != 1:
        return None
    is_one = len({one.sentence for one in facts}) == 1
    told = facts[0].sentence if is_one else f"`{facts[0].about}` is not used as it should"
    return replace(facts[0], sentence=told)
