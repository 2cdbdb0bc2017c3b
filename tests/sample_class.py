"""The sample class: five students who hand in every assignment, each in another way.

``python -m tests.sample_class RELEASE OUT`` writes it to ``OUT/<student>/<assignment>/``.
"""

from __future__ import annotations

import sys
from pathlib import Path

from tests.assignments import answers

STUDENTS = (
    "sample-broken",
    "sample-half",
    "sample-misprints",
    "sample-solutions",
    "sample-untouched",
)


def write(release: Path, out: Path) -> list[Path]:
    """Write the class's submissions.

    Args:
        release: the student release, ``<release>/<assignment>/<assignment>.ipynb``.
        out: where ``<student>/<assignment>/<assignment>.ipynb`` goes.

    Returns:
        the submissions' folders.
    """
    folders = []
    for assignment in answers.assignments():
        for student, text in _texts(assignment, release).items():
            path = out / student / assignment / f"{assignment}.ipynb"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
            folders.append(path.parent)
    return folders


def half(assignment: str) -> list[str]:
    """The exercises of the student who stops halfway; a later one may call an earlier one."""
    exercises = answers.solution_ids(answers.source_notebook(assignment))
    return exercises[: (len(exercises) + 1) // 2]


def misprints(assignment: str) -> dict[str, str]:
    """Per exercise the answer that types in what the lesson prints."""
    return {
        answer.exercise: answer.source
        for answer in answers.answers(assignment)
        if answer.name.startswith("wrong_misprint")
    }


def _texts(assignment: str, release: Path) -> dict[str, str]:
    solved = answers.source_notebook(assignment)
    released = answers.source_notebook(assignment, release)
    done = {
        cell["metadata"]["nbgrader"]["grade_id"]: "".join(cell["source"])
        for cell in solved["cells"]
        if cell["metadata"].get("nbgrader", {}).get("solution")
    }
    finished = answers.with_answers(released, done)
    return {
        "sample-solutions": answers.text(finished),
        "sample-untouched": answers.text(released),
        "sample-half": answers.text(
            answers.with_answers(released, {name: done[name] for name in half(assignment)})
        ),
        "sample-misprints": answers.text(answers.with_answers(finished, misprints(assignment))),
        # What a half-written file looks like after a full disk.
        "sample-broken": answers.text(finished)[:1000],
    }


if __name__ == "__main__":
    made = write(Path(sys.argv[1]), Path(sys.argv[2]))
    print(f"sample class: {len(made)} submissions in {sys.argv[2]}")
