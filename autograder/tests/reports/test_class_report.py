"""What an instructor is told of a class: counts that add up, and names only where asked for."""

from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from robust_slam_autograder.grading.messages import NOT_WRITTEN
from robust_slam_autograder.grading.results import ExerciseResult, Result, Words
from robust_slam_autograder.reports import class_pages, hints
from robust_slam_autograder.reports.class_report import BROKEN, EASY, Report
from robust_slam_autograder.reports.hints import Hint, Reader

from .. import toy
from . import pages, samples
from .pages import report
from .samples import case, exercise, result

MARKS = st.lists(st.integers(0, 60), min_size=1, max_size=40)


def marked(marks: Sequence[float], most: float = 60) -> Report:
    results = [replace(result(student=f"s{n}"), score=m) for n, m in enumerate(marks)]
    return report(*(replace(one, max_score=most) for one in results))


class TestMarks:
    @pytest.mark.parametrize(
        ("marks", "most", "wanted"),
        [
            ([0, 4, 5, 59, 60], 60, [("0–4", 2), ("5–9", 1), ("55–59", 1), ("60", 1)]),
            ([7], 12, [("7", 1)]),
            ([0, 0], 0, [("0", 2)]),
            ([61, 63], 63, [("60–63", 2)]),
            ([4.5, 60], 60, [("0–<5", 1), ("60", 1)]),
            ([0.5], 0.5, [("0–0.5", 1)]),
            ([1234, 2000], 2000, [("1200–1399", 1), ("2000", 1)]),
        ],
    )
    def test_labels_say_what_is_in_a_bin(self, marks, most, wanted):
        bins = marked(marks, most).marks.bins
        assert [(found.label, found.students) for found in bins if found.students] == wanted

    @given(MARKS)
    def test_every_mark_is_in_the_one_bin_that_says_so(self, marks):
        found = marked(marks).marks
        assert found.students == len(marks)
        for one in found.bins:
            assert one.students == sum(one.low <= mark <= one.high for mark in marks)
        ends = [found.lowest, found.lower_quartile, found.median, found.upper_quartile]
        assert ends == sorted(ends) and found.highest == max(marks)

    @given(MARKS)
    def test_the_median_is_drawn_in_its_bin(self, marks):
        found = marked(marks).marks
        n = int(found.median_place - 1e-9)
        assert found.bins[n].low - 0.5 <= found.median <= found.bins[n].high + 0.5

    def test_who_has_no_mark_is_counted_apart(self):
        others = samples.refused("No.", student="b"), samples.failed("It died.", student="z")
        made = report(result(samples.PASSED), *others)
        assert (made.handed_in, made.graded, made.refused, made.failed) == (3, 1, 1, 1)
        assert made.marks.students == 1
        nothing = report(*others[:1])
        assert (nothing.marks, nothing.time, nothing.exercises) == (None, None, ())
        assert [kind.name for kind in nothing.attention] == ["Refused"]


EASIER = exercise("double", "passed", case("by-hand", visible=True), case("random"))
HARDER = exercise("apply", "failed", case("by-hand", "Look.", visible=True), case("twice", "No."))
HALF = exercise("apply", "partial", case("by-hand", visible=True), case("twice", "No."))
GONE = replace(HARDER, status="missing", message="There is no cell apply.")
LATE = replace(HALF, status="timeout")
UNSOLVED = exercise("double", "failed", case("by-hand", "x", visible=True), case("random", "x"))
CLASS = tuple(
    result(EASIER, second, student=name)
    for name, second in {"ada": HARDER, "ben": HALF, "cleo": GONE, "dora": LATE}.items()
)


class TestExercises:
    def test_the_hardest_is_first_and_every_student_in_one_part(self):
        apply, double = report(*CLASS).exercises
        assert (apply.name, apply.share) == ("apply", 0.25), "the share is of points"
        assert (double.name, double.share) == ("double", 1)
        assert (apply.whole, apply.partly, apply.none, apply.missing) == (0, 2, 1, 1)
        assert (double.whole, double.partly, double.none, double.missing) == (4, 0, 0, 0)
        assert (apply.timeouts, apply.deaths, double.limits) == (1, 0, 0)

    def test_a_case_says_who_passes_it_and_whether_it_is_hidden(self):
        apply, double = report(*CLASS).exercises
        assert [(c.name, c.hidden, c.passed, c.share, c.remark) for c in apply.cases] == [
            ("by-hand", False, 2, 0.5, ""),
            ("twice", True, 0, 0, BROKEN),
        ]
        assert double.remarks == {EASY: 2}

    def test_one_student_is_no_reason_to_doubt_a_test(self):
        assert not any(each.remarks for each in report(CLASS[0]).exercises)

    def test_an_exercise_of_no_points_has_no_share_and_comes_last(self):
        free = exercise("free", "passed", case("first", points=0))
        made = report(result(free, HARDER), result(free, HARDER, student="b"))
        shares = [(each.name, each.share) for each in made.exercises]
        assert shares == [("apply", 0), ("free", None)]


