"""A course of five submissions, of every fate, and how a batch grades it."""

import shutil
from collections.abc import Callable
from pathlib import Path

from robust_slam_autograder.grading import batch, journal
from robust_slam_autograder.grading.batch import Graded, Graders, How
from robust_slam_autograder.grading.results import Result
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.reading import assignment as assignments
from robust_slam_autograder.sandbox import Sandbox

from .. import kernel, toy


def make_course(folder: Path) -> Path:
    toy.make_tree(folder, "[limits]\ncall_seconds = 0.4\ncell_seconds = 3\n")
    answers = {
        "ada": toy.answer(),
        "bob": toy.answer(toy.LOOP),
        "cem": toy.answer(toy.EXIT),
        "dot": toy.answer(toy.GUESS),
    }
    for student, value in answers.items():
        toy.hand_in(folder / "submitted", student, value)
    broken = folder / "submitted" / "eve" / toy.NAME
    broken.mkdir(parents=True)
    (broken / f"{toy.NAME}.ipynb").write_text("{")
    return folder


def leave(course: Path, *students: str) -> None:
    """Delete the submissions of all others."""
    for folder in (course / "submitted").iterdir():
        if folder.name not in students:
            shutil.rmtree(folder)


def jobs(course: Path) -> list[Submission]:
    loaded = assignments.of(course / "solutions", toy.NAME)
    folders = sorted((course / "submitted").iterdir())
    return [Submission(folder.name, loaded, folder / toy.NAME) for folder in folders]


def grade(
    course: Path,
    out: str = "out",
    seed: int | None = 1,
    workers: int = 2,
    report: Callable[[Graded], None] = lambda graded: None,
    wall: Sandbox | None = None,
    given: list[Submission] | None = None,
    graders: Graders = batch.processes,
    naming: Callable[[Submission, Result], Result] = lambda job, result: result,
) -> list[Graded]:
    """Grade a course, by default two submissions at a time on this machine."""
    handed_in = jobs(course) if given is None else given
    how = How(wall or kernel.quickest(), naming, graders, workers)
    return batch.grade(handed_in, journal.open_journal(course / out, seed), how, report)


def marks(graded: list[Graded]) -> list[tuple[str, str, float, tuple[str, ...]]]:
    """Student, status, score, and the status of each exercise."""
    loaded = [item.load() for item in graded]
    return [(r.student, r.status, r.score, tuple(e.status for e in r.exercises)) for r in loaded]


def same_but_for_time(ours: list[Graded], theirs: list[Graded]) -> bool:
    """Whether results differ in nothing but the seconds that they took."""
    some, others = ([vars(item.load()) | {"seconds": 0} for item in one] for one in (ours, theirs))
    return some == others
