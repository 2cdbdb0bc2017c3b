"""A batch: one secret, one result each, whatever the order, the neighbours or a kill."""

import contextlib
import os
import shutil
import time
from collections.abc import Iterable, Iterator
from typing import Any

import pytest
from robust_slam_autograder.errors import GraderFailure, Refused
from robust_slam_autograder.executor import trusted
from robust_slam_autograder.grading import batch, journal, results, submissions
from robust_slam_autograder.grading.submissions import Submission
from robust_slam_autograder.sandbox import Unsandboxed

from .. import toy
from .course import grade, jobs, leave, make_course, marks, same_but_for_time
from .disks import full_disk

RANDOM = """
### BEGIN HIDDEN TESTS
assert rng.random() < 0.5
### END HIDDEN TESTS
"""
"""A case that about half of all seeds pass."""


@pytest.fixture
def course(tmp_path):
    return make_course(tmp_path)


@pytest.mark.rest
def test_every_submission_gets_its_result_in_order_however_many_run_at_once(course):
    graded = grade(course)
    assert same_but_for_time(graded, grade(course, "serial", workers=1))
    assert marks(graded) == [
        ("ada", "graded", 20, ("passed", "passed")),
        ("bob", "graded", 10, ("timeout", "passed")),
        ("cem", "graded", 10, ("died", "passed")),
        ("dot", "graded", 14, ("partial", "passed")),
        ("eve", "refused", 0, ()),
    ]


@pytest.fixture
def started(monkeypatch):
    """Each pass that is begun: whose, whether it is a hidden one, and whether it runs alone."""
    found: list[tuple[str, bool, bool]] = []
    run = trusted.run_each

    def noted(given: Iterable[Submission], *arguments: Any, **options: Any) -> Any:
        def each() -> Iterator[Submission]:
            for task in given:
                found.append((task.student, task.seen is not None, options["at_once"] == 1))
                yield task

        return run(each(), *arguments, **options)

    monkeypatch.setattr(trusted, "run_each", noted)
    return found


def test_a_limit_is_judged_alone(course, started):
    """What hung or died beside others has its pass once more; a pass that did not is whole."""
    grade(course)
    alone = {(student, is_hidden) for student, is_hidden, is_alone in started if is_alone}
    assert alone == {("bob", False), ("cem", False)}
    assert len(started) == len(set(started)) == 5 + 2 + 4


def test_who_was_alone_already_is_not_graded_again(course, started):
    leave(course, "bob")
    assert marks(grade(course)) == [("bob", "graded", 10, ("timeout", "passed"))]
    assert started == [("bob", False, True), ("bob", True, True)]


MESSENGER = """
from pathlib import Path
KEPT = Path({kept!r})
if KEPT.exists():
    raise ValueError("LEFT " + KEPT.read_text())
def double(x):
    if np.shape(x) == (5,):
        KEPT.write_text(repr(list(x)))
        {then}
    return 2 * np.asarray(x)
"""
"""Its hidden pass leaves what it was given where every later pass of any student can read it."""


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize("then", ["pass", "import os; os._exit(1)"], ids=["goes on", "dies"])
def test_what_a_hidden_pass_leaves_behind_reaches_no_text(course, workers, then):
    """Neither its own text, when it is run once more, nor that of a student who comes later."""
    leave(course)
    answer = toy.answer(MESSENGER.format(kept=str(course / "kept"), then=then))
    for student in ("ada", "bob", "cem"):
        toy.hand_in(course / "submitted", student, answer)
    grade(course, workers=workers, wall=Unsandboxed())
    assert (course / "kept").exists()
    assert not [path for path in course.glob("out/*/*.json") if "LEFT" in path.read_text()]


def test_a_batch_that_goes_on_keeps_the_texts_that_were_made_first(course, started, monkeypatch):
    leave(course, "ada", "bob")
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(journal.Journal, "forget", interrupt)
        grade(course)
    assert len(list((course / "out" / batch.WAITING_NAME).iterdir())) == 2
    started.clear()
    assert marks(grade(course)) == [
        ("ada", "graded", 20, ("passed", "passed")),
        ("bob", "graded", 10, ("timeout", "passed")),
    ]
    assert {(who, is_hidden) for who, is_hidden, _ in started} == {("ada", True), ("bob", True)}
    assert not (course / "out" / batch.WAITING_NAME).exists()


