"""How many wrong answers get a name that the engine has not seen, and which.

    python -m tests.assignments.named [NAME[/EXERCISE]…] [--read 0]

Five times half of the labelled wrong answers are taken away from what the engine knows, and are
then named by the rest: by the other half, by mutants, by facts and aspects of the values, and by
what came in where they go wrong. Each name is of another slip's label or of none, so whether it
is true has to be read: ``--read 100`` prints a hundred of them beside the label that was taken
away. A right answer fails no case, and what fails no case gets no name: one that does is reported.
"""

from __future__ import annotations

import argparse
import functools
import random
import sys
from collections.abc import Iterator
from dataclasses import dataclass

from robust_slam_autograder.misconceptions import candidates, survey
from robust_slam_autograder.misconceptions.bench import Setting
from robust_slam_autograder.misconceptions.candidates import OF_ANSWER, WRITTEN, Candidate
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.misconceptions.tables import Table
from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading.labelled import Answer

from tests.assignments import answers

SPLITS = 5


@dataclass(frozen=True)
class Measured:
    """An exercise's wrong answers, and all that they may be named by."""

    exercise: str
    wrong: list[Answer]
    shapes: dict[str, Shape]
    """By the text of a labelled wrong answer."""
    ways: list[tuple[Candidate, tuple[str, ...]]]
    rest: Table
    """Without labels."""
    wronged: list[str]
    """Right answers that would have a name."""

    def split(self, rng: random.Random) -> Iterator[tuple[Answer, str]]:
        """Yield half of the wrong answers, each with the name that the others give it."""
        unseen = rng.sample(self.wrong, len(self.wrong) // 2)
        hidden = {one.source for one in unseen}
        left = [
            (one, keys)
            for one, keys in self.ways
            if not (one.origin == WRITTEN and one.source in hidden)
        ]
        table = survey.labelled(self.rest, left)
        for answer in unseen:
            yield answer, table.sentence(self.shapes.get(answer.source, Shape()))


def measured(name: str, exercise: str) -> Measured:
    """Run all answers to an exercise, and all other ways to be wrong."""
    path = answers.SOLUTIONS / name / f"{name}.ipynb"
    setting = Setting(path, assignment_module.load(path))
    mine = [one for one in answers.answers(name) if one.exercise == exercise]
    choice = functools.partial(candidates.candidates, exercise=exercise, answers=mine)
    found = survey.shapes_of(setting, exercise, choice)
    typed = [Candidate(WRITTEN if not one.is_right else OF_ANSWER, "", one.source) for one in mine]
    shapes = {
        one.source: shape
        for one, shape in survey.shapes_of(setting, exercise, lambda b: typed, with_aspects=True)
    }
    return Measured(
        exercise=f"{name[:2]}/{exercise}",
        wrong=[one for one in mine if not one.is_right],
        shapes=shapes,
        ways=[(one, shape.keys()) for one, shape in found if survey.counts(one, shape)],
        rest=survey.table(setting, exercise),
        wronged=[one.name for one in mine if one.is_right and one.source in shapes],
    )


def main() -> int:
    """Run the command; give its exit status: 1 where a right answer has a name."""
    parser = argparse.ArgumentParser(prog="python -m tests.assignments.named")
    parser.add_argument("names", nargs="*", metavar="NAME", default=answers.assignments())
    parser.add_argument("--read", type=int, default=0, metavar="N", help="print N of the names")
    given = parser.parse_args()
    asked = [name.partition("/")[::2] for name in given.names]
    pairs = [
        (name, exercise)
        for name, only in asked
        for exercise in answers.solutions(name)
        if only in ("", exercise)
    ]
    told: list[tuple[str, Answer, str]] = []
    wronged: list[str] = []
    for name, exercise in pairs:
        one = measured(name, exercise)
        wronged += [f"{one.exercise} {right}" for right in one.wronged]
        rngs = map(random.Random, range(SPLITS))
        mine = [(one.exercise, *pair) for rng in rngs for pair in one.split(rng)]
        print(f"{name[:2]}/{exercise}: {_share(mine)}", flush=True)
        told += mine
    print(f"all: {_share(told)}; right answers named: {len(wronged)} {', '.join(wronged)}")
    named = sorted({(where, one.story, said) for where, one, said in told if said})
    for where, story, said in random.Random(0).sample(named, min(given.read, len(named))):
        print(f"{where}: {story}\n    It looks as if {said}.")
    return 1 if wronged else 0


def _share(told: list[tuple[str, Answer, str]]) -> str:
    named = sum(bool(said) for _, _, said in told)
    return f"{named} of {len(told)} named, {named / max(1, len(told)):.1%}"


if __name__ == "__main__":
    sys.exit(main())
