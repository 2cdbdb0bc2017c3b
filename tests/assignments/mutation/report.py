"""What a mutation run found in one assignment: two scores, who killed, who survives."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from tests.assignments.mutation.equivalents import Equivalent
from tests.assignments.mutation.run import Verdict

LOWEST_SCORE = 0.95
"""Of the mutants that were not judged equivalent, so many must be killed."""
MOST_JUDGED = 0.10
"""Of all mutants at most so many may be judged equivalent."""


@dataclass(frozen=True)
class Report:
    """The verdicts on one assignment's mutants, in the order of the notebook's text."""

    name: str
    verdicts: Sequence[Verdict]
    judged: Sequence[Equivalent]

    @property
    def killed(self) -> int:
        """Count the mutants that lost a case."""
        return sum(verdict.is_killed for verdict in self.verdicts)

    @property
    def equivalent(self) -> list[Verdict]:
        """Return the survivors that were judged equivalent."""
        return [one for one in self.verdicts if not one.is_killed and self._is_judged(one)]

    @property
    def survivors(self) -> list[Verdict]:
        """Return the survivors that were not."""
        return [one for one in self.verdicts if not one.is_killed and not self._is_judged(one)]

    @property
    def raw_score(self) -> float:
        """Return the share of all that is killed."""
        return self.killed / max(1, len(self.verdicts))

    @property
    def score(self) -> float:
        """Return the share that is killed of those that were not judged equivalent."""
        return self.killed / max(1, len(self.verdicts) - len(self.equivalent))

    @property
    def is_good(self) -> bool:
        """Return whether enough are killed and few enough are judged equivalent."""
        judged = len(self.equivalent) / max(1, len(self.verdicts))
        return self.score >= LOWEST_SCORE and judged <= MOST_JUDGED

    def _is_judged(self, verdict: Verdict) -> bool:
        return any(one.fits(verdict.mutant) for one in self.judged)

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        yield f"{self.name}: {len(self.verdicts)} mutants"
        yield from self._killers()
        for verdict in self.survivors:
            mutant = verdict.mutant
            yield f"  survives in {mutant.exercise}, {mutant.function}:"
            yield from (f"    - {line}" for line in mutant.line.split("\n"))
            yield from (f"    + {line}" for line in mutant.becomes.split("\n"))
        share = len(self.equivalent) / max(1, len(self.verdicts))
        yield (
            f"  {self.killed} killed, {len(self.survivors)} survive, "
            f"{len(self.equivalent)} judged equivalent ({share:.1%})"
        )
        verdict = "good" if self.is_good else "not enough"
        yield f"  score {self.raw_score:.1%} raw, {self.score:.1%} after equivalents: {verdict}"

    def _killers(self) -> Iterator[str]:
        """How many mutants each case kills, and how many nothing else does."""
        kills = Counter(case for verdict in self.verdicts for case in verdict.lost)
        alone = Counter(verdict.lost[0] for verdict in self.verdicts if len(verdict.lost) == 1)
        for case, count in kills.items():
            yield f"  {case:<40} kills {count:>4}, alone {alone[case]:>4}"
        faults = Counter(verdict.fault for verdict in self.verdicts if verdict.fault)
        for fault, count in sorted(faults.items()):
            told = "ran longer than they may" if fault == "timeout" else "ended their process"
            yield f"  {count} {told}"
