"""The sample class: five students who hand in every assignment, each in another way.

``python -m solutions.classes.sample_class write RELEASE OUT`` writes it to
``OUT/<student>/<assignment>/``. ``python -m solutions.classes.sample_class table FILE`` prints the
marks that ``autograder grade --json FILE`` wrote, a line for each student.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from solutions.classes import answers

STUDENTS = (
    "sample-broken",
    "sample-half",
    "sample-misprints",
    "sample-solutions",
    "sample-untouched",
)


def write(release: Path, out: Path, assignments: Sequence[str] = ()) -> list[Path]:
    """Write the class's submissions to a release, or to some of it, and return their folders."""
    return [
        answers.hand_in(out, student, assignment, text)
        for assignment in assignments or answers.assignments()
        for student, text in _texts(assignment, release).items()
    ]


def half(assignment: str) -> list[str]:
    """Return the exercises of who stops halfway; a later one may call an earlier one."""
    exercises = list(answers.solutions(assignment))
    return exercises[: (len(exercises) + 1) // 2]


def misprints(assignment: str) -> dict[str, str]:
    """Return per exercise the answer that types in what the lesson prints."""
    return {
        answer.exercise: answer.source
        for answer in answers.answers(assignment)
        if answer.name.startswith("wrong_misprint")
    }


def _texts(assignment: str, release: Path) -> dict[str, str]:
    released, done = answers.source_notebook(assignment, release), answers.solutions(assignment)
    given = {
        "sample-solutions": done,
        "sample-untouched": {},
        "sample-half": {name: done[name] for name in half(assignment)},
        "sample-misprints": done | misprints(assignment),
    }
    texts = {
        student: answers.text(answers.with_answers(released, sources))
        for student, sources in given.items()
    }
    # What a half-written file looks like after a full disk.
    return texts | {"sample-broken": texts["sample-solutions"][:1000]}


def table(marks: Mapping[str, Any]) -> str:
    """Return a line for each student, a column for each assignment, headed by its number."""
    by_key = {(item["student"], item["assignment"]): item for item in marks["submissions"]}
    students, assignments = (sorted({key[side] for key in by_key}) for side in (0, 1))
    rows = [["", *(name.partition("-")[0] for name in assignments)]]
    for student in students:
        cells = [_mark(by_key.get((student, name))) for name in assignments]
        rows.append([student, *cells])
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in rows
    )


def _mark(item: Mapping[str, Any] | None) -> str:
    if item is None:
        return ""
    if item["status"] != "graded":
        return str(item["status"])
    return f"{item['score']}/{item['max_score']}"


def main(arguments: Sequence[str]) -> None:
    """Run one of the two commands."""
    if arguments[0] == "write":
        release, out = map(Path, arguments[1:])
        print(f"sample class: {len(write(release, out))} submissions in {out}")
    else:
        print(table(json.loads(Path(arguments[1]).read_text(encoding="utf-8"))))


if __name__ == "__main__":
    main(sys.argv[1:])