@pytest.mark.rest
def test_a_call_that_nothing_interrupts_is_the_students_timeout(course, started, monkeypatch):
    """A function of the test's computes for minutes in C, for arguments that the student sent."""
    monkeypatch.setattr(batch, "GRACE_SECONDS", 10.0)
    test = "double(lambda n: sum(range(n)))\n"
    toy.make_tree(course, LIMITS, toy.source_notebook(double_random=test))
    leave(course, "ada")
    long = "def double(x):\n    return 6 if x == 3 else x(10**12)\n"
    for student in ("ada", "bob"):
        toy.hand_in(course / "submitted", student, toy.answer(long))
    ended = ("graded", 14, ("timeout", "passed"))
    assert marks(grade(course)) == [("ada", *ended), ("bob", *ended)]
    assert len(started) == 4, "nothing was graded once more"


def test_hidden_inputs_follow_from_the_secret_and_the_notebooks_bytes(course):
    toy.make_tree(course, value=toy.source_notebook(double_random=RANDOM))
    leave(course, "ada")
    for n in range(8):
        for student in (f"dot-{n}", f"eve-{n}"):
            other = toy.answer(toy.DOUBLE, toy.APPLY, toy.cell(f"# {n}"))
            toy.hand_in(course / "submitted", student, other)
    seen = []
    for seed in (2, 3):
        first, again = (grade(course, f"out-{seed}-{n}", seed) for n in (1, 2))
        assert marks(first) == marks(again)
        scores = {item.path.parent.name: item.load().score for item in first}
        assert all(scores[f"dot-{n}"] == scores[f"eve-{n}"] for n in range(8)), "the same bytes"
        assert set(scores.values()) == {14, 20}, "other bytes have other inputs"
        seen.append(scores)
    assert seen[0] != seen[1], "another secret gives other inputs"


def test_each_student_is_graded_with_a_number_of_their_own(course):
    seen = 'assert os.environ["ROBUST_SLAM_TOWN"] == "{}"  # as TOWN in a set-up\n'
    leave(course, "ada", "dot")
    toy.hand_in(course / "submitted", "dot", toy.answer())
    kept = journal.open_journal(course / "out", 1)
    kept.give_towns()
    ada, dot = kept.town("ada"), kept.town("dot")
    for town, scores in ((0, [16, 16]), (ada, [20, 16]), (dot, [16, 20])):
        toy.make_tree(course, value=toy.source_notebook(double_by_hand=seen.format(town)))
        assert [item.load().score for item in grade(course)] == scores


def test_what_has_not_changed_is_reused(course):
    leave(course, "ada", "dot", "eve")
    grade(course)
    assert [item.reused for item in grade(course)] == [True] * 3
    toy.hand_in(course / "submitted", "dot", toy.answer())
    assert [item.reused for item in grade(course)] == [True, False, True]
    results.path_of(course / "out", "ada", toy.NAME).write_text('"not a result"')
    assert [item.reused for item in grade(course)] == [False, True, True]
    (course / "solutions" / toy.NAME / "autograder.toml").write_text("[limits]\ncall_seconds=1")
    assert not any(item.reused for item in grade(course))
    assert not any(item.reused for item in grade(course, seed=2))


@pytest.mark.parametrize(("place", "counts"), [("", True), ("tool/_vendor", False)])
def test_what_is_installed_counts_and_not_what_a_package_carries(
    place, counts, tmp_path, monkeypatch
):
    before = submissions.code_digest.__wrapped__()
    folder = tmp_path / "site-packages" / place
    (folder / "tool-1.0.dist-info").mkdir(parents=True)
    monkeypatch.syspath_prepend(folder)
    assert (submissions.code_digest.__wrapped__() != before) == counts


class Failing:
    """A wall that ends or hangs the process that grades."""

    name = "none"

    def __init__(self, how: str) -> None:
        self.how = how

    def start(self, launch: object) -> Any:
        if self.how == "exit":
            os._exit(7)
        if self.how == "hang":
            time.sleep(1000)
        raise RuntimeError("hidden input 0.25")


