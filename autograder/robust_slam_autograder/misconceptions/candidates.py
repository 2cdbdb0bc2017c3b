"""What a wrong answer may be: one that was written down, or a fact of the values.

Where several fit, an author's sentence counts, because it names the misconception; a fact says
what the values are.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, field

from robust_slam_autograder.misconceptions.bench import Bench, Names
from robust_slam_autograder.reading.labelled import Answer


@dataclass(frozen=True)
class Candidate:
    """One way to be wrong."""

    sentence: str
    """What goes on after "It looks as if"."""
    source: str = ""
    """Text of the solution cell; empty for a fact."""
    fact: str = ""
    """The number and the sentence of a fact."""
    about: str = field(default="", compare=False)
    """The argument that a fact is about, where it is not about what comes back."""

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
    for answer in answers:
        if answer.exercise == exercise and not answer.is_right:
            yield Candidate(answer.label, answer.source)
    for key, fact in bench.facts(exercise).items():
        yield Candidate(fact.sentence, fact=key, about=fact.argument)


def chosen(alike: Collection[Candidate]) -> str:
    """Return the sentence that is true of candidates which cannot be told apart, or nothing.

    Two sentences of authors say different things: then there is no name. Of what comes back each
    fact is true; of what was done to an argument only one can be, so several say no more than
    which argument it is.
    """
    written = {one.sentence for one in alike if one.source}
    if written:
        return written.pop() if len(written) == 1 else ""
    for one in alike:
        if not one.about:
            return one.sentence
    about, told = {one.about for one in alike}, {one.sentence for one in alike}
    if len(about) != 1:
        return ""
    return told.pop() if len(told) == 1 else f"`{about.pop()}` is not used as it should"