class TestVersions:
    """Marks that different tests gave are not mixed."""

    @pytest.mark.parametrize(
        ("other", "said"),
        [
            (exercise("double", "passed", case("by-hand"), case("random")), "5 points, hidden in"),
            (exercise("double", "passed", case("random"), case("by-hand", visible=True)), "order"),
            (exercise("double", "passed", case("by-hand", visible=True), case("new")), "random"),
            (exercise("double", "passed", case("by-hand", visible=True, points=1)), "1 point, v"),
        ],
    )
    def test_each_difference_makes_a_version_and_is_named(self, other, said):
        same = replace(EASIER, cases=EASIER.cases)
        made = report(result(same), result(EASIER, student="b"), result(other, student="c"))
        assert len(made.others) == 1
        assert said in "; ".join(made.others[0].differences)


def told(*exercises: ExerciseResult, names: bool = True, students: str = "") -> list[Hint]:
    return list(hints.collect(exercises, Reader(names, frozenset(students.split()))))


class TestHints:
    def test_a_text_counts_once_for_each_student(self):
        (first, second) = told(samples.UNWRITTEN, samples.UNWRITTEN, HARDER)[:2]
        assert (first.text, first.students, first.cases) == ("Not written.", 2, ("first", "next"))
        assert (second.students, second.wordings, second.example) == (1, 1, "")

    def test_a_missing_cell_is_said_once_and_of_a_passed_exercise_nothing(self):
        (hint,) = told(GONE, EASIER)
        assert (hint.text, hint.cases) == ("There is no cell apply.", ())

    def test_students_words_are_grouped_by_what_was_raised(self):
        texts = ["ValueError: shapes (3,)", "ValueError: shapes (2,)", "KeyError: 'a'"]
        texts.append(texts[1])
        failed = (exercise("e", "failed", samples.raised("c", t)) for t in texts)
        values, keys = told(*failed)
        assert values.text == "Your function raised ValueError."
        assert (values.students, values.wordings) == (3, 2)
        assert values.example == "Your function raised ValueError: shapes (2,)."
        assert (keys.text, keys.students) == ("Your function raised KeyError.", 1)

    @pytest.mark.parametrize(
        ("double", "start"),
        [
            ("raise ValueError('WORDS')", "Your function raised ValueError."),
            ("return {'WORDS'}", "What your function returned cannot be checked."),
            ("return 'WORDS'\nWORDS(", "Your cell stops with SyntaxError."),
            ("return type('WORDS', (), {})()", "What your function returned cannot be checked."),
            ("raise type('WORDS', (KeyError,), {})", f"Your function raised {hints.UNNAMED}."),
        ],
    )
    def test_what_the_grader_says_is_told_from_what_students_say(self, double, start):
        """The grader's own sentences, from a submission that was graded."""
        graded = toy.checked(toy.answer(f"def double(x):\n    {double}\n")).exercises[0]
        (hint, *_) = told(graded, names=False)
        assert hint.text == start
        assert "WORDS" not in repr(told(graded, names=False))

    def test_a_text_that_names_a_student_is_withheld_without_names(self):
        failed = exercise("e", "failed", case("c", "Not (Ada) but ben."), case("d", "adamant"))
        texts = {hint.text for hint in told(failed, names=False, students="ada ben a.b")}
        assert texts == {hints.WITHHELD, "adamant"}
        assert "Not (Ada) but ben." in {hint.text for hint in told(failed, students="ada")}

    @pytest.mark.parametrize(
        ("student", "text"),
        [
            ("zo\u00eb", "Not zoe\u0308 but another."),
            ("zoe\u0308", "Not ZO\u00cb."),
            ("zo\u00eb", "Not z\u200bo\u00eb."),
            ("ada-lovelace", "Ask Ada Lovelace\nfirst."),
            ("stra\u00dfe", "STRASSE"),
            ("ada", "\uff41\uff44\uff41!"),
            ("a\u030ake", "\u212bKE"),
        ],
    )
    def test_a_name_is_withheld_however_it_is_written(self, student, text):
        failed = exercise("e", "failed", case("c", text))
        (hint,) = told(failed, names=False, students=student)
        assert hint.text == hints.WITHHELD


