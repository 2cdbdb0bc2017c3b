"""Writes every submission of the suite, for another grader to try.

``python -m tests.autograder.hostile TREE NAME OUT`` makes ``OUT/<submission>/<assignment>/``
for each, and ``OUT/manifest.json``, which says of each what it is and how it is bound. Code in
them is told that the batch's folder is the parent of OUT. Those marked dangerous kill, fork,
fill memory and disk: run them as a user of their own, in a container.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from tests.autograder.hostile import catalogue
from tests.autograder.hostile.entry import Entry, Place
from tests.autograder.hostile.target import Target, load

MARK = "mk-of-an-attack"


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the submissions and the manifest."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.autograder.hostile", description="Writes the hostile submissions."
    )
    parser.add_argument("tree", type=Path, metavar="TREE", help="the instructor's source tree")
    parser.add_argument("name", metavar="NAME", help="the assignment")
    parser.add_argument("out", type=Path, metavar="OUT", help="a folder that is not there yet")
    parser.add_argument("--victim", metavar="ID", help="grade id of the solution cell to attack")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as releases:
        target = load(options.tree, options.name, Path(releases), options.victim)
    write_all(target, options.out.absolute())
    print(f"{len(catalogue.entries())} submissions of {target.name} in {options.out}")


def write_all(target: Target, out: Path) -> None:
    """Write every submission of a target into a new folder, with its manifest."""
    out.mkdir(parents=True)
    for entry in catalogue.entries():
        entry.write(target, Place(out / entry.name / target.name, out.parent, MARK))
    (out / "manifest.json").write_text(json.dumps(manifest(target), indent=1), "utf-8")


def manifest(target: Target) -> dict[str, Any]:
    """What the submissions of a target are, and by what to judge them (see ``verdict``)."""
    return {
        "assignment": target.name,
        "notebook": target.assignment.notebook,
        "points": {case.grade_id: case.points for case in target.assignment.cases},
        "victim": target.victim,
        "victim_cases": [case.grade_id for case in target.victim_cases],
        "baselines": catalogue.BASELINES,
        "submissions": [_row(entry) for entry in catalogue.entries()],
    }


def _row(entry: Entry) -> dict[str, Any]:
    return {
        "name": entry.name,
        "kind": entry.kind,
        "bound": entry.bound,
        "twin": entry.twin,
        "dangerous": entry.dangerous,
    }


if __name__ == "__main__":
    main()
