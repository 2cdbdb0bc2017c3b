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

from robust_slam_autograder.misconceptions import candidates, survey, tables
from robust_slam_autograder.misconceptions.bench import Setting
from robust_slam_autograder.misconceptions.candidates import OF_ANSWER, WRITTEN, Candidate
from robust_slam_autograder.misconceptions.shapes import Shape
from robust_slam_autograder.reading import assignment as assignment_module
from robust_slam_autograder.reading.labelled import Answer

from tests.assignments import answers

SPLITS = 5


def named(name: str, exercise: str) -> tuple[list[tuple[str, Answer, str]], list[str]]:
    """Name an exercise's answers by others.

    Returns:
        where each wrong answer stands that was taken away, it, and its name or nothing; and the
        right ones that fail a case.
    """
    path = answers.SOLUTIONS / name / f"{name}.ipynb"
    setting = Setting(path, assignment_module.load(path))
    mine = [one for one in answers.answers(name) if one.exercise == exercise]
    choice = functools.partial(candidates.candidates, exercise=exercise, answers=mine)
    found = list(survey.shapes_of(setting, exercise, choice))
    typed = [Candidate(WRITTEN if not one.is_right else OF_ANSWER, "", one.source) for one in mine]
    looked = survey.shapes_of(setting, exercise, lambda b: typed)
    shapes = {one.source: shape for one, shape in looked}
    wrong = [one for one in mine if not one.is_right]
    told = []
    for split in range(SPLITS):
        unseen = random.Random(split).sample(wrong, len(wrong) // 2)
        gone = {one.source for one in unseen}
        left = (
            (one, shape.keys())
            for one, shape in found
            if survey.counts(one, shape) and not (one.origin == WRITTEN and one.source in gone)
        )
        table = survey.labelled(left)
        for one in unseen:
            said = tables.sentence(table, shapes.get(one.source, Shape()))
            told.append((f"{name[:2]}/{exercise}", one, said))
    return told, [one.name for one in mine if one.is_right and one.source in shapes]


def main() -> int:
    """Run the command; give its exit status: 1 where a right answer has a name."""
    parser = argparse.ArgumentParser(prog="python -m tests.assignments.named")
    parser.add_argument("names", nargs="*", metavar="NAME", default=answers.assignments())
    parser.add_argument("--read", type=int, default=0, metavar="N", help="print N of the names")
    given = parser.parse_args()
    told: list[tuple[str, Answer, str]] = []
    wronged: list[str] = []
    for name, only in (one.partition("/")[::2] for one in given.names):
        for exercise in answers.solutions(name):
            if only in ("", exercise):
                mine, right = named(name, exercise)
                print(f"{name[:2]}/{exercise}: {_share(mine)}", flush=True)
                told, wronged = told + mine, wronged + right
    print(f"all: {_share(told)}; right answers named: {len(wronged)} {', '.join(wronged)}")
    shown = sorted({(where, one.story, said) for where, one, said in told if said})
    for where, story, said in random.Random(0).sample(shown, min(given.read, len(shown))):
        print(f"{where}: {story}\n    It looks as if {said}.")
    return 1 if wronged else 0


def _share(told: list[tuple[str, Answer, str]]) -> str:
    named = sum(bool(said) for _, _, said in told)
    return f"{named} of {len(told)} named, {named / max(1, len(told)):.1%}"


if __name__ == "__main__":
    sys.exit(main())