FAILURES = {
    "exit": "The grader ended with exit status 7 on this submission.",
    "hang": "The grader took longer than its limits on this submission.",
    "raise": "The grader failed on this submission (RuntimeError).",
}


@pytest.mark.parametrize("how", FAILURES)
def test_a_failure_of_the_grader_is_a_result_that_tells_no_secret(course, monkeypatch, how):
    if how == "hang":
        toy.make_tree(course, "[limits]\nnotebook_seconds = 0.1\n")
        monkeypatch.setattr(batch, "GRACE_SECONDS", 0.3)
    leave(course, "ada", "dot")
    graded = grade(course, wall=Failing(how))
    assert [item.status for item in graded] == ["failed", "failed"]
    assert {item.load().reason for item in graded} == {FAILURES[how]}
    assert not journal.open_journal(course / "out", None).graded


def test_a_link_on_the_way_is_refused(course):
    submitted = course / "submitted"
    (submitted / "zoe").symlink_to("ada")
    (submitted / "yan").mkdir()
    (submitted / "yan" / toy.NAME).symlink_to(submitted / "ada" / toy.NAME)
    first, *_, yan, zoe = jobs(course)
    for job in (yan, zoe):
        with pytest.raises(Refused, match="is a link"):
            submissions.locate(job)
    # The instructor's own links are no student's.
    (course / "elsewhere").symlink_to("submitted")
    path = course / "elsewhere" / "ada" / toy.NAME
    assert submissions.locate(Submission("ada", first.assignment, path))[0].is_file()


def test_what_changes_after_it_was_listed_is_refused_or_graded_as_it_is(course):
    leave(course, "ada", "bob", "cem", "dot")
    listed = jobs(course)
    submitted = course / "submitted"
    shutil.rmtree(submitted / "bob")
    (submitted / "cem").rename(course / "aside")
    (submitted / "cem").symlink_to("ada")
    (submitted / "dot" / toy.NAME / f"{toy.NAME}.ipynb").unlink()
    graded = [item.load() for item in grade(course, given=listed)]
    fates = [(r.student, r.status) for r in graded[1:]]
    assert fates == [("bob", "refused"), ("cem", "refused"), ("dot", "refused")]
    assert graded[0].score == 20
    assert graded[2].reason == "The student's folder cem is a link."


def test_a_full_disk_stops_the_batch_and_loses_nothing(course):
    """The error names the file and the fix; the same command goes on from there."""
    leave(course, "ada", "dot", "eve")

    said = r"\.json cannot be written .*: make room"
    with contextlib.ExitStack() as full, pytest.raises(GraderFailure, match=said):
        grade(course, workers=1, report=lambda _: full.enter_context(full_disk(200)))
    written = [path.parent.name for path in (course / "out").glob(f"*/*{toy.NAME}.json*")]
    assert written == ["eve"], "a refusal is whole at once, and of the next no part is left"
    again = grade(course)
    assert [item.reused for item in again] == [False, False, True]
    assert marks(again)[1:] == [
        ("dot", "graded", 14, ("partial", "passed")),
        ("eve", "refused", 0, ()),
    ]


def test_a_regrade_that_is_cut_short_keeps_no_result_of_another_text(course, monkeypatch):
    """The file holds the new text's mark, the log would speak of the old one's."""
    leave(course, "ada")
    grade(course)
    path = course / "submitted" / "ada" / toy.NAME / f"{toy.NAME}.ipynb"
    old = path.read_bytes()
    toy.hand_in(course / "submitted", "ada", toy.answer(toy.GUESS))
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(journal.Journal, "remember", interrupt)
        grade(course)
    assert toy.result(course / "out", "ada")["score"] == 14
    path.write_bytes(old)
    assert [item.load().score for item in grade(course)] == [20]


LIMITS = "[limits]\ncall_seconds = 0.5\ncell_seconds = 0.5\nnotebook_seconds = 10\n"


def interrupt(*args: object) -> None:
    raise KeyboardInterrupt
