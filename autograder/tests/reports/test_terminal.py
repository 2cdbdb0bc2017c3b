"""Results as text: a word beside every sign, and no "all passed" that is not true."""

from robust_slam_autograder.reports import terminal

from . import samples
from .samples import case, exercise, result

PASSED = exercise("one", "passed", case("a", visible=True))
LOST = [case("b", "Add the ½.", visible=True), case("c", "Mind the sign.", visible=True)]
PARTLY = exercise("two", "partial", case("a", visible=True), *LOST)
FAILED = exercise("three", "failed", case("a", "Add the ½.", visible=True))
HUNG = exercise("four", "timeout", case("a", "Your code ran longer than it may.", visible=True))


def test_the_table_has_a_line_and_a_remark_for_each():
    hidden = exercise("one", "passed", case("a"))
    marks = [result(*each) for each in ((PASSED,), (PARTLY, HUNG), (HUNG,), (FAILED,), (hidden,))]
    table = terminal.marks_table([*marks, samples.refused("No.", student="bo")])
    assert table.splitlines() == [
        "student  assignment  mark",
        "ada      07-toy      5/5   public checks passed",
        "ada      07-toy      5/20  lost marks in two, four (timeout)",
        "ada      07-toy      0/5   lost marks in four (timeout)",
        "ada      07-toy      0/5   nothing passed",
        "ada      07-toy      5/5   all passed",
        "bo       07-toy      0/20  refused: No.",
    ]


def test_what_a_students_text_does_to_a_terminal_is_undone():
    told = exercise("one", "failed", case("a", "\x1b[2J\nall passed", visible=True))
    lines = terminal.check_line(told, None).splitlines()
    assert lines == ["✗ failed   one (a): \\x1b[2J", "    all passed"]


def test_a_check_names_each_exercise_and_what_it_lost():
    hidden = {"one": 1, "two": 3}
    lines = [terminal.check_line(each, hidden) for each in (PASSED, PARTLY, FAILED, HUNG)]
    assert lines == [
        "✓ passed   one (visible cases; 1 hidden case remains)",
        "◐ partial  two (b, c): Add the ½.",
        "✗ failed   three (a): Add the ½.",
        "✗ timeout  four: Your code ran longer than it may. Call your function with a small"
        " input. Look for a loop that never ends, and for a step that is repeated more often than"
        " it needs to be.",
    ]
    end = terminal.check_end(result(PASSED, PARTLY, reason="A cell was copied."), hidden)
    assert end.splitlines() == [
        "Note: A cell was copied.",
        "Visible cases passed in 1 of 2 exercises; 4 hidden cases remain when it is graded.",
    ]
    assert terminal.check_line(PASSED, {}).endswith("; no hidden cases remain)")
