"""How many wrong answers get a name, and which the engine gives to one that it has not seen.

    python -m tests.assignments.named [NAME[/EXERCISE]…] [--read 0]

Each labelled wrong answer that a visible case stops is named by all that the engine knows, and
then as if it were unknown: by the other answers and by facts of the values. That name is of
another slip, so whether it is true has to be read: ``--read 100`` prints a hundred of them beside
the label that was taken away. What only hidden cases stop has no name.
"""

import argparse
import random
import sys
from collections.abc import Iterator

from robust_slam_autograder.misconceptions import survey, tables
from robust_slam_autograder.reading.labelled import Answer

from solutions.classes import answers

Named = tuple[Answer, str, str]
"""A wrong answer, its name, and the one that it has where it is unknown; both may be empty."""


def named(name: str, exercise: str) -> Iterator[Named]:
    """Name the wrong answers to an exercise that a visible case stops."""
    path, assignment = answers.SOLUTIONS / name / f"{name}.ipynb", answers.load(name)
    mine = [one for one in answers.answers(name) if one.exercise == exercise]
    found = [*survey.tried(path, assignment, exercise, mine)]
    keys = {way.source: keys for way, keys in found}
    whole = survey.labelled(found)
    for one in (one for one in mine if one.is_visible):
        rest = survey.labelled(pair for pair in found if pair[0].source != one.source)
        own = keys.get(one.source, ())
        yield one, tables.sentence(whole, own), tables.sentence(rest, own)


def main() -> int:
    """Run the command; give its exit status."""
    parser = argparse.ArgumentParser(prog="python -m tests.assignments.named")
    parser.add_argument("names", nargs="*", metavar="NAME", default=answers.assignments())
    parser.add_argument("--read", type=int, default=0, metavar="N", help="print N of the names")
    given = parser.parse_args()
    told: list[Named] = []
    for name, only in (one.partition("/")[::2] for one in given.names):
        for exercise in answers.solutions(name):
            if only in ("", exercise):
                told += (mine := [*named(name, exercise)])
                print(f"{name[:2]}/{exercise}: {_share(mine)}", flush=True)
    print(f"all: {_share(told)}")
    shown = [(one, said) for one, _, said in told if said]
    for one, said in random.Random(0).sample(shown, min(given.read, len(shown))):
        print(f"{one.exercise}: {one.story}\n    It looks as if {said}.")
    return 0


def _share(told: list[Named]) -> str:
    own, others = (sum(bool(one[n]) for one in told) for n in (1, 2))
    return f"{own} of {len(told)} named, {own / max(1, len(told)):.1%}; unknown {others}"


if __name__ == "__main__":
    sys.exit(main())
