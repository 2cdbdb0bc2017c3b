"""Results as text: a word beside every sign, and no "all passed" that is not true."""

from __future__ import annotations

from robust_slam_autograder.grading.results import (
    CaseResult,
    ExerciseResult,
    Result,
    without_grade,
)
from robust_slam_autograder.reports import terminal


def exercise(name: str, status: str, *messages: str) -> ExerciseResult:
    cases = tuple(
        CaseResult(f"case-{n}", 5, 0 if message else 5, True, message)
        for n, message in enumerate(messages)
    )
    score = sum(case.earned for case in cases)
    message = next((m for m in messages if m), "")
    return ExerciseResult(name, score, 5 * len(cases), status, message, cases)  # type: ignore


def result(*exercises: ExerciseResult, reason: str = "") -> Result:
    score = sum(each.score for each in exercises)
    most = sum(each.max_score for each in exercises)
    return Result("ada", "a", score, most, "graded", reason, "none", 0.0, exercises)


PASSED = exercise("one", "passed", "", "")
PARTLY = exercise("two", "partial", "", "Add the ½.", "Mind the sign.")
FAILED = exercise("three", "failed", "Add the ½.")
HUNG = exercise("four", "timeout", "Your code ran longer than it may.")


def test_the_table_has_a_line_and_a_remark_for_each() -> None:
    refused = without_grade("refused", "No.", student="bo", assignment="bcd", max_score=60)
    table = terminal.marks_table([result(PASSED), result(PASSED, PARTLY), result(FAILED), refused])
    assert table.splitlines() == [
        "student  assignment  mark",
        "ada      a           10/10  public checks passed",
        "ada      a           15/25  lost marks in two",
        "ada      a           0/5    nothing passed",
        "bo       bcd         0/60   refused: No.",
    ]


def test_without_names_the_table_tells_nobody() -> None:
    refused = without_grade(
        "refused", "bo.ipynb is no.", student="bo", assignment="b", max_score=6
    )
    table = terminal.marks_table([refused, result(PASSED, PARTLY)], names=False)
    assert table.splitlines() == [
        "assignment  mark",
        "a           15/25  lost marks in two",
        "b           0/6    refused",
    ]


def test_all_passed_is_said_where_hidden_checks_ran() -> None:
    case = CaseResult("case-0", 5, 5, False, "")
    hidden = ExerciseResult("one", 5, 5, "passed", "", (case,))
    assert terminal.marks_table([result(hidden)]).endswith("5/5   all passed")


def test_what_a_students_text_does_to_a_terminal_is_undone() -> None:
    told = exercise("one", "failed", "\x1b[2J\nall passed")
    assert terminal.check_line(told, None).splitlines() == [
        "✗ failed   one (case-0): \\x1b[2J",
        "    all passed",
    ]


def test_a_check_names_each_exercise_and_what_it_lost() -> None:
    hidden = {"one": 1, "two": 3}
    lines = [terminal.check_line(each, hidden) for each in (PASSED, PARTLY, FAILED, HUNG)]
    assert lines == [
        "✓ passed   one (visible cases; 1 hidden case remains)",
        "✗ partial  two (case-1, case-2): Add the ½.",
        "✗ failed   three (case-0): Add the ½.",
        "✗ timeout  four: Your code ran longer than it may. Call your function with a small"
        " input. Look for a loop that never ends, and for a step that is repeated more often than"
        " it needs to be.",
    ]
    end = terminal.check_end(result(PASSED, PARTLY, reason="A cell was copied."), hidden)
    assert end.splitlines() == [
        "Note: A cell was copied.",
        "Visible cases passed in 1 of 2 exercises; 4 hidden cases remain when it is graded.",
    ]


def test_a_check_that_passes_promises_no_mark() -> None:
    ends = {
        None: "hidden cases remain",
        0: "no hidden cases remain",
        1: "1 hidden case remains",
        5: "5 hidden cases remain",
    }
    for count, said in ends.items():
        hidden = None if count is None else {"one": count}
        line, end = terminal.check_line(PASSED, hidden), terminal.check_end(result(PASSED), hidden)
        assert line == f"✓ passed   one (visible cases; {said})"
        assert end == f"All visible cases passed; {said} when it is graded."
