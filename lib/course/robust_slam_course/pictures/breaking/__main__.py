"""``python -m robust_slam_course.pictures.breaking``: what is done with scores of the game."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path

from robust_slam_course.pictures.breaking import best, rules, scores


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; return 0, 1 for an attack that fools nothing, or 2 after what is wrong."""
    parser = argparse.ArgumentParser(prog="breaking", description="Scores of Break the map.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    replay = commands.add_parser("replay", help="replay a score, and print a line of CSV")
    replay.add_argument("score", metavar="SCORE", help="such as A:gnc:1-9:1,-1:2")
    table = commands.add_parser("scores", help="replay a class's scores, and write a table")
    what = "a CSV of student,score, or a folder of files"
    table.add_argument("scores", type=Path, metavar="PATH", help=what)
    table.add_argument("--no-names", action="store_true", help="leave the students out")
    table.add_argument("--to", type=Path, default=Path("class/scores.csv"), metavar="FILE")
    commands.add_parser("best", help="compute best.json anew, for hours, and print it")
    options = parser.parse_args(arguments)
    try:
        if options.command == "scores":
            print(scores.write(options.scores, options.to, names=not options.no_names))
        elif options.command == "best":
            print(json.dumps(best.table(), separators=(",", ":")))
        else:
            told = scores.replayed(rules.attack(options.score))
            print(",".join(scores.HEAD), ",".join(told), sep="\n")
            return 0 if scores.FOOLED in told else 1
    except (OSError, ValueError) as error:
        print(f"breaking: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