class TestAttention:
    def test_each_student_stands_under_the_most_pressing_reason(self):
        hung = [replace(HARDER, status="timeout"), replace(EASIER, status="died")]
        made = report(
            result(EASIER, HARDER, student="gus"),
            result(*reversed(hung), student="hal"),
            result(EASIER, student="old"),
            result(replace(UNSOLVED, status="timeout"), HARDER, student="pat"),
            result(UNSOLVED, HARDER, student="ned"),
            samples.refused("Bad\x1b.", student="ben"),
            samples.failed("It died.", student="zoe"),
        )
        limit = "Ran into a limit"
        assert [(k.name, one.student, one.reason) for k in made.attention for one in k.list] == [
            ("The grader failed", "zoe", "It died."),
            ("Refused", "ben", "Bad\\x1b."),
            ("Graded by other tests than most", "old", "10 of 10 points"),
            (limit, "hal", "double ended its process, apply ran too long"),
            (limit, "pat", "double ran too long"),
            ("No points", "ned", "0 of 20 points"),
        ]

    def test_no_points_of_none_need_no_attention(self):
        free = exercise("free", "passed", case("first", points=0))
        assert report(result(free)).attention == ()


def test_the_slowest_are_named_and_refusals_take_no_part():
    slow = [result(EASIER, student=f"s{n}", seconds=float(n)) for n in range(9)]
    time = report(*slow, samples.refused("No.", student="b")).time
    assert (time.median, time.longest, time.total) == (4, 8, 36)
    assert [one.student for one in time.slowest] == ["s8", "s7", "s6", "s5", "s4"]


def test_without_names_nothing_tells_who_it_was():
    mine = samples.raised("by-hand", "AdaError: by ada-lovelace", visible=True)
    own = exercise("double", "failed", mine, case("random", "ada"))
    made = report(
        result(own, HARDER, student="ada"),
        result(EASIER, LATE, student="ben", reason="ben copied a cell."),
        result(samples.UNWRITTEN, student="cleo"),
        samples.refused("dora.ipynb is not valid JSON.", student="dora"),
        names=False,
        links={"ada": "ada.html"},
    )
    shown = repr(made).lower()
    assert not [name for name in ("ada", "ben", "cleo", "dora", "lovelace") if name in shown]
    assert [kind.students for kind in made.attention] == [1, 1, 1, 1]
    assert made.time.longest > 0


def test_what_many_did_not_write_and_what_everybody_missed_is_said():
    """Three of five had no points in four exercises, and the page said "Nothing"."""
    wrong = [samples.raised("first", f"E{n}: x") for n in range(5)]
    stub = case("first", NOT_WRITTEN, words=Words.GRADER)
    gone = exercise("gone", "missing", case("first", "gone is not defined."))

    def one(n: int) -> Result:
        written = exercise("gone", *(("failed", stub) if n else ("passed", case("first"))))
        return result(
            gone if n == 3 else written,
            exercise("late", "failed", stub if n < 2 else case("first", f"Text {n}.")),
            exercise("wrong", "failed", wrong[n]),
            exercise("half", "partial", case("first"), case("next", f"Half {n}.")),
            student=f"s{n}",
        )

    made = report(*map(one, range(5)))
    assert made.misunderstood == ()
    assert made.unwritten == (("gone", 4), ("late", 2))
    assert made.missed == (("wrong", 5), ("late", 3))
    assert {e.name: (e.none, e.missing) for e in made.exercises}["late"] == (3, 2)
    text = " ".join(pages.Skeleton(class_pages.html(made)).text.split())
    assert "No single check failed, and no single hint was given, in" in text
    assert "Left empty by" in text and "wrong: 5 of 5 students, everybody" in text
    few = report(*map(one, range(3)))
    assert few.unwritten == few.missed == ()
